//! Volumes as dense arrays of cells: Mitsuba's `.vol` and NanoVDB's `.nvdb`. [`read`] is the entry point.
//!
//! The first bytes of a file select the format, and not its name. A sparse grid becomes the box of its active cells, in
//! which inactive cells have the value that the grid has for them; what lies outside of the box is lost. Limits: dense
//! arrays take memory for the empty space in a box; values are single precision; `.vdb` files need `nanovdb_convert`.

mod bytes;
mod mitsuba;
mod nanovdb;

use super::reading::read_file;
use crate::error::{Error, Kind, Result};
use bytes::Bytes;
use glam::{DAffine3, DMat3, DVec3};
use std::path::Path;

/// First bytes of an OpenVDB file.
const OPENVDB_MAGIC: &[u8] = b" BDV\0\0\0\0";
/// A file may have as many times the memory limit of its array: it may hold other grids.
const FILE_TO_ARRAY: u64 = 4;

/// Values in cells that fill a box, finite and not negative.
#[derive(Debug, Clone, PartialEq)]
pub struct VolumeGrid {
    /// Numbers of cells along x, y and z, all positive.
    pub size: [usize; 3],
    /// Values per cell, 1 or 3.
    pub channels: usize,
    /// Values in the units of the file. The index of a value is `((z · size.y + y) · size.x + x) · channels + channel`.
    pub values: Vec<f32>,
    /// Map from the unit cube [0, 1]³, which the cells fill, to the world of the file in its units. The centre of cell
    /// (x, y, z) is at ((x + ½) / size.x, (y + ½) / size.y, (z + ½) / size.z) of the cube. The map is invertible and may
    /// mirror.
    pub transform: DAffine3,
}

/// Options for reading a volume.
#[derive(Debug, Clone, Copy)]
pub struct VolumeOptions<'a> {
    /// Name of the grid; `None` is the only one of the file, or `density` among several.
    pub grid: Option<&'a str>,
    /// Memory limit in bytes of the array of cells, and separately of a grid that is stored compressed. The file may
    /// have four times as many bytes.
    pub memory: u64,
}

impl Default for VolumeOptions<'_> {
    /// The only grid or `density`, with 1 GiB.
    fn default() -> Self {
        VolumeOptions { grid: None, memory: 1 << 30 }
    }
}

/// Reads a volume from a file.
///
/// # Errors
/// [`Kind::Scene`] with the path if the file cannot be read, is damaged, is of an unsupported kind, lacks the grid, or
/// has values that are negative, infinite or NaN. [`Kind::Memory`] if it needs more memory than allowed.
pub fn read(path: &Path, options: &VolumeOptions<'_>) -> Result<VolumeGrid> {
    let named = |error: Error| error.context(format!("cannot read {}", path.display()));
    let limit = options.memory.saturating_mul(FILE_TO_ARRAY);
    let length = std::fs::metadata(path).map_err(|cause| Error::read(path, cause))?.len();
    if length > limit {
        return Err(named(too_large("it", length, limit)));
    }
    decode(&read_file(path, limit)?, options).map_err(named)
}

/// Decodes the bytes of a file.
///
/// # Errors
/// As [`read`], without the path.
pub fn decode(bytes: &[u8], options: &VolumeOptions<'_>) -> Result<VolumeGrid> {
    if mitsuba::is_volume(bytes) {
        return mitsuba::decode(Bytes(bytes), options);
    }
    if nanovdb::is_nanovdb(bytes) {
        return nanovdb::decode(Bytes(bytes), options);
    }
    if bytes.starts_with(OPENVDB_MAGIC) {
        return Err(Error::scene(
            "it is an OpenVDB file; `nanovdb_convert in.vdb out.nvdb` makes a NanoVDB file of it",
        ));
    }
    Err(Error::scene("it is neither a Mitsuba volume (.vol) nor a NanoVDB file (.nvdb)"))
}

/// Returns an array of the cells of a grid, all of that value.
fn filled(size: [u64; 3], channels: usize, value: f32, memory: u64) -> Result<Vec<f32>> {
    let cells = size.iter().fold(1, |cells: u64, &side| cells.saturating_mul(side));
    let bytes = cells.saturating_mul((channels * size_of::<f32>()) as u64);
    let [x, y, z] = size;
    if bytes > memory {
        return Err(too_large(&format!("its array of {x}×{y}×{z} cells"), bytes, memory));
    }
    let count = bytes as usize / size_of::<f32>();
    let mut values = reserved(count, &format!("its array of {x}×{y}×{z} cells"))?;
    values.resize(count, value);
    Ok(values)
}

/// Returns an empty vector with room for `count` elements of `what`.
fn reserved<T>(count: usize, what: &str) -> Result<Vec<T>> {
    let mut empty = Vec::new();
    let reserved = empty.try_reserve_exact(count);
    reserved.map_err(|cause| Error::new(Kind::Memory, format!("{what} does not fit into memory")).because(cause))?;
    Ok(empty)
}

/// The error for `what` that needs too many bytes.
fn too_large(what: &str, bytes: u64, limit: u64) -> Error {
    Error::new(Kind::Memory, format!("{what} has {bytes} bytes, more than the limit of {limit}"))
}

impl VolumeGrid {
    /// Returns the grid if its values are finite and not negative. `first` is the index of its first cell in the file.
    fn checked(self, first: [i64; 3]) -> Result<Self> {
        let is_wrong = |value: &f32| !(*value >= 0.0 && value.is_finite());
        let Some(wrong) = self.values.iter().position(is_wrong) else { return Ok(self) };
        let cell = wrong / self.channels;
        let [width, height, _] = self.size;
        let place = [cell % width, cell / width % height, cell / width / height];
        let [x, y, z] = [0, 1, 2].map(|axis| first[axis] + place[axis] as i64);
        let (value, channel) = (self.values[wrong], wrong % self.channels);
        let channel = if self.channels > 1 { format!(" of channel {channel}") } else { String::new() };
        Err(Error::scene(format!(
            "its value{channel} in cell ({x}, {y}, {z}) is {value}, and densities are finite and not negative"
        )))
    }
}

/// Returns the affine map `matrix` · v + `origin` if it is finite and invertible.
fn invertible(matrix: DMat3, origin: DVec3) -> Result<DAffine3> {
    let (map, determinant) = (DAffine3::from_mat3_translation(matrix, origin), matrix.determinant());
    if map.is_finite() && determinant.is_finite() && determinant != 0.0 && map.inverse().is_finite() {
        return Ok(map);
    }
    Err(Error::scene("its map to the world has no inverse"))
}

#[cfg(test)]
#[path = "volume_tests.rs"]
mod tests;
