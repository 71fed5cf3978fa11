//! NanoVDB files (`.nvdb`) of version 32: sparse grids of densities, written into a dense array.
//!
//! Supported are single precision and the quantised types Fp4, Fp8, Fp16 and FpN, of fog volumes and of grids without a
//! class; uncompressed or with ZIP; in files with metadata or as a raw buffer of grids. `container` finds the grids,
//! `tree` walks one, `leaf` decodes its leaves. Limits: BLOSC, level sets and other types are errors; checksums and
//! stored bounding boxes are not used. Reference: [Museth21] and the layout of NanoVDB's header `PNanoVDB.h`.

mod container;
mod leaf;
mod region;
mod tree;

use super::bytes::Bytes;
use super::{VolumeGrid, VolumeOptions, filled, invertible};
use crate::error::{Error, Result};
use container::{check_version, is_grid};
use glam::{DAffine3, DMat3, DVec3};
use leaf::Encoding;
use region::Region;
use tree::{Content, Tree};

pub(super) use container::is_nanovdb;

/// Offsets in the header of a grid.
const VERSION: usize = 16;
const MATRIX: usize = 296 + 88;
const ORIGIN: usize = 296 + 232;
const CLASS: usize = 632;
const TYPE: usize = 636;
/// Names of the classes of grids, by number.
const CLASSES: [&str; 10] = [
    "a grid without a class",
    "a level set",
    "a fog volume",
    "a staggered grid",
    "an index of points",
    "points",
    "a topology",
    "a volume of cubes",
    "an index grid",
    "a tensor grid",
];
const NO_CLASS: usize = 0;
const FOG_VOLUME: usize = 2;
/// Names of the types of values, by number.
const TYPES: [&str; 27] = [
    "Unknown",
    "Float",
    "Double",
    "Int16",
    "Int32",
    "Int64",
    "Vec3f",
    "Vec3d",
    "Mask",
    "Half",
    "UInt32",
    "Boolean",
    "RGBA8",
    "Fp4",
    "Fp8",
    "Fp16",
    "FpN",
    "Vec4f",
    "Vec4d",
    "Index",
    "OnIndex",
    "IndexMask",
    "OnIndexMask",
    "PointIndex",
    "Vec3u8",
    "Vec3u16",
    "UInt8",
];

/// Decodes a grid. The error sentences begin with "it" or "its", the file.
pub(super) fn decode(bytes: Bytes<'_>, options: &VolumeOptions<'_>) -> Result<VolumeGrid> {
    let (name, grid) = container::grid(bytes, options)?;
    dense(Bytes(&grid), options.memory).map_err(|error| error.context(format!("grid '{name}'")))
}

/// Writes the box of the active cells into an array. A grid without active cells is one cell of value 0.
fn dense(grid: Bytes<'_>, memory: u64) -> Result<VolumeGrid> {
    if !is_grid(grid) {
        return Err(Error::scene("it does not begin as a grid of NanoVDB does"));
    }
    check_version(grid.u32(VERSION)?)?;
    check_class(grid.u32(CLASS)?)?;
    let tree = Tree::new(grid, encoding(grid.u32(TYPE)?)?)?;
    let mut active = Region::EMPTY;
    tree.visit(&mut |region, content| match content {
        Content::Tile { is_active, .. } if is_active => active.extend(region),
        Content::Tile { .. } => {}
        Content::Leaf(leaf) => active.extend(leaf.active(region.low)),
    })?;
    let (active, background) =
        if active.is_empty() { (Region::cube([0; 3], 1), 0.0) } else { (active, tree.background) };
    let size = active.size();
    let mut values = filled(size, 1, background, memory)?;
    let size = size.map(|side| side as usize);
    tree.visit(&mut |region, content| write(&mut values, size, active, region, content))?;
    let transform = transform(grid, active)?;
    VolumeGrid { size, channels: 1, values, transform }.checked(active.low)
}

/// Writes what lies in `region` into the array of the cells of `active`.
fn write(values: &mut [f32], size: [usize; 3], active: Region, region: Region, content: Content<'_>) {
    let common = region.intersection(active);
    if common.is_empty() {
        return;
    }
    let cells = |y: i64, z: i64| {
        let row = (z - active.low[2]) as usize * size[1] + (y - active.low[1]) as usize;
        let at = |x: i64| row * size[0] + (x - active.low[0]) as usize;
        at(common.low[0])..at(common.high[0])
    };
    let rows = (common.low[2]..common.high[2]).flat_map(|z| (common.low[1]..common.high[1]).map(move |y| (y, z)));
    match content {
        Content::Tile { value, .. } => rows.for_each(|(y, z)| values[cells(y, z)].fill(value)),
        Content::Leaf(leaf) => {
            let stored = leaf.values();
            for (y, z) in rows {
                for (x, value) in (common.low[0]..).zip(&mut values[cells(y, z)]) {
                    *value = stored[leaf::index([x, y, z])];
                }
            }
        }
    }
}

/// The map from the unit cube to the world. Cells have their centres at whole indices, hence the half.
fn transform(grid: Bytes<'_>, active: Region) -> Result<DAffine3> {
    let vector = |at| -> Result<DVec3> { Ok(DVec3::new(grid.f64(at)?, grid.f64(at + 8)?, grid.f64(at + 16)?)) };
    let rows = [vector(MATRIX)?, vector(MATRIX + 24)?, vector(MATRIX + 48)?];
    let index_to_world =
        DAffine3::from_mat3_translation(DMat3::from_cols(rows[0], rows[1], rows[2]).transpose(), vector(ORIGIN)?);
    let corner = DVec3::from(active.low.map(|low| low as f64 - 0.5));
    let size = DVec3::from(active.size().map(|side| side as f64));
    let map = index_to_world * DAffine3::from_scale_rotation_translation(size, glam::DQuat::IDENTITY, corner);
    invertible(map.matrix3, map.translation)
}

fn check_class(class: u32) -> Result<()> {
    match class as usize {
        NO_CLASS | FOG_VOLUME => Ok(()),
        class => {
            let name = CLASSES.get(class).copied().unwrap_or("of an unknown class");
            Err(Error::scene(format!("it is {name}, and only fog volumes and grids without a class hold densities")))
        }
    }
}

fn encoding(kind: u32) -> Result<Encoding> {
    Encoding::of_type(kind).ok_or_else(|| {
        let name = TYPES.get(kind as usize).copied().unwrap_or("of an unknown type");
        Error::scene(format!("its values are {name}, and only Float, Fp4, Fp8, Fp16 and FpN are supported"))
    })
}

#[cfg(test)]
#[path = "nanovdb_tests.rs"]
mod tests;
