//! An eight-wide bounding volume hierarchy and its traversal.

use super::Nearest;
use super::node::{LEAF, Node};
use super::ray::Slabs;
use super::stack::{Entry, Stack};
use crate::huge_vec::HugeVec;
use etendue_lanes::prefetch;
use std::ops::ControlFlow::{self, Continue};

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

    /// Returns the node or leaf at which a walk begins.
    #[inline]
    pub(super) fn root(&self) -> u32 {
        self.root
    }

    /// Calls `leaf` for the leaves along the ray until it breaks; if `ORDERED`, approximately front to back, for which
    /// children are sorted. It may shorten the reach.
    #[inline]
    pub(super) fn visit<const ORDERED: bool>(
        &self,
        ray: &Slabs,
        reach: &mut Nearest,
        mut leaf: impl FnMut(usize, &mut Nearest) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let (nodes, mut stack) = (&*self.nodes, Stack::new());
        let mut next = Some(self.root);
        while let Some(current) = next {
            next = step::<ORDERED>(nodes, current, ray, &mut stack, reach, &mut leaf)?;
        }
        Continue(())
    }

    /// Returns the nodes, for [`step`].
    #[inline]
    pub(super) fn nodes(&self) -> &[Node] {
        &self.nodes
    }
}

/// Visits the node or leaf `current` and returns the next one, if any; breaks as `leaf` does.
#[inline(always)] // a call would pass everything through memory
pub(super) fn step<const ORDERED: bool>(
    nodes: &[Node],
    current: u32,
    ray: &Slabs,
    stack: &mut Stack,
    reach: &mut Nearest,
    leaf: impl FnOnce(usize, &mut Nearest) -> ControlFlow<()>,
) -> ControlFlow<(), Option<u32>> {
    if current & LEAF != 0 {
        leaf((current & !LEAF) as usize, reach)?;
    } else {
        let node = &nodes[current as usize];
        let (lanes, enter) = node.meet(ray, reach.t);
        let entry = |lane: usize| Entry::new(enter[lane], node.child(lane));
        let kept = if ORDERED { stack.push_but_nearest(lanes, entry) } else { stack.push_but_one(lanes, entry) };
        if kept.is_some() {
            return Continue(kept);
        }
    }
    Continue(stack.pop(reach.t))
}

/// Fetches the node or leaf `next` into the caches.
#[inline(always)]
pub(super) fn prefetch_next<L>(nodes: &[Node], leaves: &[L], next: u32) {
    if next & LEAF != 0 {
        prefetch(&leaves[(next & !LEAF) as usize]);
    } else {
        prefetch(&nodes[next as usize]);
    }
}
