//! Cuts through the light tree: disjoint groups that hold every light which can reach a receiver [Walter05 §3].
//!
//! A cut begins with the root. The group of the greatest importance is replaced by its parts until the cut is large
//! enough. One light of each group then stands for the group [Yuksel19 §4].

use super::node::{LEAF, WIDTH};
use super::{Descent, LightTree};
use crate::light::LightSampleContext;
use smallvec::{SmallVec, smallvec};

/// Groups of a cut that need no memory of their own.
const INLINE: usize = 32;

/// A group: a node, or a light with [`LEAF`].
#[derive(Debug, Clone, Copy)]
struct Group {
    id: u32,
    importance: f32,
}

/// Disjoint groups of lights, for one receiver.
#[derive(Debug, Clone, Default)]
pub struct Cut(SmallVec<[Group; INLINE]>);

impl Cut {
    /// Returns the number of groups.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether no light can reach the receiver.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    fn has(&self, id: u32) -> bool {
        self.0.iter().any(|group| group.id == id)
    }
}

impl LightTree {
    /// Returns a cut for the receiver `at` of at most `size` groups, and of one for less than 8.
    pub fn cut(&self, at: &LightSampleContext, size: usize) -> Cut {
        let mut cut = Cut(smallvec![Group { id: 0, importance: self.importance(at) as f32 }]);
        while let Some(greatest) = divisible(&cut) {
            if cut.len() - 1 + WIDTH > size {
                break;
            }
            let Group { id, .. } = cut.0.swap_remove(greatest);
            self.open(id, at, &mut cut);
        }
        cut
    }

    /// Adds the children of node number `id` that can reach the receiver.
    fn open(&self, id: u32, at: &LightSampleContext, cut: &mut Cut) {
        let node = &self.nodes[id as usize];
        let groups = node.children.into_iter().zip(node.importance(at));
        cut.0.extend(groups.filter(|group| group.1 > 0.0).map(|(id, importance)| Group { id, importance }));
    }

    /// Selects a light of group number `group` of `cut` by `u` in [0, 1). Returns it with its probability.
    pub fn sample_group(&self, cut: &Cut, group: usize, at: &LightSampleContext, u: f64) -> (u32, f64) {
        let mut descent = Descent { at: cut.0[group].id, u, pmf: 1.0 };
        loop {
            if let Some(light) = descent.light() {
                return (light, descent.pmf);
            }
            self.step(at, &mut descent);
        }
    }

    /// Returns the probability with which [`LightTree::sample_group`] selects `light` in its group of `cut`; 0 if it is
    /// in none.
    pub fn cut_pmf(&self, cut: &Cut, at: &LightSampleContext, light: usize) -> f64 {
        self.replay(at, light, 1.0, |id| cut.has(id))
    }
}

/// Returns the place of the group with the greatest importance that is not a single light.
fn divisible(cut: &Cut) -> Option<usize> {
    let nodes = cut.0.iter().enumerate().filter(|(_, group)| group.id & LEAF == 0);
    nodes.max_by(|a, b| a.1.importance.total_cmp(&b.1.importance)).map(|(place, _)| place)
}
