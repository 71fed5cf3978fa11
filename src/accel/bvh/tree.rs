//! An eight-wide bounding volume hierarchy and its traversal.

use super::Nearest;
use super::node::{LEAF, Node};
use super::ray::Slabs;
use super::stack::{Entry, Stack};
use crate::huge_vec::HugeVec;
use std::ops::ControlFlow;

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
        let mut current = self.root;
        loop {
            if current & LEAF != 0 {
                leaf((current & !LEAF) as usize, reach)?;
            } else {
                let node = &nodes[current as usize];
                let (lanes, enter) = node.meet(ray, reach.t);
                let entry = |lane: usize| Entry::new(enter[lane], node.child(lane));
                let kept =
                    if ORDERED { stack.push_but_nearest(lanes, entry) } else { stack.push_but_one(lanes, entry) };
                if let Some(child) = kept {
                    current = child;
                    continue;
                }
            }
            let Some(child) = stack.pop(reach.t) else { return ControlFlow::Continue(()) };
            current = child;
        }
    }
}
