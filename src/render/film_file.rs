//! `.film`: the exact sums of a film, for checkpoints, shards and merging.
//!
//! All numbers are little-endian: 8 bytes of magic, u32 version, u32 length of the header, the header in JSON, one zstd stream,
//! and the BLAKE3 hash of all that. The stream has the i64 sums replicate by replicate, then for each replicate the sparse
//! table of what lies above them: u64 count, then (u64 index, i128 multiple of 2⁶⁴) by ascending index; last, for each pixel,
//! its largest sample as a u64 (see `film::Peaks`).

use crate::error::{Error, Kind, Result};
use crate::film::{Film, Layout, PassSet, Peaks, Sums, Units};
use crate::io::atomic::write_atomically;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;

const MAGIC: [u8; 8] = *b"\x89ETFILM\n";
const VERSION: u32 = 2;
const PREFIX: u64 = 16;
const HASH: u64 = blake3::OUT_LEN as u64;
const MOST_HEADER: u32 = 1 << 24;
const MOST_REPLICATES: u32 = 4096;
/// 64 GiB of sums: beyond an 8K image of all planes at 16 replicates.
const MOST_VALUES: u64 = 1 << 33;
/// zstd cannot expand more than 128 KiB from 4 bytes.
const MOST_EXPANSION: u64 = 1 << 15;
/// A compressor level that keeps up with the disk: checkpoints are written while rendering.
const LEVEL: i32 = 1;
/// Values that are coded at a time.
const RUN: usize = 8192;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    provenance: serde_json::Value,
    layout: Layout,
    replicates: u32,
    seed: u64,
    /// Exponents of two, since JSON may round a float.
    units: [i32; 2],
    passes: PassSet,
    dropped: u64,
}

/// Writes a film with whatever the caller needs to know about where it came from.
///
/// # Errors
/// [`Kind::Output`] with the path if the file cannot be written; an old file is then untouched.
pub fn write(path: &Path, provenance: &serde_json::Value, film: &Film) -> Result<()> {
    let header = Header {
        provenance: provenance.clone(),
        layout: film.layout().clone(),
        replicates: film.replicates(),
        seed: film.seed(),
        units: film.units().exponents().unwrap_or_default(),
        passes: film.passes().clone(),
        dropped: film.dropped(),
    };
    write_atomically(path, |file| {
        let header = serde_json::to_vec(&header)?;
        let length = u32::try_from(header.len()).ok().filter(|&n| n <= MOST_HEADER);
        let length = length.ok_or_else(|| io::Error::other("the provenance is too long"))?;
        let mut hashed = Hashed { file: BufWriter::new(file), hasher: blake3::Hasher::new() };
        hashed.write_all(&MAGIC)?;
        hashed.write_all(&VERSION.to_le_bytes())?;
        hashed.write_all(&length.to_le_bytes())?;
        hashed.write_all(&header)?;
        let mut stream = zstd::Encoder::new(&mut hashed, LEVEL)?;
        film.sums().iter().try_for_each(|sums| write_words(&mut stream, sums.low(), i64::to_le_bytes))?;
        film.sums().iter().try_for_each(|sums| write_high(&mut stream, sums))?;
        write_words(&mut stream, film.peaks().packed(), u64::to_le_bytes)?;
        stream.finish()?;
        let hash = hashed.hasher.finalize();
        hashed.file.write_all(hash.as_bytes())?;
        hashed.file.flush()
    })
}

fn write_words<T: Copy>(out: &mut impl Write, words: &[T], bytes_of: fn(T) -> [u8; 8]) -> io::Result<()> {
    for run in words.chunks(RUN) {
        let bytes: Vec<u8> = run.iter().flat_map(|&word| bytes_of(word)).collect();
        out.write_all(&bytes)?;
    }
    Ok(())
}

fn write_high(out: &mut impl Write, sums: &Sums) -> io::Result<()> {
    out.write_all(&(sums.high().len() as u64).to_le_bytes())?;
    for (index, high) in sums.high() {
        out.write_all(&index.to_le_bytes())?;
        out.write_all(&high.to_le_bytes())?;
    }
    Ok(())
}

/// A writer that hashes what passes through.
struct Hashed<W> {
    file: W,
    hasher: blake3::Hasher,
}

impl<W: Write> Write for Hashed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let n = self.file.write(bytes)?;
        self.hasher.update(&bytes[..n]);
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Reads a film and its provenance.
///
/// # Errors
/// [`Kind::Scene`] with the path if the file is missing, not a film, of another version, or damaged; [`Kind::Memory`] if the
/// film does not fit.
pub fn read(path: &Path) -> Result<(serde_json::Value, Film)> {
    let mut file = File::open(path).map_err(|cause| Error::read(path, cause))?;
    let result = read_from(&mut file);
    result.map_err(|e| Error::new(e.kind, format!("cannot read film {}: {}", path.display(), e.chain())))
}

fn read_from(file: &mut File) -> Result<(serde_json::Value, Film)> {
    let size = file.metadata().map_err(damaged)?.len();
    let header_length = read_prefix(file)?;
    let body = size.checked_sub(PREFIX + HASH + u64::from(header_length)).ok_or_else(|| Error::scene("it is cut short"))?;
    check_hash(file, size)?;
    file.seek(SeekFrom::Start(PREFIX)).map_err(damaged)?;
    let mut header = vec![0; header_length as usize];
    file.read_exact(&mut header).map_err(damaged)?;
    let header: Header = serde_json::from_slice(&header).map_err(damaged)?;
    let values = check(&header, body)?;
    let units = Units::from_exponents(header.units[0], header.units[1]).ok_or_else(|| Error::scene("its units are invalid"))?;
    let mut stream = zstd::Decoder::new(BufReader::new(file.take(body))).map_err(damaged)?;
    let sums = read_sums(&mut stream, header.replicates, values)?;
    let peaks = read_words(&mut stream, header.layout.pixels(), u64::from_le_bytes)?;
    let peaks = Peaks::from_packed(peaks).ok_or_else(|| Error::scene("its largest samples are invalid"))?;
    if stream.read(&mut [0]).map_err(damaged)? != 0 {
        return Err(Error::scene("it has data past its end"));
    }
    let film = Film::from_parts(header.layout, header.seed, units, header.passes, header.dropped, sums, peaks);
    Ok((header.provenance, film.ok_or_else(|| Error::scene("its parts do not fit together"))?))
}

fn damaged(cause: impl std::error::Error + Send + Sync + 'static) -> Error {
    Error::scene("it is damaged").because(cause)
}

/// Checks magic and version; the length of the header.
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

fn check_hash(file: &mut File, size: u64) -> Result<()> {
    file.rewind().map_err(damaged)?;
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(Read::take(&mut *file, size - HASH)).map_err(damaged)?;
    let mut stored = [0; HASH as usize];
    file.read_exact(&mut stored).map_err(damaged)?;
    if hasher.finalize() == stored { Ok(()) } else { Err(Error::scene("it is damaged: its checksum does not match")) }
}

/// Whether sizes make sense; the number of values of a replicate.
fn check(header: &Header, body: u64) -> Result<usize> {
    let layout = &header.layout;
    let crop = layout.crop;
    let has_area = crop.x0 < crop.x1 && crop.x1 <= layout.width && crop.y0 < crop.y1 && crop.y1 <= layout.height;
    if !has_area || Layout::new(layout.width, layout.height, Some(crop), layout.planes()) != *layout {
        return Err(Error::scene("its image layout is invalid"));
    }
    if header.replicates == 0 || header.replicates > MOST_REPLICATES {
        return Err(Error::scene(format!("it claims {} replicates", header.replicates)));
    }
    let pixels = u64::from(crop.x1 - crop.x0) * u64::from(crop.y1 - crop.y0);
    let values = pixels.checked_mul(layout.channels() as u64).filter(|&n| n <= MOST_VALUES);
    let all = values.map(|n| n * u64::from(header.replicates)).filter(|&n| n <= MOST_VALUES);
    if all.is_none_or(|n| n * 8 > body.saturating_mul(MOST_EXPANSION)) {
        return Err(Error::scene("it claims more pixels than it can hold"));
    }
    values.and_then(|n| usize::try_from(n).ok()).ok_or_else(|| Error::scene("it is too large for this machine"))
}

fn read_sums(stream: &mut impl Read, replicates: u32, values: usize) -> Result<Vec<Sums>> {
    let low = (0..replicates).map(|_| read_words(stream, values, i64::from_le_bytes));
    let low: Vec<Vec<i64>> = low.collect::<Result<_>>()?;
    let sums = low.into_iter().map(|low| {
        let high = read_high(stream, low.len())?;
        Sums::from_parts(low, high).ok_or_else(|| Error::scene("its overflow table is invalid"))
    });
    sums.collect()
}

/// Memory is touched only as values arrive.
fn read_words<T>(stream: &mut impl Read, count: usize, of_bytes: fn([u8; 8]) -> T) -> Result<Vec<T>> {
    let mut words = Vec::new();
    words.try_reserve_exact(count).map_err(|_| Error::new(Kind::Memory, "its sums do not fit into memory"))?;
    let mut bytes = [0; 8 * RUN];
    while words.len() < count {
        let run = &mut bytes[..8 * RUN.min(count - words.len())];
        stream.read_exact(run).map_err(damaged)?;
        words.extend(run.chunks_exact(8).map(|b| of_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]])));
    }
    Ok(words)
}

fn read_high(stream: &mut impl Read, values: usize) -> Result<BTreeMap<u64, i128>> {
    let mut next = || -> Result<u64> {
        let mut bytes = [0; 8];
        stream.read_exact(&mut bytes).map_err(damaged)?;
        Ok(u64::from_le_bytes(bytes))
    };
    let count = next()?;
    if count > values as u64 {
        return Err(Error::scene("its overflow table is invalid"));
    }
    let mut high = BTreeMap::new();
    let mut after = 0;
    for _ in 0..count {
        let (index, low_half, high_half) = (next()?, next()?, next()?);
        if index < after || index >= values as u64 {
            return Err(Error::scene("its overflow table is invalid"));
        }
        after = index + 1;
        high.insert(index, (i128::from(high_half as i64) << 64) | i128::from(low_half));
    }
    Ok(high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Crop, PassFilm, Plane};
    use crate::stats::test_random::Random;
    use rayon::iter::ParallelIterator;
    use std::fs;

    /// Some passes of values that need the overflow table too.
    fn film() -> Film {
        let layout = Layout::new(9, 8, Some(Crop { x0: 1, y0: 1, x1: 8, y1: 7 }), &[Plane::Depth, Plane::Invalid]);
        let mut film = Film::new(layout.clone(), 3, u64::MAX - 5, Units::from_exponents(-30, -200).unwrap());
        let mut pass = PassFilm::new(&layout);
        for k in [0, 1, 2, 5, 1 << 60] {
            pass.par_chunks(1).for_each(|(p, out)| {
                let mut random = Random::new(p as u64 + k);
                out.iter_mut().for_each(|v| *v = random.normal() as f32);
                out[4] = random.normal() as f32 * 1e-12;
                out[3] = 1e20;
                out[2] = if p % 5 == 0 { -1e25 } else { 0.0 };
            });
            film.commit(k, &pass);
        }
        film
    }

    /// A file with this header and body and a valid checksum.
    fn forge(path: &Path, header: &str, body: &[u8]) {
        let mut bytes = [&MAGIC[..], &VERSION.to_le_bytes(), &(header.len() as u32).to_le_bytes(), header.as_bytes()].concat();
        bytes.extend(zstd::encode_all(body, 1).unwrap());
        let hash = blake3::hash(&bytes);
        bytes.extend(hash.as_bytes());
        fs::write(path, bytes).unwrap();
    }

    fn header_of(path: &Path) -> (String, Vec<u8>) {
        let bytes = fs::read(path).unwrap();
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let body = zstd::decode_all(&bytes[16 + length..bytes.len() - 32]).unwrap();
        (String::from_utf8(bytes[16..16 + length].to_vec()).unwrap(), body)
    }

    #[test]
    fn round_trips_exactly() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.film");
        let provenance = serde_json::json!({ "scene": "α", "build": [1, 2.5, null] });
        let film = film();
        assert!(film.sums().iter().all(|s| !s.high().is_empty()));
        write(&path, &provenance, &film).unwrap();
        assert_eq!(read(&path).unwrap(), (provenance, film));
    }

    #[test]
    fn every_flipped_byte_and_every_cut_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let (path, damaged) = (folder.path().join("a.film"), folder.path().join("b.film"));
        write(&path, &serde_json::json!("here"), &film()).unwrap();
        let bytes = fs::read(&path).unwrap();
        let refused = |bytes: &[u8]| {
            fs::write(&damaged, bytes).unwrap();
            let error = read(&damaged).unwrap_err();
            assert!(error.kind == Kind::Scene && error.to_string().contains("b.film"), "{error}");
            error.to_string()
        };
        let header = 16 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        for at in (0..header).chain((header..bytes.len()).step_by(37)).chain(bytes.len() - 32..bytes.len()) {
            let mut changed = bytes.clone();
            changed[at] ^= 0x20;
            refused(&changed);
        }
        for length in (0..50).map(|i| i * bytes.len() / 50) {
            refused(&bytes[..length]);
        }
        let mut newer = bytes.clone();
        newer[8] = 7;
        assert!(refused(&newer).contains("version 7"));
        assert!(refused(b"hello").contains("not a film"));
        assert!(refused(&[&bytes[..], b"x"].concat()).contains("checksum"));
    }

    /// Lies under a valid checksum.
    #[test]
    fn absurd_headers_and_bodies_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.film");
        write(&path, &serde_json::Value::Null, &film()).unwrap();
        let (header, body) = header_of(&path);
        forge(&path, &header, &body);
        assert_eq!(read(&path).unwrap().1, film());
        for (from, to) in [
            ("\"replicates\":3", "\"replicates\":0"),
            ("\"replicates\":3", "\"replicates\":4"),
            ("\"replicates\":3", "\"replicates\":4294967295"),
            ("\"x1\":8", "\"x1\":0"),
            ("\"x1\":8", "\"x1\":10"),
            (
                "\"width\":9,\"height\":8,\"crop\":{\"x0\":1,\"y0\":1,\"x1\":8,\"y1\":7}",
                "\"width\":4294967295,\"height\":4294967295,\"crop\":{\"x0\":0,\"y0\":0,\"x1\":4294967295,\"y1\":4294967295}",
            ),
            (
                "\"width\":9,\"height\":8,\"crop\":{\"x0\":1,\"y0\":1,\"x1\":8,\"y1\":7}",
                "\"width\":30000,\"height\":30000,\"crop\":{\"x0\":0,\"y0\":0,\"x1\":30000,\"y1\":30000}",
            ),
            ("[\"color\",", "[\"color\",\"color\","),
            ("[\"color\",", "["),
            ("\"units\":[-30", "\"units\":[-300"),
            ("\"passes\":[[0,3]", "\"passes\":[[3,0]"),
            ("\"seed\"", "\"sead\""),
            ("\"provenance\":null", "\"provenance\":[[[["),
        ] {
            assert!(header.contains(from), "{from} in {header}");
            forge(&path, &header.replace(from, to), &body);
            let error = read(&path).unwrap_err();
            assert_eq!(error.kind, Kind::Scene, "{to}: {error}");
        }
        let low = 42 * 6 * 3 * 8;
        let mut no_index = body.clone();
        no_index[low + 8..low + 16].fill(0xff);
        let mut many = body.clone();
        many[low..low + 8].fill(0x7f);
        let mut zero = body.clone();
        zero[low + 16..low + 32].fill(0);
        let mut peak = body.clone();
        let last = body.len() - 1;
        peak[last] = 0xff;
        for bad in
            [no_index, many, zero, peak, body[..low - 8].to_vec(), body[..body.len() - 1].to_vec(), [&body[..], b"x"].concat()]
        {
            forge(&path, &header, &bad);
            assert_eq!(read(&path).unwrap_err().kind, Kind::Scene);
        }
    }
}
