//! Mitsuba's binary volumes (`.vol`), version 3: a header of 48 bytes and single-precision values.
//!
//! The only encoding is that of Mitsuba 3, number 1. The box of the header is the place of the cells; Mitsuba itself
//! puts them into the unit cube unless `use_grid_bbox` is set. Bytes after the values are ignored, as in Mitsuba.
//! Reference: the documentation of Mitsuba's plugin `gridvolume`.

use super::bytes::Bytes;
use super::{VolumeGrid, VolumeOptions, filled, invertible};
use crate::error::{Error, Result};
use glam::{DAffine3, DMat3, DVec3};

const MAGIC: &[u8] = b"VOL";
const VERSION: u8 = 3;
const HEADER: usize = 48;
/// Encoding of single-precision values.
const FLOAT32: i32 = 1;

/// Whether the file begins like a Mitsuba volume.
pub(super) fn is_volume(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Decodes a volume. The error sentences begin with "it" or "its", the file.
pub(super) fn decode(bytes: Bytes<'_>, options: &VolumeOptions<'_>) -> Result<VolumeGrid> {
    let header = bytes.part(0, HEADER)?;
    check_kind(header)?;
    if let Some(name) = options.grid {
        return Err(Error::scene(format!("it is a Mitsuba volume, which has no named grid such as '{name}'")));
    }
    let sides = [header.i32(8)?, header.i32(12)?, header.i32(16)?];
    let [x, y, z] = sides;
    if sides.iter().any(|&side| side <= 0) {
        return Err(Error::scene(format!("its size {x}×{y}×{z} is not positive")));
    }
    let (size, channels) = (sides.map(|side| side as u64), channels(header.i32(20)?)?);
    let held = (bytes.len() - HEADER) / size_of::<f32>();
    let count = size.iter().fold(channels as u64, |count, &side| count.saturating_mul(side));
    if count > held as u64 {
        return Err(Error::scene(format!(
            "it ends too early: {x}×{y}×{z} cells are {count} values, and it has {held}"
        )));
    }
    let mut values = filled(size, channels, 0.0, options.memory)?;
    for (value, stored) in values.iter_mut().zip(bytes.0[HEADER..].chunks_exact(size_of::<f32>())) {
        *value = f32::from_le_bytes([stored[0], stored[1], stored[2], stored[3]]);
    }
    let size = size.map(|side| side as usize);
    VolumeGrid { size, channels, values, transform: place(header)? }.checked([0; 3])
}

fn check_kind(header: Bytes<'_>) -> Result<()> {
    let (version, encoding) = (header.0[3], header.i32(4)?);
    if version != VERSION {
        return Err(Error::scene(format!(
            "it is a Mitsuba volume of version {version}, and only {VERSION} is supported"
        )));
    }
    if encoding != FLOAT32 {
        return Err(Error::scene(format!(
            "it is a Mitsuba volume of encoding {encoding}, and only {FLOAT32} (32-bit floats) is supported"
        )));
    }
    Ok(())
}

fn channels(channels: i32) -> Result<usize> {
    match channels {
        1 => Ok(1),
        3 => Ok(3),
        _ => Err(Error::scene(format!("it has {channels} channels, and only 1 and 3 are supported"))),
    }
}

/// The map from the unit cube to the box of the header.
fn place(header: Bytes<'_>) -> Result<DAffine3> {
    let corner = |at| -> Result<DVec3> {
        Ok(DVec3::new(header.f32(at)?.into(), header.f32(at + 4)?.into(), header.f32(at + 8)?.into()))
    };
    let (low, high) = (corner(24)?, corner(36)?);
    if !low.cmplt(high).all() {
        return Err(Error::scene(format!("its box from {low} to {high} is empty")));
    }
    invertible(DMat3::from_diagonal(high - low), low)
}

#[cfg(test)]
#[path = "mitsuba_tests.rs"]
mod tests;
