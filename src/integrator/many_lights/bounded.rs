//! Cuts of bounded error: deterministic lightcuts [Walter05 §3].
//!
//! One virtual light of each group stands for the group, always the same, in proportion to the intensities. The group of
//! the greatest error bound is replaced by its parts until no bound is above a share τ of the light at the receiver.
//! A bound holds whatever the visibility. The errors of groups have either sign and mostly cancel: their sum is not
//! bounded by τ, but tests find it below in every pixel. To bound the sum as well takes nearly all lights: the light of
//! any group may be hidden, so that groups of more than one light could have a share τ of the light at most.

use super::gather::{Gather, Limited, Receiver};
use super::virtual_lights::{VirtualLight, bound};
use crate::bsdf::ScatteringBound;
use crate::light::{GroupValues, LightGroup, LightTree};
use crate::path::TraceStats;
use crate::sampling::Sampler;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// The virtual lights of a pass as a hierarchy of groups with error bounds.
pub(super) struct BoundedGroups {
    tree: LightTree,
    summaries: GroupValues<Summary>,
    /// Largest error of a group, as a share of the light.
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

    /// Returns the light at `at`, where no group has an error of more than the share.
    pub(super) fn gather(
        &self,
        gather: &Gather,
        at: &Receiver,
        sampler: &mut impl Sampler,
        tally: &mut TraceStats,
    ) -> Limited {
        let ScatteringBound { diffuse, glossy } = bound(at.shading.point, at.shading.surface, at.shading.known());
        let lights = gather.virtual_lights;
        let mut contribution = |number: usize| gather.contribution(&lights[number], at, 0, sampler, tally);
        let (first, _) = self.summary(lights, LightGroup::ALL).representative;
        let whole = Group {
            group: LightGroup::ALL,
            representative: first,
            contribution: contribution(first),
            times: 1.0,
            error: f64::INFINITY,
        };
        let mut light = whole.light();
        let mut cut = BinaryHeap::from([whole]);
        while cut.peek().is_some_and(|greatest| greatest.error > self.share * light.max(0.0)) {
            let Some(parent) = cut.pop() else { break };
            light -= parent.light();
            for (group, upper) in self.tree.parts(parent.group, &at.context(), [diffuse, glossy]) {
                let Summary { most, representative: (number, alone) } = self.summary(lights, group);
                let limited = most[1] * f64::from(gather.limit.most());
                let error = if group.light().is_some() { 0.0 } else { (most[0] * f64::from(upper)).min(limited) };
                let known = number == parent.representative;
                let part = Group {
                    group,
                    representative: number,
                    contribution: if known { parent.contribution } else { contribution(number) },
                    times: if alone > 0.0 { most[0] / alone } else { 0.0 },
                    error,
                };
                light += part.light();
                cut.push(part);
            }
        }
        cut.iter().fold(Limited::ZERO, |sum, group| sum.plus(group.contribution, group.times as f32))
    }
}
