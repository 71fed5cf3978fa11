//! The eight-wide compressed tree of obvhs [Ylitie17] with its own traversal and triangle test, for comparison with our
//! own tree in `bench rays`. It is not a backend and cannot be selected for rendering:
//!
//! - It is not watertight: the triangle test of [Moller97] loses rays at edges, and boxes are not widened.
//! - Boxes that a ray leaves before the parameter 1e-4 are skipped, whatever the scale.
//! - Direction components below 1.2e-7 are clamped to it.
//! - It has one level: instances are flattened, which may take too much memory.
//! - It has one build quality; filters are called for every object.

use crate::accel::Intersector;
use crate::error::{Error, Kind, Result};
use crate::geometry::{AnyHit, Geometry, Hit, Ray};
use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::ray::{Ray as Query, RayHit, safe_inverse};
use obvhs::triangle::Triangle;

/// Largest number of triangles after flattening of instances; construction takes about 250 bytes per triangle.
const MOST_FLATTENED: usize = 1 << 22;

/// Largest depth that the traversal of obvhs supports.
const DEEPEST: u32 = 32;

/// Committed geometry.
pub struct Cwbvh {
    tree: CwBvh,
    /// By leaf, like the ids in `hits`.
    triangles: Box<[Triangle]>,
    hits: Box<[Hit]>,
}

impl Cwbvh {
    /// Builds the tree over `geometry`, with flattened instances, in the current rayon pool.
    ///
    /// # Errors
    /// A memory error if flattening gives more than four million triangles; an internal error if the tree is deeper
    /// than obvhs supports.
    ///
    /// # Panics
    /// If an object refers to a missing mesh.
    pub fn build(geometry: &Geometry) -> Result<Cwbvh> {
        let count: usize =
            (0..geometry.objects.len()).map(|object| geometry.mesh_of(object as u32).triangles().len()).sum();
        if count > MOST_FLATTENED && geometry.objects.iter().any(|object| object.placement.is_some()) {
            let what = format!("CWBVH has no instances, and {count} triangles are too many to flatten them");
            return Err(Error::new(Kind::Memory, what));
        }
        let hits: Vec<Hit> = {
            let objects = 0..geometry.objects.len() as u32;
            objects
                .flat_map(|object| {
                    let primitives = 0..geometry.mesh_of(object).triangles().len() as u32;
                    primitives.map(move |primitive| Hit { object, primitive })
                })
                .collect()
        };
        let triangles: Vec<Triangle> = hits.iter().map(|&hit| triangle(geometry, hit)).collect();
        let tree = if triangles.is_empty() {
            CwBvh::default()
        } else {
            build_cwbvh_from_tris(&triangles, BvhBuildParams::medium_build(), &mut std::time::Duration::default())
        };
        if depth(&tree) > DEEPEST {
            return Err(Error::new(Kind::Internal, format!("CWBVH would be more than {DEEPEST} levels deep")));
        }
        let leaves = || tree.primitive_indices.iter().map(|&i| i as usize);
        Ok(Cwbvh {
            triangles: leaves().map(|i| triangles[i]).collect(),
            hits: leaves().map(|i| hits[i]).collect(),
            tree,
        })
    }

    /// Returns the memory of nodes and leaves in bytes.
    pub fn bytes(&self) -> usize {
        self.tree.nodes.len() * size_of::<CwBvhNode>() + size_of_val(&*self.triangles) + size_of_val(&*self.hits)
    }

    /// Returns the parameter of the hit with the leaf's triangle; infinite if there is none or `any` rejects it.
    #[inline]
    fn meet<A: AnyHit>(&self, query: &Query, leaf: usize, ray: &Ray, any: &A) -> f32 {
        let t = self.triangles[leaf].intersect(query);
        if A::FILTERS && t < f32::INFINITY && !any.accepts(ray, self.hits[leaf]) { f32::INFINITY } else { t }
    }
}

impl Intersector for Cwbvh {
    #[inline]
    fn closest(&self, ray: &Ray, any: &impl AnyHit) -> Option<Hit> {
        let mut nearest = RayHit::none();
        let is_hit = self.tree.ray_traverse(query(ray)?, &mut nearest, |query, leaf| self.meet(query, leaf, ray, any));
        is_hit.then(|| self.hits[nearest.primitive_id as usize])
    }

    #[inline]
    fn occluded(&self, ray: &Ray, any: &impl AnyHit) -> bool {
        query(ray)
            .is_some_and(|query| !self.tree.ray_traverse_miss(query, |query, leaf| self.meet(query, leaf, ray, any)))
    }
}

/// Returns the ray in the format of obvhs; `None` for an invalid ray.
#[inline]
fn query(ray: &Ray) -> Option<Query> {
    let (origin, direction) = (Vec3A::from(ray.origin), Vec3A::from(ray.direction));
    let inv_direction = Vec3A::from_array(direction.to_array().map(safe_inverse));
    let is_ray = origin.is_finite() && direction.is_finite();
    is_ray.then_some(Query { origin, direction, inv_direction, tmin: ray.t_min, tmax: ray.t_max })
}

/// Returns a triangle in world space.
fn triangle(geometry: &Geometry, hit: Hit) -> Triangle {
    let [v0, v1, v2] = geometry.triangle(hit).vertices.map(Vec3A::from);
    Triangle { v0, v1, v2 }
}

/// Returns the depth of the tree; children come after their parents.
fn depth(tree: &CwBvh) -> u32 {
    if tree.nodes.is_empty() {
        return 0;
    }
    let mut depths = vec![1; tree.nodes.len()];
    for (node, parent) in tree.compute_parents().into_iter().enumerate().skip(1) {
        depths[node] = depths[parent as usize] + 1;
    }
    depths.into_iter().max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::{Build, bvh};
    use crate::geometry::{Attributes, Object, Opaque, TriangleMesh};
    use crate::lab::equivalence::DifferenceCounts;
    use crate::lab::hard_cases::{by_name, sphere};
    use glam::{Affine3A, Vec3};
    use std::sync::Arc;

    /// It has the same hits as our tree, up to ties and grazes, on a soup and on placed spheres; invalid rays hit
    /// nothing.
    #[test]
    fn cwbvh_hits_match_the_own_bvh() {
        for name in ["random", "sphere-random", "instances-outside", "not-finite"] {
            let case = by_name(name).expect("a case");
            let ours = bvh::BvhScene::build(case.geometry(), Build::Robust).expect("builds");
            let theirs = Cwbvh::build(case.geometry()).expect("builds");
            let tally = DifferenceCounts::of(case.geometry(), &case.rays(0..20_000), &theirs, &ours, false);
            assert_eq!((tally.rays, tally.true_differences), (20_000, 0), "{name}: {tally:?}");
            assert_eq!(tally.hits > 1_000, name != "not-finite", "{name}: {tally:?}");
        }
    }

    fn placed(faces: (Vec<Vec3>, Vec<[u32; 3]>), count: usize) -> Geometry {
        let mesh = TriangleMesh::new("mesh", faces.0, faces.1, Attributes::default()).expect("valid");
        let object = Object { mesh: 0, placement: Some(Affine3A::IDENTITY), filtered: false };
        Geometry { meshes: vec![Arc::new(mesh)], objects: vec![object; count] }
    }

    #[test]
    fn cwbvh_of_one_triangle_and_of_none() {
        let triangle = placed((vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]), 1);
        let ray = Ray::new(Vec3::new(0.2, 0.2, 1.0), Vec3::NEG_Z);
        for (geometry, hit) in [(triangle, Some(Hit { object: 0, primitive: 0 })), (Geometry::default(), None)] {
            let tree = Cwbvh::build(&geometry).expect("builds");
            assert_eq!((tree.closest(&ray, &Opaque), tree.occluded(&ray, &Opaque)), (hit, hit.is_some()));
            assert_eq!(tree.closest(&Ray { t_max: 0.5, ..ray }, &Opaque), None);
        }
    }

    #[test]
    fn too_many_instances_are_not_flattened() {
        let many = placed(sphere(4, 1.0, Vec3::ZERO), 1000);
        let error = Cwbvh::build(&many).err().expect("too many");
        assert!(error.kind == Kind::Memory && error.to_string().contains("5120000 triangles"), "{error}");
    }
}
