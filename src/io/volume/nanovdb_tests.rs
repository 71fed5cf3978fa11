//! NanoVDB files against the numbers that tests/io/fixtures/volumes/make.py gave to OpenVDB, and changed grids.

use super::super::tests::fixture;
use super::super::{VolumeOptions, decode as decode_any};
use super::*;
use crate::error::Kind;
use crate::stats::test_random::Random;

/// First and last active cells of `density_grid`.
const CLOUD: [[i64; 3]; 2] = [[-6, 3, -9], [7, 12, 2]];
const PUFF: [[i64; 3]; 2] = [[7, 8, 6], [18, 17, 15]];
/// Offset of the root in the grids of NanoVDB 32.4.
const ROOT: usize = 672 + 64;

fn read(name: &str) -> VolumeGrid {
    decode_any(fixture(name), &VolumeOptions::default()).unwrap_or_else(|e| panic!("{name}: {}", e.chain()))
}

/// The grid of a file as it is in memory.
fn inflated(name: &str) -> Vec<u8> {
    container::grid(Bytes(fixture(name)), &VolumeOptions::default()).unwrap().1.into_owned()
}

/// The error of a raw buffer, with its kind.
fn refusal(grid: &[u8]) -> (Kind, String) {
    let error = decode_any(grid, &VolumeOptions::default()).expect_err("a broken grid");
    (error.kind, error.chain())
}

/// The value that `density_grid` gives to a cell, active or not.
fn density([first, last]: [[i64; 3]; 2], cell: [i64; 3]) -> f32 {
    let [i, j, k] = cell;
    if cell == first {
        return 1.0;
    }
    if cell == last {
        return 2.0;
    }
    if cell == [last[0] + 1, last[1], last[2]] {
        return 5.0;
    }
    let is_inside = (0..3).all(|axis| (first[axis]..=last[axis]).contains(&cell[axis]));
    match is_inside {
        true if (i + j + k) % 5 != 0 => (8 + (3 * i + 5 * j + 7 * k).rem_euclid(17)) as f32 / 64.0,
        true if (i + j) % 2 == 0 => 0.1875,
        true => 0.75,
        false => 0.0,
    }
}

/// The cells of a grid whose first cell is `low`, in the order of its values.
fn cells(grid: &VolumeGrid, low: [i64; 3]) -> impl Iterator<Item = [i64; 3]> + use<> {
    let [x, y, z] = grid.size.map(|side| side as i64);
    (0..z).flat_map(move |k| (0..y).flat_map(move |j| (0..x).map(move |i| [low[0] + i, low[1] + j, low[2] + k])))
}

#[test]
fn a_float_grid_has_the_values_of_openvdb() {
    let grid = read("cloud");
    assert_eq!((grid.size, grid.channels), ([14, 10, 12], 1));
    let expected: Vec<f32> = cells(&grid, CLOUD[0]).map(|cell| density(CLOUD, cell)).collect();
    assert_eq!(grid.values, expected);
}

/// Codes are rounded to the nearest, so that the error is half of the leaf's quantum. Rounding of the sum, of magnitude
/// up to 5, adds 2⁻²¹.
#[test]
fn quantised_grids_are_within_half_a_quantum() {
    let rounding = 2.0_f32.powi(-21);
    for (name, bits) in [("fp4", Some(4)), ("fp8", Some(8)), ("fp16", Some(16)), ("fpn", None)] {
        let grid = read(name);
        assert_eq!(grid.size, [12, 10, 10], "{name}");
        let mut largest = 0.0_f32;
        for (cell, &value) in cells(&grid, PUFF[0]).zip(&grid.values) {
            let corner = cell.map(|at| at & !7);
            let leaf =
                (0..512).map(|n| density(PUFF, [corner[0] + (n >> 6), corner[1] + (n >> 3 & 7), corner[2] + (n & 7)]));
            let (low, high) = leaf.fold((f32::MAX, f32::MIN), |(low, high), v| (low.min(v), high.max(v)));
            // FpN chooses the bits so that the error is within the --abs-error of make.py.
            let bound = bits.map_or(0.002, |bits| (high - low) / ((1 << bits) - 1) as f32 / 2.0);
            let error = (value - density(PUFF, cell)).abs();
            assert!(error <= bound + rounding, "{name}: {error} in cell {cell:?}, at most {bound}");
            largest = largest.max(error);
        }
        assert!(largest > 0.0, "{name} is not quantised");
    }
}

#[test]
fn a_rotated_sheared_and_scaled_grid_is_in_its_place() {
    let axes = [DVec3::new(0.3, 0.4, 0.0), DVec3::new(-0.6, 0.45, 0.125), DVec3::new(0.05, -0.1, 1.5)];
    let origin = DVec3::new(10.0, -20.0, 30.5);
    for (name, low) in [("cloud", CLOUD[0]), ("fp8", PUFF[0])] {
        let grid = read(name);
        let size = DVec3::from(grid.size.map(|side| side as f64));
        for (i, cell) in cells(&grid, low).enumerate() {
            let [width, height, _] = grid.size;
            let place = DVec3::new((i % width) as f64, (i / width % height) as f64, (i / width / height) as f64);
            let centre = grid.transform.transform_point3((place + 0.5) / size);
            let expected = origin + (0..3).map(|axis| axes[axis] * cell[axis] as f64).sum::<DVec3>();
            // A dozen roundings of numbers below 100.
            assert!(centre.distance(expected) < 12.0 * 100.0 * f64::EPSILON, "{name}, {cell:?}: {centre} {expected}");
        }
    }
}

/// Written by other code than NanoVDB's: Warp counts the bytes of a compressed grid otherwise, and has new magic.
#[test]
fn a_grid_of_warp_is_read() {
    let grid = read("warp");
    assert_eq!(grid.size, [8, 8, 8]);
    let expected: Vec<f32> = cells(&grid, [0; 3]).map(|[x, y, z]| (x * 64 + y * 8 + z) as f32 / 512.0).collect();
    assert_eq!(grid.values, expected);
    // Warp's matrix acts on columns.
    let matrix = DMat3::from_cols_array(&[0.5, 0.25, 0.0, -0.25, 1.5, 0.0, 0.0, 0.125, 2.0]).transpose();
    let expected = matrix * DVec3::new(-8.5, 15.5, -0.5) + DVec3::new(1.0, 2.0, 3.0);
    assert!(grid.transform.translation.distance(expected) < 1e-12);
    assert_eq!(grid.transform.matrix3, matrix * 8.0);
    assert_eq!(&inflated("warp")[..8], b"NanoVDB1");
}

#[test]
fn tiles_fill_their_cells_active_or_not() {
    let grid = read("tiles");
    assert_eq!(grid.size, [151, 128, 128]);
    for (cell, &value) in cells(&grid, [0; 3]).zip(&grid.values) {
        let [x, y, z] = cell;
        let is_beside = (8..16).contains(&y) && (16..24).contains(&z);
        let expected = match x {
            ..128 => 0.5,
            128..136 if is_beside => 0.25,
            136..144 if is_beside => 0.75,
            150 if (y, z) == (3, 5) => 1.5,
            _ => 0.0,
        };
        assert!((value - expected).abs() == 0.0, "{value} in {cell:?}");
    }
    assert_eq!(read("tiles-without-boxes"), grid);
}

#[test]
fn uncompressed_files_and_buffers_equal_compressed_ones() {
    for name in ["cloud", "fp4", "fp8", "fp16", "fpn", "tiles"] {
        let (file, buffer, expected) = (fixture(name), inflated(name), read(name));
        assert_eq!(decode_any(&buffer, &VolumeOptions::default()).unwrap(), expected, "{name}");
        let two = [&inflated("negative")[..], &buffer].concat();
        assert!(decode_any(&two, &VolumeOptions::default()).is_err(), "{name}: the first of its name is negative");
        let head = 16 + 176 + "density\0".len();
        let mut plain = [&file[..head], &buffer].concat();
        plain[14] = 0; // the codec
        plain[16 + 8..16 + 16].copy_from_slice(&buffer.len().to_le_bytes()); // the size in the file
        assert_eq!(decode_any(&plain, &VolumeOptions::default()).unwrap(), expected, "{name}");
        plain[7] = b'2'; // the magic since version 32.6
        plain[head + 7] = b'1';
        assert_eq!(decode_any(&plain, &VolumeOptions::default()).unwrap(), expected, "{name}");
        let segments = [fixture("two"), &plain].concat();
        assert_eq!(decode_any(&segments, &VolumeOptions::default()).unwrap(), expected, "{name}");
    }
}

#[test]
fn grids_are_chosen_by_name() {
    let named = |name, grid| decode_any(fixture(name), &VolumeOptions { grid, ..VolumeOptions::default() });
    let values = |name, grid| named(name, grid).unwrap().values;
    assert_eq!(values("several", None), [0.5; 3]);
    assert_eq!(values("several", Some("density")), [0.5; 3]);
    assert_eq!(values("several", Some("flame")), [0.25; 3]);
    assert_eq!(values("two", Some("temperature")), [300.0; 3]);
    let error = |name, grid| named(name, grid).unwrap_err().chain();
    assert_eq!(error("two", None), "it has several grids, none of them 'density': 'flame', 'temperature'");
    assert_eq!(error("two", Some("heat")), "it has no grid 'heat', only 'flame', 'temperature'");
    assert!(error("several", Some("velocity")).contains("its values are Vec3f"));
    assert!(error("cloud", Some("")).contains("it has no grid ''"));
}

/// The value of a frame before the smoke appears.
#[test]
fn a_grid_without_active_cells_is_one_cell_of_zero() {
    let grid = read("empty");
    assert_eq!((grid.size, grid.values), ([1; 3], vec![0.0]));
}

#[test]
fn kinds_that_hold_no_densities_are_one_sentence() {
    for (name, what) in [
        ("sphere", "grid '': it is a level set, and only fog volumes and grids without a class hold densities"),
        ("vector", "grid 'velocity': its values are Vec3f, and only Float, Fp4, Fp8, Fp16 and FpN are supported"),
        ("double", "grid 'density': its values are Double, and only"),
        ("blosc", "it is compressed with BLOSC"),
        ("negative", "grid 'density': its value in cell (0, 2, 1) is -0.5, and densities are finite and not negative"),
    ] {
        let text = decode_any(fixture(name), &VolumeOptions::default()).unwrap_err().chain();
        assert!(text.starts_with(what), "{text}");
    }
}

#[test]
fn changed_headers_are_one_sentence() {
    let version = |major: u32| ((major << 21) | (4 << 10)).to_le_bytes();
    let mut backward = fixture("cloud").to_vec();
    backward[..8].reverse();
    let file = |at: usize, to: &[u8]| {
        let mut bytes = fixture("fp8").to_vec();
        bytes[at..at + to.len()].copy_from_slice(to);
        bytes
    };
    for (bytes, what) in [
        (backward, "big-endian"),
        (file(8, &version(31)), "it is of NanoVDB's version 31.4, and only 32 is supported"),
        (file(8, &version(33)), "version 33.4"),
        (file(12, &[0]), "begins no segment of grids"),
        (file(14, &[3]), "the unknown codec 3"),
        (file(16, &u64::MAX.to_le_bytes()), "its grid 'density' has 18446744073709551615 bytes, more than the limit"),
        (file(16, &(1_u64 << 29).to_le_bytes()), "claims 536870912 bytes, more than"),
        (file(16, &1000_u64.to_le_bytes()), "has 1001 bytes and not the 1000"),
        (file(200, &u64::MAX.to_le_bytes()), "it ends too early"),
        (file(216, &[0xff; 8]), "its compressed grid 'density' is damaged"),
        (file(0, b"NanoVDB1"), "it ends too early"),
        (fixture("cloud")[..16].iter().copied().chain([0; 8]).collect(), "it ends too early"),
        ([b"NanoVDB2", &version(32)[..], &[0; 4]].concat(), "it has no grids"),
    ] {
        let (_, text) = refusal(&bytes);
        assert!(text.contains(what), "{text}: {what}");
    }
}

#[test]
fn changed_grids_are_one_sentence() {
    let [cloud, fpn] = ["cloud", "fpn"].map(|name| {
        let mut grid = inflated(name);
        grid[7] = b'1'; // the magic that does not need the version to be told from that of a segment
        grid
    });
    let at = |grid: &[u8], at: usize| u64::from_le_bytes(grid[at..at + 8].try_into().unwrap()) as usize;
    let upper = ROOT + at(&cloud, ROOT + 64 + 8);
    let leaf = |grid: &[u8]| 672 + at(grid, 672);
    let changed = |grid: &[u8], at: usize, to: &[u8]| {
        let mut grid = grid.to_vec();
        grid[at..at + to.len()].copy_from_slice(to);
        grid
    };
    let first_child = (0..32_768).find(|n| cloud[upper + 4128 + n / 8] >> (n % 8) & 1 != 0).unwrap();
    let entry = upper + 8256 + 8 * first_child;
    for (grid, what) in [
        (changed(&cloud, 16, &(33_u32 << 21).to_le_bytes()), "version 33.0, and only 32"),
        (changed(&cloud, CLASS, &[4]), "it is an index of points, and only"),
        (changed(&cloud, CLASS, &[99]), "it is of an unknown class"),
        (changed(&cloud, TYPE, &[9]), "its values are Half"),
        (changed(&cloud, TYPE, &[99]), "its values are of an unknown type"),
        (changed(&cloud, MATRIX, &[0; 72]), "its map to the world has no inverse"),
        (changed(&cloud, MATRIX, &f64::NAN.to_le_bytes()), "no inverse"),
        (changed(&cloud, ORIGIN, &f64::INFINITY.to_le_bytes()), "no inverse"),
        (changed(&cloud, 672 + 24, &u64::MAX.to_le_bytes()), "outside of the grid"),
        (changed(&cloud, ROOT + 24, &u32::MAX.to_le_bytes()), "it ends too early"),
        (changed(&cloud, ROOT + 64 + 7, &[0x80]), "its root has the invalid key"),
        (changed(&cloud, ROOT + 96, &cloud[ROOT + 64..ROOT + 96]), "two tiles at one place"),
        (changed(&cloud, ROOT + 64 + 8, &i64::MIN.to_le_bytes()), "outside of the grid"),
        (changed(&cloud, entry, &i64::MAX.to_le_bytes()), "outside of the grid"),
        (changed(&cloud, upper + 4128, &[0xff; 4096]), "of its tree"),
        (changed(&fpn, leaf(&fpn) + 15, &[0xa0]), "values of 32 bits"),
        (changed(&cloud, leaf(&cloud) + 96 + 511 * 4, &f32::NAN.to_le_bytes()), "is NaN, and densities"),
        (changed(&fpn, leaf(&fpn) + 80, &f32::NEG_INFINITY.to_le_bytes()), "is -inf, and densities"),
    ] {
        let (kind, text) = refusal(&grid);
        assert!(text.starts_with("grid 'density': ") && text.contains(what) && kind == Kind::Scene, "{text}: {what}");
    }
}

/// All children of an upper node are one lower node, and its children one leaf: 2²⁷ leaves in a file of 300 KB.
#[test]
fn shared_nodes_do_not_hang() {
    let mut grid = inflated("fp8");
    let at = |grid: &[u8], at: usize| u64::from_le_bytes(grid[at..at + 8].try_into().unwrap()) as usize;
    let [leaf, lower, upper] = [0, 8, 16].map(|offset| 672 + at(&grid, 672 + offset));
    for (node, child, children, mask, table) in [(upper, lower, 32_768, 4128, 8256), (lower, leaf, 4096, 544, 1088)] {
        grid[node + mask..node + mask + children / 8].fill(0xff);
        for n in 0..children {
            grid[node + table + 8 * n..][..8].copy_from_slice(&(child - node).to_le_bytes());
        }
    }
    assert!(refusal(&grid).1.contains("nodes of its tree have bytes in common"));
}

/// One byte of a grid in memory is changed: of its headers and masks, and here and there.
#[test]
fn damaged_grids_do_not_panic_and_keep_the_limit() {
    let (options, mut random) = (VolumeOptions { memory: 2 << 20, ..VolumeOptions::default() }, Random::new(11));
    for name in ["fpn", "tiles-without-boxes"] {
        let grid = inflated(name);
        let nodes =
            [0, 8, 16].map(|offset| 672 + u64::from_le_bytes(grid[672 + offset..][..8].try_into().unwrap()) as usize);
        let near = nodes.iter().flat_map(|&node| node..(node + 96).min(grid.len()));
        let anywhere: Vec<usize> = (0..100).map(|_| random.bits() as usize % grid.len()).collect();
        for i in (0..40).chain(ROOT - 64..ROOT + 96).chain(near).chain(anywhere) {
            let mut changed = grid.clone();
            changed[i] ^= 1 << (random.bits() % 8);
            if let Ok(grid) = decode_any(&changed, &options) {
                assert!(grid.values.len() as u64 * 4 <= options.memory, "{name} at {i}");
            }
        }
    }
}
