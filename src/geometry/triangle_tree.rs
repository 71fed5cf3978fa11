//! A small binary tree of boxes over some triangles of a scene, for questions that no backend answers: exact ones, and those about boxes.

use crate::geometry::{Bounds, Hit, Triangle};
use std::ops::ControlFlow;

/// Triangles in a leaf.
const IN_LEAF: usize = 4;

/// A triangle and its name.
#[derive(Debug, Clone, Copy)]
pub struct Leaf {
    /// Its name.
    pub hit: Hit,
    /// Itself, in the world.
    pub triangle: Triangle,
}

#[derive(Debug)]
struct Node {
    bounds: Bounds,
    /// The first triangle of a leaf, or the second child of an inner node, whose first one comes next.
    first: u32,
    /// Triangles of a leaf; 0 of an inner node.
    count: u32,
}

/// The tree.
#[derive(Debug, Default)]
pub struct TriangleTree {
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
}

impl TriangleTree {
    /// A tree over `leaves`, fewer than 2³².
    pub fn new(mut leaves: Vec<Leaf>) -> Self {
        let mut nodes = Vec::with_capacity(leaves.len());
        if !leaves.is_empty() {
            grow(&mut nodes, &mut leaves, 0);
        }
        TriangleTree { nodes, leaves }
    }

    /// What it holds.
    pub fn leaves(&self) -> &[Leaf] {
        &self.leaves
    }

    /// The box around everything.
    pub fn bounds(&self) -> Bounds {
        self.nodes.first().map_or(Bounds::EMPTY, |root| root.bounds)
    }

    /// Calls `leaf` for the triangles in boxes that `enters` lets in, until it breaks.
    #[inline]
    pub fn visit(&self, enters: impl Fn(&Bounds) -> bool, mut leaf: impl FnMut(&Leaf) -> ControlFlow<()>) -> ControlFlow<()> {
        let mut stack = smallvec::SmallVec::<[u32; 64]>::new();
        if !self.nodes.is_empty() {
            stack.push(0);
        }
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index as usize];
            if !enters(&node.bounds) {
                continue;
            }
            if node.count == 0 {
                stack.extend([node.first, index + 1]);
            } else {
                self.leaves[node.first as usize..][..node.count as usize].iter().try_for_each(&mut leaf)?;
            }
        }
        ControlFlow::Continue(())
    }
}

/// The box around a triangle.
fn around(leaf: &Leaf) -> Bounds {
    Bounds::around(leaf.triangle.vertices)
}

/// Adds the nodes over `leaves`, the first of which is the tree's number `first`. Halves of equal count: depth is the logarithm.
fn grow(nodes: &mut Vec<Node>, leaves: &mut [Leaf], first: u32) {
    let bounds = leaves.iter().map(around).fold(Bounds::EMPTY, Bounds::union);
    let own = nodes.len();
    nodes.push(Node { bounds, first, count: leaves.len() as u32 });
    if leaves.len() <= IN_LEAF {
        return;
    }
    let size = bounds.max - bounds.min;
    let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
    let middle = leaves.len() / 2;
    leaves.select_nth_unstable_by(middle, |a, b| around(a).center()[axis].total_cmp(&around(b).center()[axis]));
    let (low, high) = leaves.split_at_mut(middle);
    grow(nodes, low, first);
    nodes[own].first = nodes.len() as u32;
    nodes[own].count = 0;
    grow(nodes, high, first + middle as u32);
}
