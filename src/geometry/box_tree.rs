//! A small binary bounding volume hierarchy, for queries that no backend answers: exact intersection, and overlap of
//! boxes.

use crate::geometry::{Bounds, Hit, Triangle};
use std::ops::ControlFlow;

/// Items per leaf.
const IN_LEAF: usize = 4;

/// An item of the tree.
pub trait Bounded {
    /// Returns the bounding box.
    fn bounds(&self) -> Bounds;
}

/// A triangle and its id.
#[derive(Debug, Clone, Copy)]
pub struct Leaf {
    /// Id of the triangle.
    pub hit: Hit,
    /// World-space triangle.
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
    /// First item of a leaf, or second child of an inner node; its first child is the next node.
    first: u32,
    /// Number of items of a leaf; 0 for an inner node.
    count: u32,
}

/// A bounding volume hierarchy.
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
    /// Builds a tree over `leaves`, fewer than 2³².
    pub fn new(mut leaves: Vec<T>) -> Self {
        let mut nodes = Vec::with_capacity(leaves.len());
        if !leaves.is_empty() {
            grow(&mut nodes, &mut leaves, 0);
        }
        BoxTree { nodes, leaves }
    }

    /// Returns all items.
    pub fn leaves(&self) -> &[T] {
        &self.leaves
    }

    /// Returns the bounding box of all items.
    pub fn bounds(&self) -> Bounds {
        self.nodes.first().map_or(Bounds::EMPTY, |root| root.bounds)
    }

    /// Calls `leaf` for the items of all leaves whose boxes satisfy `enters`, until it breaks.
    #[inline]
    pub fn visit(
        &self,
        enters: impl Fn(&Bounds) -> bool,
        mut leaf: impl FnMut(&T) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
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

/// Appends the nodes over `leaves`, whose first item has index `first` in the tree. Splits into halves of equal count,
/// so that the depth is logarithmic.
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
