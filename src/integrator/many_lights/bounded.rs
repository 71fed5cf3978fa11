//! Cuts of bounded error: deterministic lightcuts [Walter05 §3].
//!
//! One virtual light of each group stands for the group, always the same, in proportion to the intensities. The group
//! of the greatest error bound is replaced by its parts until the bounds of all groups sum to no more than a share τ of
//! the light. The error is then at most τ of the result, whatever the visibility.
//!
//! Walter ends where each bound is below τ of the light. That takes fewer lights, but errors of one sign add up: with
//! τ = .02 a pixel of Veach's plates was off by 17 %. The price of the guarantee is that most lights are in the cut,
//! since the light of any group may be hidden.

use super::limit::Limited;
use super::virtual_lights::VirtualLight;
use crate::bsdf::ScatteringBound;
use crate::light::{GroupValues, LightGroup, LightSampleContext, LightTree};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// The error is summed each time the cut has grown by this part.
const CHECKS: usize = 8;

/// The virtual lights of a pass as a hierarchy of groups with error bounds.
pub(super) struct BoundedGroups {
    tree: LightTree,
    summaries: GroupValues<Summary>,
    /// Largest error, as a share of the light.
    share: f64,
}

/// Sums over the lights of a group.
#[derive(Debug, Clone, Copy)]
struct Summary {
    /// Of both bounds of [`VirtualLight::most`].
    most: [f64; 2],
    /// The light that stands for the group, and its first bound.
    representative: (usize, f64),
}

/// A group of the current cut.
struct Group {
    group: LightGroup,
    /// Light that stands for it.
    representative: usize,
    /// What that light contributes.
    contribution: Limited,
    /// Intensity of the group over that of this light.
    times: f64,
    /// Bound of the error.
    error: f64,
}

impl Ord for Group {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error.total_cmp(&other.error)
    }
}
impl PartialOrd for Group {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Group {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Group {}

impl Group {
    fn light(&self) -> f64 {
        f64::from(self.contribution.light.mean()) * self.times
    }
}

impl Summary {
    fn of(light: &VirtualLight, number: usize) -> Self {
        let most = light.most();
        Summary { most, representative: (number, most[0]) }
    }
}

impl BoundedGroups {
    /// Returns the groups of `lights`; `None` if none shines.
    pub(super) fn new(lights: &[VirtualLight], tree: Option<LightTree>, share: f64) -> Option<Self> {
        let join = |a: Summary, b: Summary| Summary {
            most: [a.most[0] + b.most[0], a.most[1] + b.most[1]],
            representative: if a.most[0] >= b.most[0] { a.representative } else { b.representative },
        };
        let tree = tree?;
        let summaries = tree.joined(|number| Summary::of(&lights[number], number), join);
        Some(BoundedGroups { tree, summaries, share })
    }

    fn summary(&self, lights: &[VirtualLight], group: LightGroup) -> Summary {
        self.summaries.of(group, |number| Summary::of(&lights[number], number))
    }

    /// Returns the light at the receiver `at`, of the given bound, with an error of at most the share. `limit` is that
    /// of virtual lights; `contribution` returns what a light contributes.
    pub(super) fn gather(
        &self,
        lights: &[VirtualLight],
        (at, ScatteringBound { diffuse, glossy }): &(LightSampleContext, ScatteringBound),
        limit: f32,
        mut contribution: impl FnMut(usize) -> Limited,
    ) -> Limited {
        let (first, _) = self.summary(lights, LightGroup::ALL).representative;
        let whole = Group {
            group: LightGroup::ALL,
            representative: first,
            contribution: contribution(first),
            times: 1.0,
            error: f64::INFINITY,
        };
        let mut cut = BinaryHeap::from([whole]);
        let mut checked = 0;
        while cut.peek().is_some_and(|greatest| greatest.error > 0.0) {
            if cut.len() > checked {
                if self.is_enough(&cut) {
                    break;
                }
                checked = cut.len() + cut.len() / CHECKS;
            }
            let Some(parent) = cut.pop() else { break };
            for (group, upper) in self.tree.parts(parent.group, at, [*diffuse, *glossy]) {
                let Summary { most, representative: (number, alone) } = self.summary(lights, group);
                let limited = most[1] * f64::from(limit);
                let error = if group.light().is_some() { 0.0 } else { (most[0] * f64::from(upper)).min(limited) };
                let known = number == parent.representative;
                cut.push(Group {
                    group,
                    representative: number,
                    contribution: if known { parent.contribution } else { contribution(number) },
                    times: if alone > 0.0 { most[0] / alone } else { 0.0 },
                    error,
                });
            }
        }
        cut.iter().fold(Limited::ZERO, |sum, group| sum.plus(group.contribution, group.times as f32))
    }

    /// Whether the error of `cut` is within the share.
    fn is_enough(&self, cut: &BinaryHeap<Group>) -> bool {
        let sums = cut.iter().fold((0.0, 0.0), |(error, light), g| (error + g.error, light + g.light()));
        sums.0 <= self.share * sums.1
    }
}
