//! Choice of the nodes of a binary tree that become nodes of a wide one: those of least total surface area, by dynamic
//! programming [Ylitie17 §3.1]. The expected number of node tests of a random ray is proportional to that area. The
//! leaves stay as they are.

use super::node::WIDTH;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;

/// Least areas of wide nodes below a binary node, if at most 1, 2, … wide nodes and leaves are its topmost ones.
type Areas = [f32; WIDTH - 1];

/// A binary tree with the areas for all its nodes.
pub(super) struct Collapse<'a> {
    bvh: &'a Bvh2,
    areas: Vec<Areas>,
}

impl<'a> Collapse<'a> {
    /// Computes the areas for all nodes of `bvh`.
    pub(super) fn new(bvh: &'a Bvh2) -> Self {
        let mut all = Collapse { bvh, areas: vec![[0.0; WIDTH - 1]; bvh.nodes.len()] };
        for index in inner_nodes(bvh).into_iter().rev() {
            all.areas[index as usize] = all.areas_of(&bvh.nodes[index as usize]);
        }
        all
    }

    fn areas_of(&self, inner: &Bvh2Node) -> Areas {
        let mut areas = [inner.aabb().half_area() + self.divide(inner, WIDTH).0; WIDTH - 1];
        for i in 1..areas.len() {
            areas[i] = areas[i - 1].min(self.divide(inner, i + 1).0);
        }
        areas
    }

    /// Returns the least area if `most` wide nodes are divided among the children of `inner`, and the left one's share.
    fn divide(&self, inner: &Bvh2Node, most: usize) -> (f32, usize) {
        let [left, right] = children(inner).map(|child| &self.areas[child as usize]);
        let area = |of_left: usize| (left[of_left - 1] + right[most - of_left - 1], of_left);
        (2..most).map(area).fold(area(1), |best, next| if next.0 < best.0 { next } else { best })
    }

    /// Returns the indices of the children of the wide node that replaces `inner`: two to [`WIDTH`] binary nodes.
    pub(super) fn children(&self, inner: &Bvh2Node) -> Vec<u32> {
        let mut found = Vec::with_capacity(WIDTH);
        self.collect(inner, WIDTH, &mut found);
        found
    }

    fn collect(&self, inner: &Bvh2Node, most: usize, found: &mut Vec<u32>) {
        let of_left = self.divide(inner, most).1;
        for (child, most) in children(inner).into_iter().zip([of_left, most - of_left]) {
            let areas = &self.areas[child as usize];
            // The fewest that have the least area.
            let needed = (1..most).rfind(|&i| areas[i] < areas[i - 1]).map_or(1, |i| i + 1);
            if needed == 1 { found.push(child) } else { self.collect(&self.bvh.nodes[child as usize], needed, found) }
        }
    }
}

/// Returns the indices of the children of an inner node.
fn children(inner: &Bvh2Node) -> [u32; 2] {
    [inner.first_index, inner.first_index + 1]
}

/// Returns the indices of all inner nodes, parents before their children.
fn inner_nodes(bvh: &Bvh2) -> Vec<u32> {
    let is_inner = |&index: &u32| !bvh.nodes[index as usize].is_leaf();
    let mut found = Vec::from_iter(Some(0).filter(is_inner));
    let mut next = 0;
    while let Some(&index) = found.get(next) {
        found.extend(children(&bvh.nodes[index as usize]).into_iter().filter(is_inner));
        next += 1;
    }
    found
}
