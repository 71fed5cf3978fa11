//! The rays of a batch walk through a tree in turns, a step each: while one waits for memory, others go on. Each takes
//! the steps that it would take alone.
//!
//! This pays only if the tree is much larger than the caches: see [`LARGE`]. In small trees bounce rays take a third more
//! time than one after the other.

use super::block::Block;
use super::ray::{Query, Slabs};
use super::stack::Stack;
use super::tree::{prefetch_next, step};
use super::{Mesh, Nearest};
use crate::geometry::{Ray, Rays};
use arrayvec::ArrayVec;
use std::ops::ControlFlow::{self, Continue};

/// Number of rays that walk in turns. On the landscape of two million triangles, 8 take 2 to 5 % more time, and 16 the
/// same.
const IN_TURNS: usize = 12;

/// Bytes of a mesh and its tree above which rays walk in turns, by measurements with 32 MB of third-level cache
/// (docs/measurements.md, Rays).
pub(super) const LARGE: usize = 16 << 20;

/// A ray on its way.
struct Walk {
    /// Its number in the batch.
    at: usize,
    ray: Ray,
    slabs: Slabs,
    query: Query,
    nearest: Nearest,
    /// The node or leaf that it visits next.
    next: u32,
}

impl Walk {
    #[inline]
    fn new(mesh: &Mesh, rays: &Rays, at: usize) -> Self {
        let ray = rays.ray(at);
        Walk {
            at,
            ray,
            slabs: Slabs::new(&ray, mesh.tree.extent()),
            query: Query::new(&ray),
            nearest: Nearest { t: ray.t_max, hit: None },
            next: mesh.tree.root(),
        }
    }
}

impl Mesh {
    /// Calls `block` for the blocks along each of `rays`, as [`Mesh::visit`] does, and `done(number of the ray, nearest
    /// hit, whether block broke)` at its end.
    #[inline]
    pub(super) fn visit_in_turns<const ORDERED: bool>(
        &self,
        rays: &Rays,
        block: impl Fn(&Ray, &Block, &Query, &mut Nearest) -> ControlFlow<()>,
        mut done: impl FnMut(usize, &Nearest, bool),
    ) {
        let (nodes, blocks) = (self.tree.nodes(), &*self.blocks);
        let mut waiting = 0..rays.len();
        // Stacks stay where they are: moving their arrays would take half of the time of a ray in a small scene.
        let begin = |at: usize| (Walk::new(self, rays, at), Stack::new());
        let mut walks: ArrayVec<(Walk, Stack), IN_TURNS> = waiting.by_ref().take(IN_TURNS).map(begin).collect();
        while !walks.is_empty() {
            let mut turn = 0;
            while let Some((walk, stack)) = walks.get_mut(turn) {
                let Walk { at, ray, slabs, query, nearest, next } = walk;
                let step = step::<ORDERED>(nodes, *next, slabs, stack, nearest, |leaf, nearest| {
                    block(ray, &blocks[leaf], query, nearest)
                });
                if let Continue(Some(child)) = step {
                    *next = child;
                    prefetch_next(nodes, blocks, child);
                    turn += 1;
                    continue;
                }
                done(*at, nearest, step.is_break());
                if let Some(at) = waiting.next() {
                    *walk = Walk::new(self, rays, at);
                    stack.clear();
                    turn += 1;
                } else {
                    walks.swap_remove(turn);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::accel::bvh::BvhScene;
    use crate::accel::{Build, Coherence, Intersector};
    use crate::geometry::{AnyHit, Attributes, Geometry, Hit, Hits, Object, Opaque, PADDING, Ray, Rays, TriangleMesh};
    use glam::Vec3;
    use std::sync::Arc;

    /// Rejects two triangles of three.
    struct Third;

    impl AnyHit for Third {
        fn accepts(&self, _: &Ray, hit: Hit) -> bool {
            hit.primitive % 3 == 0
        }
    }

    /// A sequence of pseudo-random vectors in −1..1.
    fn vectors() -> impl FnMut() -> Vec3 {
        let mut state = 1u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1 << 23) as f32 - 1.0
        };
        move || Vec3::from([(); 3].map(|()| random()))
    }

    fn scene(mut vector: impl FnMut() -> Vec3) -> BvhScene {
        let mut soup = |triangles: u32| {
            let centres: Vec<Vec3> = (0..triangles).map(|_| vector()).collect();
            let corners = centres.iter().flat_map(|&c| [c; 3]).map(|c| c + 0.1 * vector()).collect();
            let triangles = (0..triangles).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            Arc::new(TriangleMesh::new("soup", corners, triangles, Attributes::default()).expect("valid"))
        };
        let meshes = vec![soup(1_000), soup(300)];
        let objects = [(0, false), (1, true)].map(|(mesh, filtered)| Object { mesh, placement: None, filtered });
        let built = BvhScene::build(&Geometry { meshes, objects: objects.into() }, Build::Robust).expect("builds");
        assert!(!built.in_turns);
        BvhScene { in_turns: true, ..built }
    }

    /// Compares a batch of `count` rays, some of which are short, with single rays; returns the number of hits.
    fn hits_of_single_rays(
        scene: &BvhScene,
        count: usize,
        mut vector: impl FnMut() -> Vec3,
        any: &impl AnyHit,
    ) -> usize {
        let (mut rays, mut hits, mut occluded) = (Rays::new(count), Hits::new(count), vec![false; count + PADDING]);
        for at in 0..count {
            let t_max = if at % 3 == 0 { vector().length() } else { f32::INFINITY };
            rays.push(&Ray { t_max, ..Ray::new(1.5 * vector(), vector()) });
        }
        scene.closest_all(&rays, Coherence::Incoherent, any, &mut hits);
        scene.occluded_all(&rays, Coherence::Incoherent, any, &mut occluded);
        for (at, &occluded) in occluded[..count].iter().enumerate() {
            let ray = rays.ray(at);
            assert_eq!(hits.hit(at), scene.closest(&ray, any).unwrap_or(Hit::NONE), "{at} of {count}");
            assert_eq!(occluded, scene.occluded(&ray, any), "{at} of {count}");
        }
        occluded[..count].iter().filter(|&&occluded| occluded).count()
    }

    /// Batches of fewer and of more rays than walk in turns, with and without a filter.
    #[test]
    fn rays_in_turns_have_the_hits_of_single_rays() {
        let scene = scene(vectors());
        let mut vector = vectors();
        for count in [0, 1, 7, 12, 13, 2_000] {
            let opaque = hits_of_single_rays(&scene, count, &mut vector, &Opaque);
            let filtered = hits_of_single_rays(&scene, count, &mut vector, &Third);
            assert!(count < 2_000 || 1_700 > opaque && opaque > filtered && filtered > 100, "{opaque} {filtered}");
        }
    }
}
