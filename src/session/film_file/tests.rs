//! Tests of film files.

use super::*;
use crate::film::{Crop, PassFilm, Plane, Units};
use crate::stats::test_random::Random;
use rayon::iter::ParallelIterator;
use std::fs;

fn layout() -> Layout {
    Layout::new(9, 8, Some(Crop { x0: 1, y0: 1, x1: 8, y1: 7 }), &[Plane::Depth, Plane::Invalid])
}

/// A film with the given passes, whose values also exercise the overflow table.
fn film_of(layout: &Layout, passes: &[u64]) -> Film {
    let mut film = Film::new(layout.clone(), 3, u64::MAX - 5, Units::from_exponents(-30, -200).unwrap());
    let mut pass = PassFilm::new(layout);
    for &k in passes {
        pass.par_chunks(1).for_each(|(p, out)| {
            let mut random = Random::new(p as u64 + k);
            out.iter_mut().for_each(|v| *v = random.normal() as f32);
            out[4] = random.normal() as f32 * 1e-12;
            out[3] = 1e20;
            out[2] = if p % 5 == 0 { -1e25 } else { 0.0 };
            // Two of these sums overflow an i64, one does not.
            out[1] = if p % 7 == 0 { 6e9 } else { out[1] };
        });
        film.commit(k, &pass);
    }
    film
}

fn film() -> Film {
    film_of(&layout(), &[0, 1, 2, 5, 1 << 60])
}

/// Forges a file with this header and these runs, each one block, and a valid checksum.
fn forge(path: &Path, header: &str, runs: &[Vec<u8>]) {
    let prefix = [&MAGIC[..], &VERSION.to_le_bytes(), &(header.len() as u32).to_le_bytes(), header.as_bytes()].concat();
    let frames = runs.iter().map(|run| zstd::encode_all(&run[..], 1).unwrap());
    let blocks = frames.flat_map(|frame| [(frame.len() as u32).to_le_bytes().to_vec(), frame].concat());
    let mut bytes: Vec<u8> = prefix.into_iter().chain(blocks).collect();
    let hash = blake3::hash(&bytes);
    bytes.extend(hash.as_bytes());
    fs::write(path, bytes).unwrap();
}

/// Header and decompressed runs.
fn parts_of(path: &Path) -> (String, Vec<Vec<u8>>) {
    let bytes = fs::read(path).unwrap();
    let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let (mut at, mut runs) = (16 + number(12), Vec::new());
    let header = String::from_utf8(bytes[16..at].to_vec()).unwrap();
    while at < bytes.len() - 32 {
        let end = at + 4 + number(at);
        runs.push(zstd::decode_all(&bytes[at + 4..end]).unwrap());
        at = end;
    }
    (header, runs)
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

/// Runs of many blocks with a short last one, and several batches for any number of threads. The addition also produces
/// carries.
#[test]
fn films_of_many_blocks_add_up_to_their_merger() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.film");
    let layout = Layout::new(700, 301, None, &[Plane::Depth, Plane::Invalid]);
    assert!(layout.pixels() * layout.channels() > 16 * blocks::WORDS);
    let (even, odd) = (film_of(&layout, &[0, 2]), film_of(&layout, &[1, 3, 4]));
    let mut merged = even.clone();
    merged.merge(&odd).unwrap();
    write(&path, &Value::Null, &odd).unwrap();
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut added = even.clone();
        pool.install(|| FilmFile::open(&path).unwrap().add_to(&mut added)).unwrap();
        assert!(added == merged);
        let again = folder.path().join("b.film");
        pool.install(|| write(&again, &Value::Null, &odd)).unwrap();
        assert!(fs::read(&again).unwrap() == fs::read(&path).unwrap());
    }
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

/// Invalid headers under a valid checksum.
#[test]
fn absurd_headers_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.film");
    write(&path, &Value::Null, &film()).unwrap();
    let (header, runs) = parts_of(&path);
    forge(&path, &header, &runs);
    assert_eq!(read(&path).unwrap().1, film());
    let size = "\"width\":9,\"height\":8,\"crop\":{\"x0\":1,\"y0\":1,\"x1\":8,\"y1\":7}";
    let square = |n: u32| format!("\"width\":{n},\"height\":{n},\"crop\":{{\"x0\":0,\"y0\":0,\"x1\":{n},\"y1\":{n}}}");
    for (from, to) in [
        ("\"replicates\":3", "\"replicates\":0"),
        ("\"replicates\":3", "\"replicates\":4"),
        ("\"replicates\":3", "\"replicates\":4294967295"),
        ("\"x1\":8", "\"x1\":0"),
        ("\"x1\":8", "\"x1\":10"),
        (size, &square(u32::MAX)),
        (size, &square(30_000)),
        ("[\"color\",", "[\"color\",\"color\","),
        ("[\"color\",", "["),
        ("\"units\":[-30", "\"units\":[-300"),
        ("\"passes\":[[0,3]", "\"passes\":[[3,0]"),
        ("\"beyond\":[93", "\"beyond\":[92"),
        ("\"beyond\":[93", "\"beyond\":[94"),
        ("\"beyond\":[93", "\"beyond\":[18446744073709551615"),
        ("\"beyond\":[93,", "\"beyond\":["),
        ("\"seed\"", "\"sead\""),
        ("\"provenance\":null", "\"provenance\":[[[["),
    ] {
        assert!(header.contains(from), "{from} in {header}");
        forge(&path, &header.replace(from, to), &runs);
        let error = read(&path).unwrap_err();
        assert_eq!(error.kind, Kind::Scene, "{to}: {error}");
    }
}

/// Invalid runs under a valid checksum.
#[test]
fn absurd_runs_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.film");
    write(&path, &Value::Null, &film()).unwrap();
    let (header, runs) = parts_of(&path);
    assert_eq!(runs.len(), 7, "three replicates, their tables, the largest samples");
    // The lowest bytes of all words come first. A table entry has three words: index, low half and high half.
    let words = runs[3].len() / 8;
    let byte = |word: usize, place: usize| place * words + word;
    let changed = |run: usize, changes: &[(usize, u8)]| {
        let mut runs = runs.clone();
        changes.iter().for_each(|&(at, to)| runs[run][at] = to);
        runs
    };
    let no_index = changed(3, &[(byte(0, 7), 0xff)]);
    let twice = changed(3, &[(byte(3, 0), runs[3][byte(0, 0)])]);
    let zero: Vec<_> = (0..8).flat_map(|place| [(byte(1, place), 0), (byte(2, place), 0)]).collect();
    let peak = changed(6, &[(runs[6].len() - 1, 0xff)]);
    let mut short = runs.clone();
    short[0].pop();
    let mut long = runs.clone();
    long[0].push(0);
    let more = [&runs[..], &[vec![0; 8]]].concat();
    for bad in [no_index, twice, changed(3, &zero), peak, short, long, more, runs[..6].to_vec(), vec![]] {
        forge(&path, &header, &bad);
        assert_eq!(read(&path).unwrap_err().kind, Kind::Scene);
    }
}
