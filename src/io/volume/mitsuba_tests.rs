use super::super::decode as decode_any;
use super::*;
use crate::error::Kind;

const CUBE: [f32; 6] = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0];

/// A volume as Mitsuba 3.9 writes it.
fn volume(size: [i32; 3], channels: i32, bounds: [f32; 6], values: &[f32]) -> Vec<u8> {
    let mut bytes = b"VOL\x03\x01\0\0\0".to_vec();
    size.iter().chain([&channels]).for_each(|number| bytes.extend(number.to_le_bytes()));
    bounds.iter().chain(values).for_each(|number| bytes.extend(number.to_le_bytes()));
    bytes
}

fn counted(count: usize) -> Vec<f32> {
    (0..count).map(|i| i as f32 / 4.0).collect()
}

fn error(bytes: &[u8]) -> (Kind, String) {
    let error = decode_any(bytes, &VolumeOptions::default()).unwrap_err();
    (error.kind, error.chain())
}

/// The bytes are those that Mitsuba 3.9.1 writes for numpy.arange(2).reshape(1, 1, 2).
#[test]
fn bytes_of_mitsuba_are_read() {
    let hex = "564f4c0301000000020000000100000001000000010000000000000000000000000000000000803f0000803f0000803f\
               000000000000803f";
    let bytes: Vec<u8> = (0..hex.len() / 2).map(|i| u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).unwrap()).collect();
    assert_eq!(bytes, volume([2, 1, 1], 1, CUBE, &[0.0, 1.0]));
    let grid = decode_any(&bytes, &VolumeOptions::default()).unwrap();
    assert_eq!((grid.size, grid.channels, grid.values), ([2, 1, 1], 1, vec![0.0, 1.0]));
    assert_eq!(grid.transform, DAffine3::IDENTITY);
}

#[test]
fn values_are_in_the_order_of_the_file() {
    for channels in [1, 3] {
        let values = counted(4 * 3 * 2 * channels);
        let bytes = volume([4, 3, 2], channels as i32, CUBE, &values);
        let grid = decode_any(&bytes, &VolumeOptions::default()).unwrap();
        assert_eq!((grid.size, grid.channels, &grid.values), ([4, 3, 2], channels, &values));
        let longer = [bytes, vec![1, 2, 3]].concat();
        assert_eq!(decode_any(&longer, &VolumeOptions::default()).unwrap(), grid);
    }
}

#[test]
fn the_unit_cube_is_mapped_to_the_box() {
    let bytes = volume([1, 1, 1], 1, [-1.0, 2.0, 0.5, 3.0, 2.5, 8.5], &[1.0]);
    let transform = decode_any(&bytes, &VolumeOptions::default()).unwrap().transform;
    assert_eq!(transform.transform_point3(DVec3::ZERO), DVec3::new(-1.0, 2.0, 0.5));
    assert_eq!(transform.transform_point3(DVec3::ONE), DVec3::new(3.0, 2.5, 8.5));
}

#[test]
fn errors_name_the_defect() {
    let cube = |size, channels, values: &[f32]| volume(size, channels, CUBE, values);
    let good = cube([2, 2, 2], 1, &counted(8));
    let changed = |at: usize, to: u8| {
        let mut bytes = good.clone();
        bytes[at] = to;
        bytes
    };
    let box_of = |bounds| volume([1, 1, 1], 1, bounds, &[1.0]);
    for (bytes, what) in [
        (changed(3, 2), "of version 2, and only 3"),
        (changed(4, 2), "of encoding 2, and only 1 (32-bit floats)"),
        (good[..47].to_vec(), "it ends too early"),
        (good[..good.len() - 1].to_vec(), "2×2×2 cells are 8 values, and it has 7"),
        (cube([2, 0, 2], 1, &[]), "2×0×2 is not positive"),
        (cube([2, -1, 2], 1, &[]), "2×-1×2 is not positive"),
        (cube([i32::MAX; 3], 3, &[1.0]), "it ends too early"),
        (cube([1, 1, 1], 2, &[1.0; 2]), "2 channels, and only 1 and 3"),
        (cube([1, 1, 1], -1, &[1.0; 2]), "-1 channels"),
        (box_of([0.0, 0.0, 0.0, 1.0, 0.0, 1.0]), "is empty"),
        (box_of([0.0, 0.0, f32::NAN, 1.0, 1.0, 1.0]), "is empty"),
        (box_of([0.0, 0.0, 0.0, 1.0, 1.0, f32::INFINITY]), "no inverse"),
        (cube([3, 2, 1], 1, &[0.0, 0.0, 0.0, 1.0, -0.5, -1.0]), "value in cell (1, 1, 0) is -0.5, and densities"),
        (cube([1, 1, 2], 3, &[0.0, 0.0, 0.0, 1.0, f32::NAN, 1.0]), "value of channel 1 in cell (0, 0, 1) is NaN"),
        (cube([2, 1, 1], 1, &[0.0, f32::INFINITY]), "value in cell (1, 0, 0) is inf"),
    ] {
        let (kind, text) = error(&bytes);
        assert!(text.contains(what) && kind == Kind::Scene, "{text}: {what}");
    }
    let named = VolumeOptions { grid: Some("density"), ..VolumeOptions::default() };
    assert!(decode_any(&good, &named).unwrap_err().chain().contains("no named grid such as 'density'"));
}
