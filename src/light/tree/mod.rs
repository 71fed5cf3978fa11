//! The light tree: selection of a light for a receiver by bounds on what groups of lights contribute [ContyKulla18].
//!
//! A node has eight children, so that the tree of a thousand lights has three or four levels, and computes their
//! importance at once. Selection descends from the root by importance, and [`LightTree::pmf`] repeats the descent to a
//! known light with the same operations, so that both agree bit for bit. Where no light can arrive it selects one
//! nevertheless.
//!
//! It pays where many lights differ in distance or orientation, and at glossy receivers of which the lobe is known. It
//! does not know what stands between a light and the receiver. Lights at infinity are not in the tree.

mod build;
mod cut;
mod node;
mod reach;
#[cfg(test)]
mod tests;
mod upper;

pub use cut::Cut;
pub use reach::{Cone, Reach};
pub use upper::{GroupValues, LightGroup};

use super::LightSampleContext;
use build::Item;
use node::{LEAF, Node};
use smallvec::SmallVec;

/// The largest f64 below 1.
pub(super) const BELOW_ONE_F64: f64 = 1.0 - f64::EPSILON / 2.0;

/// A tree over lights with a place.
#[derive(Debug)]
pub struct LightTree {
    /// The root comes first.
    nodes: Vec<Node>,
    /// Node of each light and the place in it; `None` for lights that are not in the tree.
    places: Vec<Option<(u32, u32)>>,
}

/// The selection of a light, on its way.
#[derive(Debug, Clone, Copy)]
pub struct Descent {
    /// The node, or the light with [`LEAF`].
    at: u32,
    u: f64,
    /// Probability of the selection so far.
    pub pmf: f64,
}

impl Descent {
    /// Begins at the root with `u` in [0, 1), where a descent begins with the probability `pmf`.
    pub fn new(u: f64, pmf: f64) -> Self {
        Descent { at: 0, u, pmf }
    }

    /// Returns the light at its end; `None` on the way.
    #[inline]
    pub fn light(&self) -> Option<u32> {
        (self.at & LEAF != 0).then_some(self.at & !LEAF)
    }
}

impl LightTree {
    /// Returns the tree over the lights with bounds; `None` if there are none.
    pub fn new(lights: &[Option<Reach>]) -> Option<Self> {
        let sum: f64 = lights.iter().flatten().map(|reach| reach.intensity).sum();
        if sum <= 0.0 {
            return None;
        }
        // No light vanishes beside others. A higher floor would take the selection from strong lights far away: the sun
        // has 1e24 times the intensity of a lamp.
        let floor = f64::from(f32::MIN_POSITIVE) * sum;
        let reach = |light: u32| {
            let reach = lights[light as usize].unwrap_or(Reach::NOTHING);
            Reach { intensity: reach.intensity.max(floor), ..reach }
        };
        let numbers = (0..lights.len() as u32).filter(|&light| lights[light as usize].is_some());
        let mut items: Vec<Item> = numbers.map(|light| Item::new(light, &reach(light))).collect();
        let nodes = build::grow(&mut items, &reach, sum).nodes;
        let mut places = vec![None; lights.len()];
        for (number, node) in nodes.iter().enumerate() {
            for (slot, &child) in node.children.iter().enumerate().filter(|(_, child)| **child & LEAF != 0) {
                places[(child & !LEAF) as usize] = Some((number as u32, slot as u32));
            }
        }
        Some(LightTree { nodes, places })
    }

    /// Returns the memory in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.places)
    }

    /// Whether it holds `light`.
    #[inline]
    pub fn has(&self, light: usize) -> bool {
        self.places[light].is_some()
    }

    /// Takes `descent` one level down for the receiver `at`.
    #[inline]
    pub fn step(&self, at: &LightSampleContext, descent: &mut Descent) {
        let node = &self.nodes[descent.at as usize];
        let weights = node.weights(at);
        let target = descent.u * weights.total();
        let (slot, below) = weights.find(target);
        let weight = f64::from(weights.of[slot]);
        descent.pmf *= weight / weights.total();
        descent.u = ((target - below) / weight).clamp(0.0, BELOW_ONE_F64);
        descent.at = node.children[slot];
    }

    /// Returns the probability that a descent for the receiver `at`, begun with the probability `begun`, selects `light`.
    pub fn pmf(&self, at: &LightSampleContext, light: usize, begun: f64) -> f64 {
        self.replay(at, light, begun, |id| id == 0)
    }

    /// Returns the probability that a descent for the receiver `at` selects `light`, where it begins with the
    /// probability `begun` at a node above the light or at the light itself, of which `begins` knows the number. It is 0
    /// if the descent begins elsewhere.
    fn replay(&self, at: &LightSampleContext, light: usize, begun: f64, begins: impl Fn(u32) -> bool) -> f64 {
        let Some(mut place) = self.places[light] else { return 0.0 };
        let (mut id, mut path) = (light as u32 | LEAF, SmallVec::<[(u32, u32); 16]>::new());
        while !begins(id) {
            if id == 0 {
                return 0.0;
            }
            path.push(place);
            id = place.0;
            place = self.nodes[id as usize].parent;
        }
        path.iter().rev().fold(begun, |pmf, &place| pmf * self.share(at, place))
    }

    /// Returns the probability of the child at `place`, a node and a place in it, once a descent is at its node.
    fn share(&self, at: &LightSampleContext, (node, slot): (u32, u32)) -> f64 {
        let weights = self.nodes[node as usize].weights(at);
        f64::from(weights.of[slot as usize]) / weights.total()
    }

    /// Returns an estimate of the irradiance of all its lights at the receiver, in units of the sum of intensities.
    pub fn importance(&self, at: &LightSampleContext) -> f64 {
        self.nodes[0].importance(at).into_iter().map(f64::from).sum()
    }
}
