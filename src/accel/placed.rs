//! Checks of every backend before construction: meshes exist, and placements are within the range of f32 arithmetic.

use crate::error::{Error, Kind, Result};
use crate::geometry::{Bounds, Geometry, Object, TriangleMesh, is_placement};
use glam::Vec3;
use std::sync::Arc;

/// Upper bound of coordinates. Beyond it squares of differences soon overflow, and Embree silently omits triangles.
const REACH: f32 = 1.844e18;

/// Returns the world-space bounding box of each object.
///
/// # Errors
/// A scene error if a placement is singular or an object exceeds ±1.8e18; an internal error if an object refers to a
/// missing mesh.
pub(super) fn bounds(geometry: &Geometry) -> Result<Vec<Bounds>> {
    let boxes: Vec<Bounds> = geometry.meshes.iter().map(|mesh| mesh.bounds()).collect();
    let objects = geometry.objects.iter().enumerate();
    objects.map(|(index, object)| of_object(index, object, mesh(geometry, index)?, &boxes)).collect()
}

/// Returns the mesh of object `index`.
///
/// # Errors
/// An internal error if the mesh is missing.
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
            let corner =
                |i: u32| Vec3::select(glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0), local.max, local.min);
            Bounds::around((0..8).map(|i| m.transform_point3(corner(i))))
        }
        Some(_) => return fail("has a placement that cannot be inverted"),
    };
    let reach = [local.min, local.max, world.min, world.max].map(|p| p.abs().max_element());
    // Not `any`: a bound that overflowed to NaN must also fail.
    if reach.iter().all(|&r| r < REACH) { Ok(world) } else { fail("reaches beyond ±1.8e18") }
}
