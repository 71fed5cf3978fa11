//! A small binary tree of boxes over some things of a scene, for questions that no backend answers: exact ones, and those about boxes.

use crate::geometry::{Bounds, Hit, Triangle};
use std::ops::ControlFlow;

/// Things in a leaf.
const IN_LEAF: usize = 4;

/// What a tree can hold.
pub trait Bounded {
    /// The box around it.
    fn bounds(&self) -> Bounds;
}

/// A triangle and its name.
#[derive(Debug, Clone, Copy)]
pub struct Leaf {
    /// Its name.
    pub hit: Hit,
    /// Itself, in the world.
    pub triangle: Triangle,
}

impl Bounded for Leaf {
    fn bounds(&self) -> Bounds {
        Bounds::around(self.triangle.vertices)
    }
}

#[derive(Debug)]
struct Node {
    bounds: Bounds,
    /// The first thing of a leaf, or the second child of an inner node, whose first one comes next.
    first: u32,
    /// Things of a leaf; 0 of an inner node.
    count: u32,
}

/// The tree.
#[derive(Debug)]
pub struct BoxTree<T> {
    nodes: Vec<Node>,
    leaves: Vec<T>,
}

impl<T> Default for BoxTree<T> {
    fn default() -> Self {
        BoxTree { nodes: Vec::new(), leaves: Vec::new() }
    }
}

impl<T: Bounded> BoxTree<T> {
    /// A tree over `leaves`, fewer than 2³².
    pub fn new(mut leaves: Vec<T>) -> Self {
        let mut nodes = Vec::with_capacity(leaves.len());
        if !leaves.is_empty() {
            grow(&mut nodes, &mut leaves, 0);
        }
        BoxTree { nodes, leaves }
    }

    /// What it holds.
    pub fn leaves(&self) -> &[T] {
        &self.leaves
    }

    /// The box around everything.
    pub fn bounds(&self) -> Bounds {
        self.nodes.first().map_or(Bounds::EMPTY, |root| root.bounds)
    }

    /// Calls `leaf` for the things in boxes that `enters` lets in, until it breaks.
    #[inline]
    pub fn visit(&self, enters: impl Fn(&Bounds) -> bool, mut leaf: impl FnMut(&T) -> ControlFlow<()>) -> ControlFlow<()> {
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

/// Adds the nodes over `leaves`, the first of which is the tree's number `first`. Halves of equal count: depth is the logarithm.
fn grow<T: Bounded>(nodes: &mut Vec<Node>, leaves: &mut [T], first: u32) {
    let bounds = leaves.iter().map(T::bounds).fold(Bounds::EMPTY, Bounds::union);
    let own = nodes.len();
    nodes.push(Node { bounds, first, count: leaves.len() as u32 });
    if leaves.len() <= IN_LEAF {
        return;
    }
    let size = bounds.max - bounds.min;
    let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
    let middle = leaves.len() / 2;
    leaves.select_nth_unstable_by(middle, |a, b| a.bounds().center()[axis].total_cmp(&b.bounds().center()[axis]));
    let (low, high) = leaves.split_at_mut(middle);
    grow(nodes, low, first);
    nodes[own].first = nodes.len() as u32;
    nodes[own].count = 0;
    grow(nodes, high, first + middle as u32);
}
