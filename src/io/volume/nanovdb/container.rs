//! Finds a grid in a file: segments of grids with metadata, or a raw buffer of grids one after the other.

use super::super::bytes::Bytes;
use super::super::{VolumeOptions, reserved, too_large};
use crate::error::{Error, Result};
use std::borrow::Cow;
use std::io::Read;

/// First bytes of a grid, and of a segment, until version 32.5; both differ since.
const OLD_MAGIC: &[u8] = b"NanoVDB0";
const GRID_MAGIC: &[u8] = b"NanoVDB1";
const FILE_MAGIC: &[u8] = b"NanoVDB2";
/// First bytes on a big-endian machine, without the last digit.
const BIG_ENDIAN_MAGIC: &[u8] = b"BDVonaN";
/// The supported major version, which fixes the layout.
const MAJOR_VERSION: u32 = 32;
/// Size of a segment's header, of the metadata of a grid without its name, and of a grid's header with its tree's.
const SEGMENT_HEADER: usize = 16;
const METADATA: usize = 176;
const GRID_HEADER: usize = 672 + 64;
/// Length of the name in the header of a grid.
const NAME: usize = 256;
/// The grid that is read of several, if none is asked for.
const DEFAULT_GRID: &str = "density";
/// Largest ratio of the deflate format, of 258 bytes from two bits.
const LARGEST_RATIO: usize = 1032;

/// Whether the file begins like one of NanoVDB.
pub(in super::super) fn is_nanovdb(bytes: &[u8]) -> bool {
    let is_big_endian = bytes.get(1..).is_some_and(|rest| rest.starts_with(BIG_ENDIAN_MAGIC));
    [OLD_MAGIC, GRID_MAGIC, FILE_MAGIC].iter().any(|magic| bytes.starts_with(magic)) || is_big_endian
}

/// Whether a grid begins here.
pub(super) fn is_grid(bytes: Bytes<'_>) -> bool {
    bytes.0.starts_with(OLD_MAGIC) || bytes.0.starts_with(GRID_MAGIC)
}

/// Fails unless the layout is that of the supported version.
pub(super) fn check_version(version: u32) -> Result<()> {
    if major(version) == MAJOR_VERSION {
        return Ok(());
    }
    let (major, minor) = (major(version), version >> 10 & 0x7ff);
    Err(Error::scene(format!("it is of NanoVDB's version {major}.{minor}, and only {MAJOR_VERSION} is supported")))
}

fn major(version: u32) -> u32 {
    version >> 21
}

/// A grid in a file.
struct Entry<'a> {
    name: String,
    /// Bytes of the grid when it is not compressed.
    size: usize,
    codec: u16,
    /// Bytes in the file, without the length before them.
    stored: Bytes<'a>,
}

/// Returns the grid of the options with its name, inflated if it is compressed.
pub(super) fn grid<'a>(bytes: Bytes<'a>, options: &VolumeOptions<'_>) -> Result<(String, Cow<'a, [u8]>)> {
    if bytes.0.get(1..).is_some_and(|rest| rest.starts_with(BIG_ENDIAN_MAGIC)) {
        return Err(Error::scene("it was written on a big-endian machine, which is not supported"));
    }
    let entries = if is_raw(bytes)? { raw(bytes)? } else { segments(bytes)? };
    let entry = chosen(entries, options.grid)?;
    let grid = match entry.codec {
        0 => Cow::Borrowed(entry.stored.part(0, entry.size)?.0),
        1 => Cow::Owned(inflated(&entry, options.memory)?),
        2 => return Err(Error::scene("it is compressed with BLOSC; write it with ZIP (`nanovdb_convert --zip`)")),
        codec => return Err(Error::scene(format!("it is compressed with the unknown codec {codec}"))),
    };
    Ok((entry.name, grid))
}

/// Whether the file is a buffer of grids. With the old magic, only the place of the version tells it from a segment.
fn is_raw(bytes: Bytes<'_>) -> Result<bool> {
    if bytes.0.starts_with(OLD_MAGIC) {
        return Ok(major(bytes.u32(8)?) != MAJOR_VERSION && major(bytes.u32(16)?) == MAJOR_VERSION);
    }
    Ok(bytes.0.starts_with(GRID_MAGIC))
}

/// Lists the grids of a buffer.
fn raw(bytes: Bytes<'_>) -> Result<Vec<Entry<'_>>> {
    let (mut entries, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        let header = bytes.part(at, GRID_HEADER)?;
        if !is_grid(header) {
            return Err(Error::scene(format!("its byte {at} begins no grid")));
        }
        let size = header.length(32)?;
        if size < GRID_HEADER {
            return Err(Error::scene(format!("its grid at byte {at} claims to have {size} bytes")));
        }
        entries.push(Entry { name: header.text(40, NAME)?, size, codec: 0, stored: bytes.part(at, size)? });
        at += size;
    }
    Ok(entries)
}

/// Lists the grids of all segments.
fn segments(bytes: Bytes<'_>) -> Result<Vec<Entry<'_>>> {
    let (mut entries, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        let header = bytes.part(at, SEGMENT_HEADER)?;
        if !header.0.starts_with(OLD_MAGIC) && !header.0.starts_with(FILE_MAGIC) {
            return Err(Error::scene(format!("its byte {at} begins no segment of grids")));
        }
        check_version(header.u32(8)?)?;
        let (count, codec) = (header.u16(12)?, header.u16(14)?);
        at += SEGMENT_HEADER;
        let mut heads = Vec::new();
        for _ in 0..count {
            let metadata = bytes.part(at, METADATA)?;
            let length = metadata.u32(136)? as usize;
            heads.push((metadata, bytes.text(at + METADATA, length)?));
            at += METADATA + length;
        }
        for (metadata, name) in heads {
            let size = metadata.length(0)?;
            // Before a compressed grid is its length. NVIDIA Warp does not count these 8 bytes in the metadata.
            let (start, length) = if codec == 1 { (at + 8, bytes.length(at)?) } else { (at, metadata.length(8)?) };
            let stored = bytes.part(start, length)?;
            entries.push(Entry { name, size, codec, stored });
            at = start + length;
        }
    }
    Ok(entries)
}

/// Selects the grid of that name, or the only one, or the default.
fn chosen<'a>(mut entries: Vec<Entry<'a>>, wanted: Option<&str>) -> Result<Entry<'a>> {
    let found = match wanted {
        None if entries.len() == 1 => Some(0),
        _ => entries.iter().position(|entry| entry.name == wanted.unwrap_or(DEFAULT_GRID)),
    };
    let names = || entries.iter().map(|entry| format!("'{}'", entry.name)).collect::<Vec<_>>().join(", ");
    match (found, wanted) {
        (Some(found), _) => Ok(entries.swap_remove(found)),
        (None, _) if entries.is_empty() => Err(Error::scene("it has no grids")),
        (None, Some(wanted)) => Err(Error::scene(format!("it has no grid '{wanted}', only {}", names()))),
        (None, None) => Err(Error::scene(format!("it has several grids, none of them '{DEFAULT_GRID}': {}", names()))),
    }
}

/// Inflates a grid.
fn inflated(entry: &Entry<'_>, memory: u64) -> Result<Vec<u8>> {
    let size = entry.size;
    if size as u64 > memory {
        return Err(too_large(&format!("its grid '{}'", entry.name), size as u64, memory));
    }
    let broken = |what: String| Error::scene(format!("its compressed grid '{}' {what}", entry.name));
    let possible = entry.stored.len().saturating_mul(LARGEST_RATIO);
    if size > possible {
        return Err(broken(format!("claims {size} bytes, more than {} bytes can hold", entry.stored.len())));
    }
    let mut grid = reserved(size + 1, &format!("its grid '{}'", entry.name))?;
    let mut decoder = flate2::read::ZlibDecoder::new(entry.stored.0).take(size as u64 + 1);
    decoder.read_to_end(&mut grid).map_err(|cause| broken("is damaged".into()).because(cause))?;
    if grid.len() != size {
        return Err(broken(format!("has {} bytes and not the {size} of its metadata", grid.len())));
    }
    Ok(grid)
}
