//! Primary sample space Metropolis light transport: chains of the random numbers of bidirectional path tracing
//! [Kelemen02]. A state is the set of all paths of one sample; its target is their weighted contribution. Without
//! connections and splats (`--without`) the chains mutate the random numbers of the path tracer.

use super::contribution::Contribution;
use super::primary::{NAMES, PathSampler, PrimaryState, mixture};
use super::seeds::{ByTechnique, Candidate};
use super::{ChainContext, MarkovMethod};
use crate::mcmc::Mixture;
use crate::mcmc::primary::Source;
use crate::path::TraceStats;
use crate::sampling::Address;
use crate::spectrum::Spectrum;

/// The method.
pub(super) struct PrimarySpace<'a> {
    pub(super) common: ChainContext<'a>,
    /// Probability of a large step.
    pub(super) large_step: f64,
}

impl PrimarySpace<'_> {
    /// Draws the state of the sample at `address`.
    fn draw(&self, address: Address, state: &mut PrimaryState) {
        state.found.clear();
        state.point.clear();
        self.sample(state.point.draw(address), &mut state.found, &mut state.tally);
    }
}

impl PathSampler for PrimarySpace<'_> {
    fn sample(&self, [mut camera, light, _]: [Source; 3], found: &mut Contribution, tally: &mut TraceStats) {
        let ChainContext { tracer, region, importance, .. } = &self.common;
        let sample = self.common.camera_sample(&mut camera);
        let mut add = |_, _, film: [f32; 2], color: Spectrum| {
            if region.contains(film) {
                found.add(importance, film, color);
            }
        };
        let mut sink = ByTechnique { common: &self.common, film: sample.film, found: &mut add };
        tracer.sample(&sample, &mut camera, || light, &mut sink, tally);
    }
}

impl MarkovMethod for PrimarySpace<'_> {
    type State = PrimaryState;

    fn common(&self) -> &ChainContext<'_> {
        &self.common
    }

    fn classes(&self) -> usize {
        1
    }

    fn class_of(&self, _: usize) -> usize {
        0
    }

    fn candidates(&self, address: Address, found: &mut Vec<Candidate>, tally: &mut TraceStats) {
        let mut state = PrimaryState::default();
        self.draw(address, &mut state);
        tally.absorb(&state.tally);
        if state.found.scalar() != 0.0 {
            found.push(Candidate { sample: 0, s: 0, t: 0, scalar: state.found.scalar() });
        }
    }

    fn start(&self, _: &Candidate, address: Address, x: &mut PrimaryState) -> bool {
        self.draw(address, x);
        x.found.scalar() > 0.0
    }

    fn kernels(&self, _: usize) -> Mixture<'_, PrimaryState> {
        mixture(self, self.large_step)
    }

    fn names(&self) -> &'static [&'static str] {
        &NAMES
    }
}
