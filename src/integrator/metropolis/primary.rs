//! States and kernels of methods whose chains live in primary sample space.

use super::Lit;
use super::contribution::Contribution;
use crate::mcmc::primary::{Point, Source, Step};
use crate::mcmc::{Kernel, Mixture, Numbers, SmallStep, State};
use crate::path::Tally;

/// A map from numbers to light.
pub(super) trait PathSampler: Send + Sync {
    /// What the numbers of the streams for camera, light and connection find.
    fn sample(&self, numbers: [Source; 3], found: &mut Contribution, tally: &mut Tally);
}

/// A point and what it finds.
#[derive(Debug, Clone, Default)]
pub(super) struct PrimaryState {
    pub(super) point: Point,
    pub(super) found: Contribution,
    pub(super) tally: Tally,
}

impl State for PrimaryState {
    fn log_target(&self) -> f64 {
        self.found.log_scalar()
    }
}

impl Lit for PrimaryState {
    fn contribution(&self) -> &Contribution {
        &self.found
    }

    fn tally(&mut self) -> &mut Tally {
        &mut self.tally
    }
}

/// Takes one kind of step in the space of a sampler.
struct Primary<'a, P> {
    sampler: &'a P,
    step: Step,
    probability: f64,
}

impl<P: PathSampler> Kernel<PrimaryState> for Primary<'_, P> {
    fn suitability(&self, _: &PrimaryState) -> f64 {
        self.probability
    }

    fn propose(&self, x: &PrimaryState, y: &mut PrimaryState, numbers: &mut Numbers) -> Option<f64> {
        y.found.clear();
        let sources = y.point.propose(&x.point, self.step, numbers.address());
        self.sampler.sample(sources, &mut y.found, &mut y.tally);
        // Both kinds of steps are symmetric.
        Some(0.0)
    }
}

/// Their names.
pub(super) const NAMES: [&str; 2] = ["large-step", "small-step"];

/// Large steps with probability `large`, and small ones.
pub(super) fn mixture<P: PathSampler>(sampler: &P, large: f64) -> Mixture<'_, PrimaryState> {
    Mixture::new(vec![
        Box::new(Primary { sampler, step: Step::Large, probability: large }),
        Box::new(Primary { sampler, step: Step::Small(SmallStep::KELEMEN), probability: 1.0 - large }),
    ])
}
