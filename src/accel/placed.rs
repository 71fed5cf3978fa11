//! What every backend checks before it builds: that objects have meshes and places that f32 arithmetic can represent.

use crate::error::{Error, Kind, Result};
use crate::geometry::{Bounds, Geometry, Object, TriangleMesh, is_placement};
use glam::Vec3;
use std::sync::Arc;

/// Coordinates must stay below this: squares of differences overflow soon after, and Embree leaves out triangles beyond it
/// without a word.
const REACH: f32 = 1.844e18;

/// The world-space box around each object.
///
/// # Errors
/// A scene error if a placement cannot be inverted or an object reaches beyond ±1.8e18; an internal error if an object names a
/// mesh that is not there.
pub(super) fn bounds(geometry: &Geometry) -> Result<Vec<Bounds>> {
    let boxes: Vec<Bounds> = geometry.meshes.iter().map(|mesh| mesh.bounds()).collect();
    let objects = geometry.objects.iter().enumerate();
    objects.map(|(index, object)| of_object(index, object, mesh(geometry, index)?, &boxes)).collect()
}

/// The mesh of object `index`.
///
/// # Errors
/// An internal error if it is not there.
pub(super) fn mesh(geometry: &Geometry, index: usize) -> Result<&Arc<TriangleMesh>> {
    let number = geometry.objects[index].mesh;
    let missing = || Error::new(Kind::Internal, format!("object {index} names mesh {number}, which is not there"));
    geometry.meshes.get(number as usize).ok_or_else(missing)
}

fn of_object(index: usize, object: &Object, mesh: &TriangleMesh, boxes: &[Bounds]) -> Result<Bounds> {
    let fail = |what: &str| Err(Error::scene(format!("object {index} (mesh '{}') {what}", mesh.name())));
    let local = boxes[object.mesh as usize];
    let world = match &object.placement {
        None => local,
        Some(m) if is_placement(m) => {
            let corner = |i: u32| Vec3::select(glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0), local.max, local.min);
            Bounds::around((0..8).map(|i| m.transform_point3(corner(i))))
        }
        Some(_) => return fail("has a placement that cannot be inverted"),
    };
    let reach = [local.min, local.max, world.min, world.max].map(|p| p.abs().max_element());
    // Not `any`: a bound that overflowed to NaN must fail too.
    if reach.iter().all(|&r| r < REACH) { Ok(world) } else { fail("reaches beyond ±1.8e18") }
}
