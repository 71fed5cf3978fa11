//! What holds for all formats: their choice, limits of memory, and damaged files.

use super::*;
use crate::stats::test_random::Random;

/// Set to read every damaged file, which takes minutes.
const DEEP: &str = "ETENDUE_TEST_DEEP";
/// Of the damaged files, one in so many is read without `DEEP`.
const STRIDE: usize = 23;

macro_rules! fixtures {
    ($($name:literal),*) => {
        [$(($name, include_bytes!(concat!("../../../tests/io/fixtures/volumes/", $name, ".nvdb")).as_slice())),*]
    };
}

/// The NanoVDB files that `make.py` and `make_warp.py` make.
pub(super) const FIXTURES: [(&str, &[u8]); 17] = fixtures!(
    "blosc",
    "cloud",
    "double",
    "empty",
    "fp16",
    "fp4",
    "fp8",
    "fpn",
    "huge",
    "negative",
    "several",
    "sphere",
    "tiles",
    "tiles-without-boxes",
    "two",
    "vector",
    "warp"
);

pub(super) fn fixture(name: &str) -> &'static [u8] {
    FIXTURES.iter().find(|(of, _)| *of == name).expect("a fixture").1
}

/// A Mitsuba volume of one cell.
fn one_cell() -> Vec<u8> {
    let numbers = [1_i32, 1, 1, 1, 1].map(i32::to_le_bytes).concat();
    [b"VOL\x03", &numbers[..], &[0.0_f32, 0.0, 0.0, 1.0, 1.0, 1.0, 2.5].map(f32::to_le_bytes).concat()].concat()
}

fn chain(bytes: &[u8], options: &VolumeOptions<'_>) -> String {
    decode(bytes, options).unwrap_err().chain()
}

#[test]
fn first_bytes_select_the_format_whatever_the_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cloud.vdb");
    for (bytes, size) in [(&one_cell()[..], [1, 1, 1]), (fixture("cloud"), [14, 10, 12])] {
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(read(&path, &VolumeOptions::default()).unwrap().size, size);
    }
    std::fs::write(&path, b" BDV\0\0\0\0\xe0\0\0\0").unwrap();
    let error = read(&path, &VolumeOptions::default()).unwrap_err();
    let start = format!("cannot read {}: it is an OpenVDB file; `nanovdb_convert", path.display());
    assert!(error.chain().starts_with(&start) && error.kind == Kind::Scene, "{}", error.chain());
    for bytes in [&b""[..], b"VO", b"PNG", b"NanoVDB9", b" BDV\0\0\0"] {
        assert!(chain(bytes, &VolumeOptions::default()).contains("neither a Mitsuba volume"), "{bytes:?}");
    }
}

#[test]
fn errors_of_files_name_the_path_once() {
    let folder = tempfile::tempdir().unwrap();
    let options = VolumeOptions { memory: 8, ..VolumeOptions::default() };
    let large = folder.path().join("large.vol");
    std::fs::write(&large, one_cell()).unwrap();
    for (path, what) in [
        (large, "it has 52 bytes, more than the limit of 32"),
        (folder.path().join("none.vol"), "No such file"),
        (folder.path().to_owned(), ""),
    ] {
        let text = read(&path, &options).unwrap_err().chain();
        let named = text.starts_with(&format!("cannot read {}", path.display()));
        assert!(named && text.matches("cannot read").count() == 1 && text.contains(what), "{text}");
    }
}

#[test]
fn memory_is_limited_before_it_is_allocated() {
    let limited = |memory| VolumeOptions { memory, ..VolumeOptions::default() };
    let error = decode(&one_cell(), &limited(3)).unwrap_err();
    assert!(error.chain().contains("1×1×1 cells has 4 bytes, more than the limit of 3"), "{}", error.chain());
    assert_eq!(error.kind, Kind::Memory);
    assert!(decode(&one_cell(), &limited(4)).is_ok());
    let tiles = 151 * 128 * 128 * 4;
    assert!(decode(fixture("tiles"), &limited(tiles)).is_ok());
    assert!(chain(fixture("tiles"), &limited(tiles - 1)).contains("151×128×128 cells has 9895936 bytes, more than"));
    assert!(chain(fixture("tiles"), &limited(307_231)).contains("its grid 'density' has 307232 bytes, more than"));
    let error = decode(fixture("huge"), &VolumeOptions::default()).unwrap_err();
    assert!(error.chain().contains("4096×4096×4096 cells has 274877906944 bytes"), "{}", error.chain());
    assert_eq!(error.kind, Kind::Memory);
}

/// A file cut within a segment is an error, and one with a changed byte is read or an error, within the limit of memory.
#[test]
fn damage_does_not_panic_and_keeps_the_limit() {
    let stride = if std::env::var_os(DEEP).is_some() { 1 } else { STRIDE };
    let options = VolumeOptions { memory: 2 << 20, ..VolumeOptions::default() };
    let mut random = Random::new(7);
    let volume = one_cell();
    for (name, bytes) in FIXTURES.into_iter().chain([("one cell", &volume[..])]) {
        for length in 0..bytes.len() {
            let is_whole = length > 0 && bytes[length..].starts_with(b"NanoVDB0");
            assert!(decode(&bytes[..length], &options).is_err() || is_whole, "{name} cut at {length}");
        }
        for i in (0..bytes.len()).skip(random.bits() as usize % stride).step_by(stride) {
            let mut changed = bytes.to_vec();
            changed[i] ^= 1 << (random.bits() % 8);
            if let Ok(grid) = decode(&changed, &options) {
                assert!(grid.values.len() as u64 * 4 <= options.memory, "{name} at {i}");
                assert_eq!(grid.values.len(), grid.channels * grid.size.iter().product::<usize>(), "{name} at {i}");
            }
        }
    }
}
