//! Tree construction: obvhs builds a binary tree, which is collapsed to an eight-wide one.

use super::block::{Block, Corners, LANES};
use super::collapse::Collapse;
use super::node::{LEAF, Node};
use super::tree::Tree;
use crate::accel::Build;
use crate::geometry::Bounds;
use crate::huge_vec::HugeVec;
use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::PlocBuilder;
use obvhs::splits::split_aabbs_preset;
use obvhs::triangle::Triangle;
use obvhs::{Boundable, BvhBuildParams};

/// Cost of a node's test in units of a triangle's, by which obvhs merges leaves. It is higher than measured: a block of
/// eight triangles is tested at once, and full blocks take less memory, which decides the speed of large trees.
const TRAVERSAL_COST: f32 = 5.0;

/// The same for trees of at most [`CACHED`] triangles. They stay in the cache, and rays miss small leaves more often.
const TRAVERSAL_COST_CACHED: f32 = 3.0;

/// Number of triangles whose tree fits into the second-level cache of a core.
const CACHED: usize = 10_000;

/// Number of leaves from which a heap of them is too large to be improved.
const HEAP: u32 = 4096;

/// Largest share of its size by which a box becomes larger: rays hit no more boxes that can be measured.
const LARGER_BY: f32 = 1e-4;

/// The same for a point at the origin, in scene units. Its area is above the range of f32.
const LEAST_LARGER_BY: f32 = 1e-15;

/// Builds a tree over `triangles`, of which there is at least one, with its leaves.
pub(super) fn over_triangles(triangles: &[Corners], build: Build) -> (Tree, HugeVec<Block>) {
    let effort = effort(build);
    let bvh = if effort.pre_split {
        let (boxes, indices) = split(triangles);
        binary(&boxes, indices, effort, LANES as u32)
    } else {
        binary(triangles, every(triangles), effort, LANES as u32)
    };
    let mut blocks = Vec::new();
    let tree = widen(&bvh, |prims| {
        let leaf: Vec<Corners> = prims.iter().map(|&i| triangles[i as usize]).collect();
        blocks.push(Block::new(&leaf));
        blocks.len() - 1
    });
    (tree, blocks.into())
}

/// Builds a tree over `boxes`, of which there is at least one; the leaves are their indices.
pub(super) fn over_boxes(boxes: &[Bounds], build: Build) -> Tree {
    let boxes: Vec<Aabb> =
        (0..).zip(boxes).map(|(i, b)| told_apart(Aabb::new(b.min.into(), b.max.into()), i)).collect();
    let bvh = binary(&boxes, every(&boxes), effort(build), 1);
    widen(&bvh, |prims| prims[0] as usize)
}

fn effort(build: Build) -> BvhBuildParams {
    match build {
        Build::Fast => BvhBuildParams::very_fast_build(),
        Build::Robust | Build::Compact => BvhBuildParams::medium_build(),
        Build::High => BvhBuildParams::slow_build(),
    }
}

impl Boundable for Corners {
    fn aabb(&self) -> Aabb {
        told_apart(Aabb::from_points(&self.vertices.map(Vec3A::from)), self.hit.primitive)
    }
}

/// Returns `aabb` a little larger, by an amount that depends on `number`. PLOC merges two boxes that are each other's
/// cheapest partner. In a row of equal costs only the last two are, and a tree of a million equal boxes takes hours.
fn told_apart(aabb: Aabb, number: u32) -> Aabb {
    const ALONG: [u32; 3] = [0x9e37_79b9, 0x85eb_ca6b, 0xc2b2_ae35];
    let extent = aabb.min.abs().max(aabb.max.abs()).max_element();
    let most = LARGER_BY * aabb.diagonal().max_element() + f32::EPSILON * extent + LEAST_LARGER_BY;
    let share = ALONG.map(|factor| number.wrapping_mul(factor) as f32 / u32::MAX as f32);
    Aabb::new(aabb.min, aabb.max + most * Vec3A::from_array(share))
}

impl From<&Corners> for Triangle {
    fn from(corners: &Corners) -> Self {
        let [v0, v1, v2] = corners.vertices.map(Vec3A::from);
        Triangle { v0, v1, v2 }
    }
}

/// Returns the indices of all `items`.
fn every<T>(items: &[T]) -> Vec<u32> {
    (0..items.len() as u32).collect()
}

/// Splits large triangles and returns boxes around the parts.
fn split(triangles: &[Corners]) -> (Vec<Aabb>, Vec<u32>) {
    let (mut boxes, mut indices): (Vec<Aabb>, _) = (triangles.iter().map(Boundable::aabb).collect(), every(triangles));
    let areas = boxes.iter().map(Aabb::half_area);
    let (sum, largest) = areas.fold((0.0, 0.0f32), |(sum, largest), area| (sum + f64::from(area), largest.max(area)));
    let mean = (sum / boxes.len() as f64) as f32;
    let triangles: Vec<Triangle> = triangles.iter().map(Triangle::from).collect();
    split_aabbs_preset(&mut boxes, &mut indices, &triangles, mean, largest);
    (boxes, indices)
}

fn binary<B: Boundable>(boxes: &[B], indices: Vec<u32>, effort: BvhBuildParams, most_in_leaf: u32) -> Bvh2 {
    let mut builder = PlocBuilder::with_capacity(boxes.len());
    let mut bvh = builder.build(
        effort.ploc_search_distance,
        boxes,
        indices,
        effort.sort_precision,
        effort.search_depth_threshold,
    );
    bvh.uses_spatial_splits = effort.pre_split;
    let mut optimizer = ReinsertionOptimizer::default();
    let ratio = effort.reinsertion_batch_ratio;
    let ratio = if ratio > 0.0 && has_heap(&bvh) { 0.0 } else { ratio };
    optimizer.run(&mut bvh, ratio, None);
    if most_in_leaf > 1 {
        let cost = if boxes.len() <= CACHED { TRAVERSAL_COST_CACHED } else { TRAVERSAL_COST };
        collapse(&mut bvh, most_in_leaf, cost);
        optimizer.run(&mut bvh, ratio * effort.post_collapse_reinsertion_batch_ratio_multiplier, None);
    }
    bvh
}

/// Whether thousands of leaves of `bvh` lie one in the other. The search for better places in such a heap visits all of
/// it, once for each leaf.
fn has_heap(bvh: &Bvh2) -> bool {
    // Number of leaves below each node, and the sum of their areas. Children follow their parent.
    let mut below = vec![(0, 0.0f64); bvh.nodes.len()];
    for (i, node) in bvh.nodes.iter().enumerate().rev() {
        let area = f64::from(node.aabb().half_area());
        if node.is_leaf() {
            below[i] = (1, area);
            continue;
        }
        let [left, right] = [0, 1].map(|k| below[node.first_index as usize + k]);
        below[i] = (left.0 + right.0, left.1 + right.1);
        if below[i].0 >= HEAP && below[i].1 >= 0.25 * f64::from(below[i].0) * area {
            return true;
        }
    }
    false
}

/// Collapses `bvh` to a wide tree; `leaf` stores the primitives of a leaf and returns its index.
fn widen(bvh: &Bvh2, mut leaf: impl FnMut(&[u32]) -> usize) -> Tree {
    let mut name = |node: &Bvh2Node| {
        let first = node.first_index as usize;
        LEAF | leaf(&bvh.primitive_indices[first..first + node.prim_count as usize]) as u32
    };
    let root = &bvh.nodes[0];
    let extent = root.aabb().min.abs().max(root.aabb().max.abs()).max_element();
    if root.is_leaf() {
        return Tree::new(Vec::new(), name(root), extent);
    }
    let collapse = Collapse::new(bvh);
    let mut nodes = vec![Node::EMPTY];
    // Binary inner nodes that become wide nodes, with their slots.
    let mut open = vec![(root, 0)];
    while let Some((binary, slot)) = open.pop() {
        for (lane, child) in collapse.children(binary).into_iter().enumerate() {
            let child = &bvh.nodes[child as usize];
            let index = if child.is_leaf() {
                name(child)
            } else {
                nodes.push(Node::EMPTY);
                open.push((child, nodes.len() - 1));
                nodes.len() as u32 - 1
            };
            nodes[slot].set(lane, child.aabb(), index);
        }
    }
    Tree::new(nodes, 0, extent)
}
