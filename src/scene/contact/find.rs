//! Detection of touching triangles. All placed triangles are tested against a tree of transmitting ones, and these
//! against the triangles found.

use super::{Contacts, close};
use crate::geometry::{Bounds, BoxTree, Geometry, Hit, Leaf, Triangle};
use glam::Vec3;
use rayon::prelude::*;
use std::ops::ControlFlow::{Break, Continue};

/// Largest number of placed triangles that are tested: some ten seconds of work and 1 GB.
const MOST: usize = 1 << 24;

/// Largest ray offset in units of the error bound: √3, and the rounding of the point and of the sum. See
/// tests/accel/spawned.rs.
const JUMP: f32 = 4.0;

/// Error bound of a backend's height over a plane, in half-ulps of the distance to a vertex (see `geometry::triangle`
/// and tests/accel/spawned.rs).
const SORTING: f32 = 16.0 * 0.5 * f32::EPSILON;

/// Largest error bound of a point of a triangle, relative to its largest coordinate: 4 half-ulps of that and 12 of two
/// edges of twice it each (`Triangle::point`), and as much for a placement.
const WORST_ERROR: f32 = 2.0 * 52.0 * 0.5 * f32::EPSILON;

impl Contacts {
    /// Finds the touching triangles of `geometry`. Objects with `passes` transmit light; the cameras are at `eyes`.
    /// `None` if nothing touches.
    ///
    /// # Errors
    /// The number of triangles to test, if it is too large.
    pub(in super::super) fn find(
        geometry: &Geometry,
        passes: &[bool],
        eyes: &[Vec3],
    ) -> Result<Option<Contacts>, usize> {
        if !passes.contains(&true) {
            return Ok(None);
        }
        let boxes: Vec<Bounds> = (0..passes.len() as u32).map(|object| bounds(geometry, object)).collect();
        let all = boxes.iter().copied().fold(Bounds::EMPTY, Bounds::union);
        let far = eyes.iter().fold(all.min.abs().max(all.max.abs()), |most, eye| most.max(eye.abs())).max_element();
        // The distance of a vertex from a ray's origin is at most the sum of their distances from the world origin.
        let mut contacts =
            Contacts { flags: Vec::new(), tree: BoxTree::default(), doubt: SORTING * 2.0 * far, most_reach: 0.0 };
        let [passing, near] = contacts.candidates(geometry, passes, &boxes)?;
        let passing = BoxTree::new(passing);
        let mut found: Vec<Leaf> = near.into_par_iter().filter(|leaf| contacts.meets_any(leaf, &passing)).collect();
        // Transmitting triangles that are touched only by opaque ones.
        let opaque = BoxTree::new(found.iter().filter(|leaf| !passes[leaf.hit.object as usize]).copied().collect());
        let touched = passing.leaves().par_iter().filter(|leaf| contacts.meets_any(leaf, &opaque));
        found.extend(touched.copied().collect::<Vec<_>>());
        found.sort_unstable_by_key(|leaf| (leaf.hit.object, leaf.hit.primitive));
        found.dedup_by_key(|leaf| leaf.hit);
        contacts.flags = flags(geometry, &found);
        contacts.most_reach = found.iter().map(|leaf| contacts.reach(&leaf.triangle)).fold(0.0, f32::max);
        contacts.tree = BoxTree::new(found);
        Ok((!contacts.tree.leaves().is_empty()).then_some(contacts))
    }

    /// Returns the transmitting triangles, and all triangles of objects near them.
    fn candidates(&self, geometry: &Geometry, passes: &[bool], boxes: &[Bounds]) -> Result<[Vec<Leaf>; 2], usize> {
        let all = || 0..passes.len() as u32;
        let passing: Vec<u32> = all().filter(|&object| passes[object as usize]).collect();
        let bright = passing.iter().map(|&object| boxes[object as usize]).fold(Bounds::EMPTY, Bounds::union);
        let near: Vec<u32> =
            all().filter(|&object| passes[object as usize] || self.overlap(&boxes[object as usize], &bright)).collect();
        let count = near.iter().map(|&object| geometry.mesh_of(object).triangles().len()).sum();
        if count > MOST {
            return Err(count);
        }
        Ok([passing, near].map(|objects| objects.iter().flat_map(|&object| placed(geometry, object)).collect()))
    }

    /// Returns a triangle's part of the distance within which it touches another.
    #[inline]
    pub(super) fn reach(&self, triangle: &Triangle) -> f32 {
        JUMP * triangle.most_error() + self.doubt
    }

    /// Returns whether the distance of two boxes is small enough for their triangles to touch.
    fn overlap(&self, a: &Bounds, b: &Bounds) -> bool {
        let most = [a.min, a.max, b.min, b.max].iter().fold(0.0f32, |most, p| most.max(p.abs().max_element()));
        let pad = 2.0 * (JUMP * WORST_ERROR * most + self.doubt);
        (a.min.cmple(b.max + pad) & b.min.cmple(a.max + pad)).all()
    }

    fn meets_any(&self, leaf: &Leaf, tree: &BoxTree<Leaf>) -> bool {
        let own = Bounds::around(leaf.triangle.vertices);
        let walked = tree.visit(
            |bounds| self.overlap(bounds, &own),
            |other| {
                let distance = self.reach(&leaf.triangle) + self.reach(&other.triangle);
                let neighbours = other.hit.object == leaf.hit.object;
                let touch =
                    other.hit != leaf.hit && close::are_close(&leaf.triangle, &other.triangle, neighbours, distance);
                if touch { Break(()) } else { Continue(()) }
            },
        );
        walked.is_break()
    }
}

/// Returns the world-space bounding box of an object.
fn bounds(geometry: &Geometry, object: u32) -> Bounds {
    let local = geometry.mesh_of(object).bounds();
    let Some(m) = &geometry.objects[object as usize].placement else { return local };
    let corner = |i: u32| Vec3::select(glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0), local.max, local.min);
    Bounds::around((0..8).map(|i| m.transform_point3(corner(i))))
}

/// Returns the world-space triangles of an object.
fn placed(geometry: &Geometry, object: u32) -> impl Iterator<Item = Leaf> + '_ {
    let count = geometry.mesh_of(object).triangles().len() as u32;
    (0..count).map(move |primitive| Hit { object, primitive }).map(|hit| Leaf { hit, triangle: geometry.triangle(hit) })
}

fn flags(geometry: &Geometry, found: &[Leaf]) -> Vec<Option<Box<[u64]>>> {
    let mut flags = vec![None; geometry.objects.len()];
    for Leaf { hit, .. } in found {
        let words = || vec![0u64; geometry.mesh_of(hit.object).triangles().len().div_ceil(64)].into_boxed_slice();
        let bits: &mut Box<[u64]> = flags[hit.object as usize].get_or_insert_with(words);
        bits[hit.primitive as usize / 64] |= 1 << (hit.primitive % 64);
    }
    flags
}
