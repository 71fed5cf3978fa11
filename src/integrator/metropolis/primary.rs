//! States and kernels of methods in primary sample space.

use super::ImageState;
use super::contribution::Contribution;
use crate::mcmc::primary::{PrimaryPoint, Source, Step};
use crate::mcmc::{Kernel, Mixture, Numbers, SmallStep, State};
use crate::path::TraceStats;

/// Map from random numbers to contributions.
pub(super) trait PathSampler: Send + Sync {
    /// Evaluates the random numbers of the camera, light and connection streams.
    fn sample(&self, numbers: [Source; 3], found: &mut Contribution, tally: &mut TraceStats);
}

/// A primary sample and its contribution.
#[derive(Debug, Clone, Default)]
pub(super) struct PrimaryState {
    pub(super) point: PrimaryPoint,
    pub(super) found: Contribution,
    pub(super) tally: TraceStats,
}

impl State for PrimaryState {
    fn log_target(&self) -> f64 {
        self.found.log_scalar()
    }
}

impl ImageState for PrimaryState {
    fn contribution(&self) -> &Contribution {
        &self.found
    }

    fn tally(&mut self) -> &mut TraceStats {
        &mut self.tally
    }
}

/// Kernel for one kind of step.
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

/// Names of the kernels.
pub(super) const NAMES: [&str; 2] = ["large-step", "small-step"];

/// Mixes large steps, with probability `large`, and small steps.
pub(super) fn mixture<P: PathSampler>(sampler: &P, large: f64) -> Mixture<'_, PrimaryState> {
    Mixture::new(vec![
        Box::new(Primary { sampler, step: Step::Large, probability: large }),
        Box::new(Primary { sampler, step: Step::Small(SmallStep::KELEMEN), probability: 1.0 - large }),
    ])
}
