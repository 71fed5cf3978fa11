//! The pure-Rust backend: trees built by obvhs (PLOC with parallel reinsertion) and made eight-wide, with a traversal
//! and a watertight triangle test of our own. It needs no C library and is as portable as Rust. Its results equal those
//! of [`super::embree`] except for ties.
//!
//! Objects without a placement share one tree of world-space triangles. Placed objects are leaves of a second tree; the
//! ray is transformed to the space of their mesh's own tree, with unchanged parameter.
//!
//! Watertight in every [`super::Build`]: the signs of edge functions are exact for the sheared vertices [Woop13], and
//! boxes are widened by the error of that shear (see `ray.rs`). The nearest hit does not depend on the tree: at equal
//! distances the smaller object and triangle index is chosen.
//!
//! Limits: no motion blur. Coordinates are at most 1.8e18. Directions shorter than 1e-36 lose hits. Triangles seen from
//! more than 1e7 times their size away are as small as the rounding of their coordinates, and rays beside them may hit.

mod block;
mod build;
mod collapse;
mod lanes;
mod node;
mod ray;
mod stack;
mod tree;
mod turns;

use crate::accel::{Build, Coherence, Intersector, closest_of_each, occluded_of_each, placed};
use crate::error::Result;
use crate::geometry::{AnyHit, Bounds, Geometry, Hit, Hits, Ray, Rays, placement_error};
use crate::huge_vec::HugeVec;
use block::{Block, Corners};
use glam::{Affine3A, Vec3};
use ray::{Query, Slabs};
use std::ops::ControlFlow::{self, Break, Continue};
use std::sync::Arc;
use tree::Tree;

/// Triangles and the tree over them; a leaf of the tree is a block.
struct Mesh {
    tree: Tree,
    blocks: HugeVec<Block>,
}

/// A placed mesh.
struct Instance {
    mesh: Arc<Mesh>,
    to_object: Affine3A,
    object: u32,
}

/// Committed geometry. It is immutable, so that any number of threads may query it.
pub struct BvhScene {
    /// Objects without a placement.
    world: Option<Mesh>,
    instances: Box<[Instance]>,
    /// Tree over the instances; each leaf is one instance.
    top: Option<Tree>,
    /// By object: whether the filter applies.
    filtered: Box<[bool]>,
    any_filtered: bool,
    /// Whether the rays of a batch walk through `world` in turns.
    in_turns: bool,
}

/// The nearest hit so far, or the end of the ray.
#[derive(Clone, Copy)]
struct Nearest {
    t: f32,
    hit: Option<Hit>,
}

impl BvhScene {
    /// Builds the trees over `geometry` in the current rayon pool.
    ///
    /// # Errors
    /// A scene error if an object has a singular placement or exceeds ±1.8e18; an internal error if an object refers to
    /// a missing mesh.
    pub fn build(geometry: &Geometry, build: Build) -> Result<BvhScene> {
        let bounds = placed::bounds(geometry)?;
        let mut prototypes: Vec<Option<Arc<Mesh>>> = vec![None; geometry.meshes.len()];
        let (mut world, mut instances, mut boxes) = (Vec::new(), Vec::new(), Vec::new());
        for (object, bounds) in (0..).zip(&bounds) {
            let placed = &geometry.objects[object as usize];
            let Some(placement) = &placed.placement else {
                world.extend(corners(geometry, object));
                continue;
            };
            let mesh = prototypes[placed.mesh as usize].get_or_insert_with(|| {
                let triangles: Vec<Corners> = corners(geometry, object).collect();
                Arc::new(Mesh::new(&triangles, build))
            });
            let pad = placement_error(placement, Vec3::splat(mesh.tree.extent()));
            boxes.push(Bounds { min: bounds.min - pad, max: bounds.max + pad });
            instances.push(Instance { mesh: Arc::clone(mesh), to_object: placement.inverse(), object });
        }
        let filtered: Box<[bool]> = geometry.objects.iter().map(|object| object.filtered).collect();
        let world = (!world.is_empty()).then(|| Mesh::new(&world, build));
        Ok(BvhScene {
            in_turns: instances.is_empty() && world.as_ref().is_some_and(|world| world.bytes() > turns::LARGE),
            world,
            top: (!boxes.is_empty()).then(|| build::over_boxes(&boxes, build)),
            instances: instances.into(),
            any_filtered: filtered.contains(&true),
            filtered,
        })
    }

    /// Returns the memory of all trees in bytes.
    pub fn bytes(&self) -> usize {
        let mut meshes: Vec<&Arc<Mesh>> = self.instances.iter().map(|i| &i.mesh).collect();
        meshes.sort_by_key(|mesh| Arc::as_ptr(mesh));
        meshes.dedup_by_key(|mesh| Arc::as_ptr(mesh));
        let meshes =
            meshes.into_iter().map(|mesh| mesh.bytes()).sum::<usize>() + self.world.as_ref().map_or(0, Mesh::bytes);
        meshes + self.top.as_ref().map_or(0, Tree::bytes) + size_of_val(&*self.instances)
    }

    /// Calls `block(block, ray in its space, object of an instance, reach)` for all blocks along the ray, until it
    /// breaks; if `ORDERED`, approximately front to back.
    #[inline]
    fn visit<const ORDERED: bool>(
        &self,
        ray: &Ray,
        reach: &mut Nearest,
        mut block: impl FnMut(&Block, &Query, Option<u32>, &mut Nearest) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        if let Some(world) = &self.world {
            world.visit::<ORDERED>(ray, reach, |b, query, reach| block(b, query, None, reach))?;
        }
        let Some(top) = &self.top else { return Continue(()) };
        top.visit::<ORDERED>(&Slabs::new(ray, top.extent()), reach, |leaf, reach| {
            let instance = &self.instances[leaf];
            let local = Ray {
                origin: instance.to_object.transform_point3(ray.origin),
                direction: instance.to_object.transform_vector3(ray.direction),
                ..*ray
            };
            instance
                .mesh
                .visit::<ORDERED>(&local, reach, |b, query, reach| block(b, query, Some(instance.object), reach))
        })
    }

    /// Returns the only tree of the scene if the rays of a batch walk through it in turns.
    fn world_in_turns(&self) -> Option<&Mesh> {
        self.world.as_ref().filter(|_| self.in_turns)
    }

    /// Moves `nearest` to the nearest hit of `block` if that is nearer.
    #[inline]
    fn approach(
        &self,
        ray: &Ray,
        any: &impl AnyHit,
        block: &Block,
        query: &Query,
        instance: Option<u32>,
        nearest: &mut Nearest,
    ) -> ControlFlow<()> {
        block.meet(query, nearest.t, |t, lane| {
            let hit = block.hit(lane, instance);
            if nearest.is_beyond(t, hit) && self.accepts(ray, hit, any) {
                *nearest = Nearest { t, hit: Some(hit) };
            }
            Continue(())
        })
    }

    /// Breaks if `block` has a hit.
    #[inline]
    fn block(
        &self,
        ray: &Ray,
        any: &impl AnyHit,
        block: &Block,
        query: &Query,
        instance: Option<u32>,
        reach: &Nearest,
    ) -> ControlFlow<()> {
        block.meet(query, reach.t, |_, lane| {
            if self.accepts(ray, block.hit(lane, instance), any) { Break(()) } else { Continue(()) }
        })
    }

    /// Returns whether a candidate is a hit, by the filter where it applies.
    #[inline]
    fn accepts<A: AnyHit>(&self, ray: &Ray, hit: Hit, any: &A) -> bool {
        !(A::FILTERS && self.any_filtered && self.filtered[hit.object as usize]) || any.accepts(ray, hit)
    }
}

impl Intersector for BvhScene {
    #[inline]
    fn closest(&self, ray: &Ray, any: &impl AnyHit) -> Option<Hit> {
        let mut nearest = Nearest { t: ray.t_max, hit: None };
        let _ = self.visit::<true>(ray, &mut nearest, |block, query, instance, nearest| {
            self.approach(ray, any, block, query, instance, nearest)
        });
        nearest.hit
    }

    #[inline]
    fn occluded(&self, ray: &Ray, any: &impl AnyHit) -> bool {
        let mut reach = Nearest { t: ray.t_max, hit: None };
        let walked = self.visit::<false>(ray, &mut reach, |block, query, instance, reach| {
            self.block(ray, any, block, query, instance, reach)
        });
        walked.is_break()
    }

    fn closest_all(&self, rays: &Rays, _: Coherence, any: &impl AnyHit, hits: &mut Hits) {
        let Some(world) = self.world_in_turns() else {
            return closest_of_each(self, rays, any, hits);
        };
        world.visit_in_turns::<true>(
            rays,
            |ray, block, query, nearest| self.approach(ray, any, block, query, None, nearest),
            |at, nearest, _| hits.set(at, nearest.hit),
        );
    }

    fn occluded_all(&self, rays: &Rays, _: Coherence, any: &impl AnyHit, occluded: &mut [bool]) {
        let Some(world) = self.world_in_turns() else {
            return occluded_of_each(self, rays, any, occluded);
        };
        world.visit_in_turns::<false>(
            rays,
            |ray, block, query, reach| self.block(ray, any, block, query, None, reach),
            |at, _, is_blocked| occluded[at] = is_blocked,
        );
    }
}

impl Nearest {
    /// Returns whether a hit at `t` is nearer; at equal distances the ids decide, so that the result does not depend on
    /// the tree.
    #[inline]
    fn is_beyond(&self, t: f32, hit: Hit) -> bool {
        let precedes = |held: Hit| (hit.object, hit.primitive) < (held.object, held.primitive);
        t < self.t || (t <= self.t && self.hit.is_none_or(precedes))
    }
}

impl Mesh {
    fn new(triangles: &[Corners], build: Build) -> Mesh {
        let (tree, blocks) = build::over_triangles(triangles, build);
        Mesh { tree, blocks }
    }

    fn bytes(&self) -> usize {
        self.tree.bytes() + size_of_val(&*self.blocks)
    }

    #[inline]
    fn visit<const ORDERED: bool>(
        &self,
        ray: &Ray,
        reach: &mut Nearest,
        mut block: impl FnMut(&Block, &Query, &mut Nearest) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let query = Query::new(ray);
        let blocks = &*self.blocks;
        self.tree.visit::<ORDERED>(&Slabs::new(ray, self.tree.extent()), reach, |leaf, reach| {
            block(&blocks[leaf], &query, reach)
        })
    }
}

/// Returns the triangles of an object in the space of its mesh.
fn corners(geometry: &Geometry, object: u32) -> impl Iterator<Item = Corners> + '_ {
    let mesh = geometry.mesh_of(object);
    let positions = mesh.positions();
    (0..).zip(mesh.triangles()).map(move |(primitive, t)| Corners {
        vertices: t.map(|i| positions[i as usize]),
        hit: Hit { object, primitive },
    })
}
