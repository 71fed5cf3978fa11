//! A four-wide bounding volume hierarchy and its traversal.

use super::Nearest;
use super::ray::Slabs;
use crate::huge_vec::HugeVec;
use bytemuck::{Pod, Zeroable};
use glam::{BVec4A, Vec4};
use smallvec::SmallVec;
use std::ops::ControlFlow;

/// Flag of a leaf child; the other bits are its index.
pub(super) const LEAF: u32 = 1 << 31;

/// Stack entries kept off the heap: enough for typical trees.
const SHALLOW: usize = 96;

/// Four children and their boxes. Absent children have empty boxes, which no ray hits.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Node {
    /// Least x, greatest x, least y, … of the four.
    pub(super) planes: [Vec4; 6],
    /// Index of a node, or of a leaf with [`LEAF`] set.
    pub(super) children: [u32; 4],
}

impl Node {
    /// Returns a mask of the boxes that the ray enters before `reach`, and the entry parameters.
    #[inline]
    pub(super) fn meet(&self, ray: &Slabs, reach: f32) -> (u32, [f32; 4]) {
        let near = |k: usize| (self.planes[ray.first[k]] - ray.near_origin[k]) * ray.inverse[k];
        let far = |k: usize| (self.planes[ray.first[k] ^ 1] - ray.far_origin[k]) * ray.inverse[k];
        let enter = near(0).max(near(1)).max(near(2).max(ray.t_min));
        let leave = far(0).min(far(1)).min(far(2).min(Vec4::splat(reach)));
        let met: BVec4A = enter.cmple(leave);
        (met.bitmask(), enter.to_array())
    }
}

/// Nodes, starting at the root.
pub(super) struct Tree {
    nodes: HugeVec<Node>,
    root: u32,
    /// Largest coordinate of any box.
    extent: f32,
}

impl Tree {
    /// Returns a tree of `nodes` with coordinates of at most `extent`.
    pub(super) fn new(nodes: Vec<Node>, root: u32, extent: f32) -> Self {
        Tree { nodes: nodes.into(), root, extent }
    }

    #[inline]
    pub(super) fn extent(&self) -> f32 {
        self.extent
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.nodes)
    }

    /// Calls `leaf` for the leaves along the ray, approximately front to back, until it breaks. It may shorten the
    /// reach.
    #[inline]
    pub(super) fn visit(
        &self,
        ray: &Slabs,
        reach: &mut Nearest,
        mut leaf: impl FnMut(usize, &mut Nearest) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        // Not an array: its zero-initialisation takes a sixth of the time of a ray in a small scene.
        let mut stack = SmallVec::<[(u32, f32); SHALLOW]>::new();
        let (nodes, mut current) = (&*self.nodes, self.root);
        loop {
            if current & LEAF != 0 {
                leaf((current & !LEAF) as usize, reach)?;
            } else {
                let node = &nodes[current as usize];
                let (mut met, enter) = node.meet(ray, reach.t);
                if met != 0 {
                    let mut next = (u32::MAX, f32::INFINITY);
                    let first = met.trailing_zeros() as usize;
                    met &= met - 1;
                    (next.0, next.1) = (node.children[first], enter[first]);
                    while met != 0 {
                        let lane = met.trailing_zeros() as usize;
                        met &= met - 1;
                        let mut other = (node.children[lane], enter[lane]);
                        if other.1 < next.1 {
                            std::mem::swap(&mut other, &mut next);
                        }
                        stack.push(other);
                    }
                    current = next.0;
                    continue;
                }
            }
            loop {
                let Some((child, enter)) = stack.pop() else { return ControlFlow::Continue(()) };
                if enter <= reach.t {
                    current = child;
                    break;
                }
            }
        }
    }
}
