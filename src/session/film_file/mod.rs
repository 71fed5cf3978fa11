//! The `.film` format: the exact sums of a film, for checkpoints, shards and merging.
//!
//! All numbers are little-endian. The file holds 8 bytes of magic, a u32 version, the u32 length of the header, the
//! header in JSON, the runs of words, and the BLAKE3 hash of all preceding bytes. A run is stored in blocks (see
//! blocks.rs). The runs are, in this order: the i64 sums of each replicate; the overflow table of each replicate that
//! has one, as (u64 index, i128 multiple of 2⁶⁴) by ascending index; and the largest sample of each pixel as a u64 (see
//! `film::Peaks`).

mod blocks;
#[cfg(test)]
mod tests;

use super::machine;
use crate::error::{Error, Kind, Result};
use crate::film::{Film, FilmHeader, Layout, Sums, add_all, keep_largest};
use crate::io::atomic::write_atomically;
use crate::io::hashed::Hashed;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, Write};
use std::path::{Path, PathBuf};

const MAGIC: [u8; 8] = *b"\x89ETFILM\n";
const VERSION: u32 = 3;
const PREFIX: u64 = 16;
const HASH: u64 = blake3::OUT_LEN as u64;
const MOST_HEADER: u32 = 1 << 24;
const MOST_REPLICATES: u32 = 4096;
/// Limit of sums: 64 GiB, more than an 8K image with all planes and 16 replicates.
const MOST_VALUES: u64 = 1 << 33;
/// Bytes hashed at a time: enough for all threads.
const HASHED: usize = 1 << 22;
/// Words per entry of the overflow table.
const ENTRY: usize = 3;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    provenance: Value,
    film: FilmHeader,
    /// Number of sums of each replicate that overflow an i64.
    beyond: Vec<u64>,
}

/// Writes a film with the caller's provenance document.
///
/// # Errors
/// [`Kind::Output`] with the path if the file cannot be written. An old file is then left untouched.
pub fn write(path: &Path, provenance: &Value, film: &Film) -> Result<()> {
    let beyond = film.sums().iter().map(|sums| sums.high().len() as u64).collect();
    let header = Header { provenance: provenance.clone(), film: film.head().clone(), beyond };
    write_atomically(path, |file| {
        let header = serde_json::to_vec(&header)?;
        let length = u32::try_from(header.len()).ok().filter(|&n| n <= MOST_HEADER);
        let length = length.ok_or_else(|| io::Error::other("the provenance is too long"))?;
        let mut hashed = Hashed::new(BufWriter::new(file));
        hashed.write_all(&MAGIC)?;
        hashed.write_all(&VERSION.to_le_bytes())?;
        hashed.write_all(&length.to_le_bytes())?;
        hashed.write_all(&header)?;
        film.sums().iter().try_for_each(|sums| blocks::write(&mut hashed, bytemuck::cast_slice(sums.low())))?;
        film.sums().iter().try_for_each(|sums| blocks::write(&mut hashed, &table(sums)))?;
        blocks::write(&mut hashed, film.peaks().packed())?;
        let hash = hashed.hasher.finalize();
        hashed.inner.write_all(hash.as_bytes())?;
        hashed.inner.flush()
    })
}

/// The overflow table of the i64 sums, as words.
fn table(sums: &Sums) -> Vec<u64> {
    sums.high().iter().flat_map(|(&index, &high)| [index, high as u64, (high >> 64) as u64]).collect()
}

/// Reads a film and its provenance.
///
/// # Errors
/// [`Kind::Scene`] with the path if the file is missing, not a film, of another version, or damaged; [`Kind::Memory`]
/// if the film does not fit.
pub fn read(path: &Path) -> Result<(Value, Film)> {
    let file = FilmFile::open(path)?;
    Ok((file.provenance.clone(), file.film()?))
}

/// A film file whose header has been read and whose sums have not.
#[derive(Debug)]
pub struct FilmFile {
    path: PathBuf,
    /// Positioned at the first run.
    file: File,
    /// Size of the runs in bytes.
    body: u64,
    provenance: Value,
    head: FilmHeader,
    beyond: Vec<u64>,
}

impl FilmFile {
    /// Reads the header. The integrity of the file is checked when its sums are read.
    ///
    /// # Errors
    /// [`Kind::Scene`] with the path if the file is missing, not a film, of another version, or has an inconsistent
    /// header.
    pub fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(|cause| Error::read(path, cause))?;
        Self::read_header(path, file).map_err(|e| named(path, &e))
    }

    fn read_header(path: &Path, mut file: File) -> Result<Self> {
        let size = file.metadata().map_err(damaged)?.len();
        let length = read_prefix(&mut file)?;
        let body =
            size.checked_sub(PREFIX + HASH + u64::from(length)).ok_or_else(|| Error::scene("it is cut short"))?;
        let mut header = vec![0; length as usize];
        file.read_exact(&mut header).map_err(damaged)?;
        let Header { provenance, film: head, beyond } = serde_json::from_slice(&header).map_err(damaged)?;
        check(&head, &beyond, body)?;
        Ok(FilmFile { path: path.to_owned(), file, body, provenance, head, beyond })
    }

    /// Returns the provenance as the writer stored it.
    pub fn provenance(&self) -> &Value {
        &self.provenance
    }

    /// Returns the film's header, with the passes it holds.
    pub fn head(&self) -> &FilmHeader {
        &self.head
    }

    /// Reads the film.
    ///
    /// # Errors
    /// [`Kind::Scene`] if the file is damaged, [`Kind::Memory`] if the film does not fit; with the path.
    pub fn film(self) -> Result<Film> {
        let path = self.path.clone();
        let read = || {
            let bytes = Film::bytes_per_pixel(&self.head.layout, self.head.replicates) as u64
                * self.head.layout.pixels() as u64;
            machine::affordable("it", bytes, "use a machine with more memory")?;
            let mut film = Film::empty(self.head.clone());
            self.pour(&mut film)?;
            Ok(film)
        };
        read().map_err(|e| named(&path, &e))
    }

    /// Adds the film to `film`, a few blocks at a time.
    ///
    /// # Errors
    /// See [`FilmHeader::admits`]. [`Kind::Scene`] with the path if the file is damaged; `film` is then unusable.
    pub fn add_to(self, film: &mut Film) -> Result<()> {
        film.head_mut().absorb(&self.head)?;
        let path = self.path.clone();
        self.pour(film).map_err(|e| named(&path, &e))
    }

    /// Adds the stored sums to those of `film`.
    fn pour(mut self, film: &mut Film) -> Result<()> {
        self.check_hash()?;
        let mut input = BufReader::new(self.file.take(self.body));
        for sums in film.sums_mut() {
            let add = |first, low: &mut [i64], words: &[u64]| Ok(add_all(low, bytemuck::cast_slice(words), first));
            let carries = blocks::read(&mut input, sums.low_mut(), add)?;
            sums.carry(carries.into_iter().flatten());
        }
        for (sums, &entries) in film.sums_mut().iter_mut().zip(&self.beyond) {
            let carries = read_table(&mut input, entries as usize, sums.low().len())?;
            sums.carry(carries);
        }
        blocks::read(&mut input, film.peaks_mut().packed_mut(), |_, peaks, words| {
            keep_largest(peaks, words).then_some(()).ok_or_else(|| Error::scene("its largest samples are invalid"))
        })?;
        match input.read(&mut [0]).map_err(damaged)? {
            0 => Ok(()),
            _ => Err(Error::scene("it has data past its end")),
        }
    }

    /// Checks the hash of the whole file and seeks back to the first run.
    fn check_hash(&mut self) -> Result<()> {
        let begin = self.file.stream_position().map_err(damaged)?;
        self.file.rewind().map_err(damaged)?;
        let (mut hasher, mut left, mut buffer) = (blake3::Hasher::new(), begin + self.body, vec![0; HASHED]);
        while left > 0 {
            let part = &mut buffer[..left.min(HASHED as u64) as usize];
            self.file.read_exact(part).map_err(damaged)?;
            hasher.update_rayon(part);
            left -= part.len() as u64;
        }
        let mut stored = [0; HASH as usize];
        self.file.read_exact(&mut stored).map_err(damaged)?;
        if hasher.finalize() != stored {
            return Err(Error::scene("it is damaged: its checksum does not match"));
        }
        self.file.seek(io::SeekFrom::Start(begin)).map_err(damaged).map(drop)
    }
}

fn named(path: &Path, error: &Error) -> Error {
    Error::new(error.kind, format!("cannot read film {}: {}", path.display(), error.chain()))
}

fn damaged(cause: impl std::error::Error + Send + Sync + 'static) -> Error {
    Error::scene("it is damaged").because(cause)
}

/// Checks magic and version. Returns the length of the header.
fn read_prefix(file: &mut File) -> Result<u32> {
    let mut prefix = [0; PREFIX as usize];
    let is_film = file.read_exact(&mut prefix).is_ok() && prefix[..8] == MAGIC;
    if !is_film {
        return Err(Error::scene("it is not a film file"));
    }
    let number = |at: usize| u32::from_le_bytes([prefix[at], prefix[at + 1], prefix[at + 2], prefix[at + 3]]);
    if number(8) != VERSION {
        return Err(Error::scene(format!("it has version {}, and this program reads version {VERSION}", number(8))));
    }
    if number(12) > MOST_HEADER {
        return Err(Error::scene("its header is too long"));
    }
    Ok(number(12))
}

/// Checks the sizes in the header against a body of `body` bytes.
fn check(head: &FilmHeader, beyond: &[u64], body: u64) -> Result<()> {
    let layout = &head.layout;
    let crop = layout.crop;
    let has_area = crop.x0 < crop.x1 && crop.x1 <= layout.width && crop.y0 < crop.y1 && crop.y1 <= layout.height;
    if !has_area || Layout::new(layout.width, layout.height, Some(crop), layout.planes()) != *layout {
        return Err(Error::scene("its image layout is invalid"));
    }
    if head.replicates == 0 || head.replicates > MOST_REPLICATES {
        return Err(Error::scene(format!("it claims {} replicates", head.replicates)));
    }
    let pixels = u64::from(crop.x1 - crop.x0) * u64::from(crop.y1 - crop.y0);
    let values = pixels.checked_mul(layout.channels() as u64).filter(|&n| n <= MOST_VALUES);
    let Some(values) = values.filter(|&n| n * u64::from(head.replicates) <= MOST_VALUES) else {
        return Err(Error::scene("it claims more pixels than it can hold"));
    };
    if beyond.len() != head.replicates as usize || beyond.iter().any(|&entries| entries > values) {
        return Err(Error::scene("its overflow table is invalid"));
    }
    let words = values * u64::from(head.replicates) + beyond.iter().sum::<u64>() * ENTRY as u64 + pixels;
    if words > blocks::most_words(body) {
        return Err(Error::scene("it claims more pixels than it can hold"));
    }
    Ok(())
}

/// Reads the overflow table of a replicate: multiples of 2⁶⁴ by index.
fn read_table(input: &mut impl Read, entries: usize, values: usize) -> Result<Vec<(u64, i128)>> {
    let mut words = Vec::new();
    words
        .try_reserve_exact(entries * ENTRY)
        .map_err(|_| Error::new(Kind::Memory, "its sums do not fit into memory"))?;
    words.resize(entries * ENTRY, 0);
    blocks::read(input, &mut words, |_, table, words| {
        table.copy_from_slice(words);
        Ok(())
    })?;
    let entries =
        words.chunks_exact(ENTRY).map(|entry| (entry[0], i128::from(entry[2] as i64) << 64 | i128::from(entry[1])));
    let entries: Vec<_> = entries.collect();
    let is_ascending = entries.windows(2).all(|pair| pair[0].0 < pair[1].0);
    if !is_ascending || entries.iter().any(|&(index, high)| index >= values as u64 || high == 0) {
        return Err(Error::scene("its overflow table is invalid"));
    }
    Ok(entries)
}
