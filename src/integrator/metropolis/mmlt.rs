//! Multiplexed Metropolis light transport: a state is one path of one technique. A coordinate selects the technique
//! among all that sample paths of its length [Hachisuka14]. It costs a subpath from each end and one connection.
//!
//! Path lengths are classes with their own chains, normalisation and predetermined number of steps. If a chain could
//! stay at the length of its seed, the light of each length would depend on the choice of seeds, with an error that no
//! number of steps removes.

use super::contribution::Contribution;
use super::primary::{NAMES, PathSampler, PrimaryState, mixture};
use super::seeds::{ByTechnique, Candidate};
use super::{ChainContext, FEWEST_EVENTS, MarkovMethod, MmltConfig};
use crate::mcmc::primary::{PrimaryStream, Source};
use crate::mcmc::{Mixture, Numbers};
use crate::path::TraceStats;
use crate::sampling::{Address, Sampler, Slot};
use crate::spectrum::Spectrum;

/// Continuation probability per event for path lengths in the last class.
const GOES_ON: f64 = 0.75;

/// Number of integer coordinate values.
const CIRCLE: f64 = 4_294_967_296.0;

/// The method.
pub(super) struct Multiplexed<'a> {
    common: ChainContext<'a>,
    lengths: Vec<OneLength<'a>>,
    large_step: f64,
}

/// Paths of one length, or of all lengths from `events` on.
struct OneLength<'a> {
    common: ChainContext<'a>,
    events: usize,
    and_longer: bool,
}

impl<'a> Multiplexed<'a> {
    pub(super) fn new(common: ChainContext<'a>, config: MmltConfig) -> Self {
        let longest = common.options.max_depth.map_or(usize::MAX, |most| most as usize);
        let last = (config.mmlt_depths as usize).max(FEWEST_EVENTS).min(longest.max(FEWEST_EVENTS));
        let class = |events: usize, and_longer: bool| OneLength { common: common.clone(), events, and_longer };
        let mut lengths: Vec<OneLength> = (FEWEST_EVENTS..=last).map(|events| class(events, false)).collect();
        if last < longest {
            lengths.push(class(last + 1, true));
        }
        Multiplexed { common, lengths, large_step: config.large_step }
    }
}

impl OneLength<'_> {
    /// Selects a technique for paths of `events` events. Returns its number of light vertices and the number of
    /// techniques.
    fn technique(&self, events: usize, chosen: f64) -> Option<(usize, usize)> {
        let count = self.common.techniques(events).count();
        let nth = ((chosen * count as f64) as usize).min(count.max(1) - 1);
        self.common.techniques(events).nth(nth).map(|s| (s, count))
    }

    /// Maps the random number `u` to a number of events, and returns it with its probability.
    fn length(&self, u: f64) -> (usize, f64) {
        if !self.and_longer {
            return (self.events, 1.0);
        }
        let more = ((1.0 - u).ln() / GOES_ON.ln()) as i32;
        (self.events + more as usize, GOES_ON.powi(more) * (1.0 - GOES_ON))
    }

    /// Returns a coordinate value that [`OneLength::length`] maps to `events`.
    fn number_of(&self, events: usize, at: f64) -> u32 {
        let more = (events - self.events) as i32;
        let [start, end] = [more, more + 1].map(|n| 1.0 - GOES_ON.powi(n));
        number_in(start, end, at)
    }
}

/// Returns the integer coordinate at the fraction `at` of an interval.
fn number_in(start: f64, end: f64, at: f64) -> u32 {
    // Coordinates are read with the 24 bits of f32, and results stay this far from the ends.
    const MARGIN: f64 = 1.0 / 8_388_608.0;
    let margin = (MARGIN / (end - start)).min(0.5);
    ((start + (end - start) * at.clamp(margin, 1.0 - margin)) * CIRCLE) as u32
}

impl PathSampler for OneLength<'_> {
    fn sample(&self, [mut camera, mut light, mut join]: [Source; 3], found: &mut Contribution, tally: &mut TraceStats) {
        let ChainContext { tracer, region, importance, .. } = &self.common;
        let (events, pmf) = self.length(f64::from(join.u1(0, Slot::PathLength)));
        let Some((s, count)) = self.technique(events, f64::from(join.u1(0, Slot::Lobe))) else { return };
        let sample = self.common.camera_sample(&mut camera);
        let scale = (count as f64 / pmf) as f32;
        let mut add = |_, _, film: [f32; 2], color: Spectrum| {
            if region.contains(film) {
                found.add(importance, film, color * scale);
            }
        };
        let mut sink = ByTechnique { common: &self.common, film: sample.film, found: &mut add };
        tracer.technique([s, events + 2 - s], &sample, &mut camera, &mut light, &mut sink, tally);
    }
}

impl MarkovMethod for Multiplexed<'_> {
    type State = PrimaryState;

    fn common(&self) -> &ChainContext<'_> {
        &self.common
    }

    fn classes(&self) -> usize {
        self.lengths.len()
    }

    fn class_of(&self, events: usize) -> usize {
        (events - FEWEST_EVENTS).min(self.lengths.len() - 1)
    }

    fn candidates(&self, address: Address, found: &mut Vec<Candidate>, tally: &mut TraceStats) {
        Candidate::of_techniques(&self.common, address, found, tally);
    }

    fn start(&self, seed: &Candidate, address: Address, x: &mut PrimaryState) -> bool {
        let class = &self.lengths[self.class_of(seed.events())];
        let (s, events) = (usize::from(seed.s), seed.events());
        let nth = self.common.techniques(events).take_while(|&other| other < s).count();
        let count = self.common.techniques(events).count();
        let mut numbers = Numbers::new(address);
        let [technique, length] = [numbers.uniform(), numbers.uniform()];
        x.point.clear();
        let part = |n: usize| n as f64 / count as f64;
        x.point.set(PrimaryStream::Connection, 0, Slot::Lobe, number_in(part(nth), part(nth + 1), technique));
        x.point.set(PrimaryStream::Connection, 0, Slot::PathLength, class.number_of(events, length));
        x.found.clear();
        class.sample(x.point.draw(address), &mut x.found, &mut x.tally);
        x.found.scalar() > 0.0
    }

    fn kernels(&self, class: usize) -> Mixture<'_, PrimaryState> {
        mixture(&self.lengths[class], self.large_step)
    }

    fn names(&self) -> &'static [&'static str] {
        &NAMES
    }
}
