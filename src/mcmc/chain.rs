//! Metropolis and Hastings's chain over any states.

use super::Numbers;
use crate::defects::{Defect, planted};

/// A state of a chain.
pub trait State {
    /// Logarithm of the density that chains sample, up to a constant; −∞ where it is 0.
    fn log_target(&self) -> f64;
}

/// A way to propose states.
pub trait Kernel<S> {
    /// How gladly it is taken at `x`, relative to the others of a mixture; 0 where it cannot do anything.
    fn suitability(&self, x: &S) -> f64;

    /// Proposes the state `y`, which holds any state before. What is returned is the logarithm of the density with which the kernel would
    /// propose `x` at `y` over that of `y` at `x`; `None` if there is no proposal, and `y` then means nothing.
    fn propose(&self, x: &S, y: &mut S, numbers: &mut Numbers) -> Option<f64>;
}

/// What became of the proposals of a kernel.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct KernelCounts {
    /// How often it was taken.
    pub taken: u64,
    /// How often it made a proposal with a target above 0.
    pub proposed: u64,
    /// How often that was accepted.
    pub accepted: u64,
    /// Proposals whose acceptance was no number: rejected.
    pub nonfinite: u64,
}

impl KernelCounts {
    /// Adds those of another chain.
    pub fn absorb(&mut self, other: &KernelCounts) {
        self.taken += other.taken;
        self.proposed += other.proposed;
        self.accepted += other.accepted;
        self.nonfinite += other.nonfinite;
    }
}

/// Kernels, each taken with the probability of its share of all suitabilities at the state.
pub struct Mixture<'k, S> {
    kernels: Vec<Box<dyn Kernel<S> + Sync + 'k>>,
}

impl<'k, S> Mixture<'k, S> {
    /// Of these.
    pub fn new(kernels: Vec<Box<dyn Kernel<S> + Sync + 'k>>) -> Self {
        Mixture { kernels }
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.kernels.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.kernels.is_empty()
    }

    fn suitabilities<'a>(&'a self, x: &'a S) -> impl Iterator<Item = f64> + Clone + 'a {
        self.kernels.iter().map(|kernel| kernel.suitability(x))
    }

    /// Logarithm of the probability of taking kernel `index` at `x`.
    pub fn log_share(&self, index: usize, x: &S) -> f64 {
        let total: f64 = self.suitabilities(x).sum();
        (self.kernels[index].suitability(x) / total).ln()
    }
}

/// A chain: its state, and how much of the present one is to be deposited yet.
pub struct Chain<S> {
    x: S,
    y: S,
    weight: f64,
    counts: Vec<KernelCounts>,
}

impl<S: State> Chain<S> {
    /// At `x`, whose target is above 0; `y` is room for proposals.
    pub fn new(x: S, y: S) -> Self {
        debug_assert!(x.log_target() > f64::NEG_INFINITY, "a chain begins where the target is 0");
        Chain { x, y, weight: 0.0, counts: Vec::new() }
    }

    /// Where it is.
    pub fn state(&self) -> &S {
        &self.x
    }

    /// Its states, the present one and what was proposed last.
    pub fn into_states(self) -> (S, S) {
        (self.x, self.y)
    }

    /// What became of proposals so far, by kernel.
    pub fn counts(&self) -> &[KernelCounts] {
        &self.counts
    }

    /// One step. States are given to `deposit` with the expected value of their weight: what is accepted with probability a counts a where
    /// it is proposed, and the state before it 1 − a, whatever becomes of it [Veach97 §11.3.1]. In all each step deposits a weight of 1; that of
    /// a state where the chain stays is kept until it leaves, or [`Chain::flush`].
    pub fn step(&mut self, kernels: &Mixture<S>, numbers: &mut Numbers, mut deposit: impl FnMut(&S, f64)) {
        self.counts.resize(kernels.len(), KernelCounts::default());
        let Some(index) = numbers.choose(kernels.suitabilities(&self.x)) else {
            self.weight += 1.0;
            return;
        };
        self.counts[index].taken += 1;
        let proposed = kernels.kernels[index].propose(&self.x, &mut self.y, numbers);
        let acceptance = proposed.map_or(0.0, |log_ratio| self.acceptance(kernels, index, log_ratio));
        if proposed.is_some() || !planted(Defect::FailedProposalsForgotten) {
            self.weight += 1.0 - acceptance;
        }
        if acceptance > 0.0 && numbers.uniform() < acceptance {
            self.counts[index].accepted += 1;
            deposit(&self.x, self.weight);
            self.weight = acceptance;
            std::mem::swap(&mut self.x, &mut self.y);
        } else if acceptance > 0.0 {
            deposit(&self.y, acceptance);
        }
    }

    /// Deposits what is left.
    pub fn flush(&mut self, mut deposit: impl FnMut(&S, f64)) {
        deposit(&self.x, self.weight);
        self.weight = 0.0;
    }

    /// The probability of accepting `y`.
    fn acceptance(&mut self, kernels: &Mixture<S>, index: usize, log_ratio: f64) -> f64 {
        let log_y = self.y.log_target();
        if log_y == f64::NEG_INFINITY {
            return 0.0;
        }
        self.counts[index].proposed += 1;
        let log_ratio = if planted(Defect::HastingsForgotten) { 0.0 } else { log_ratio };
        let types = kernels.log_share(index, &self.y) - kernels.log_share(index, &self.x);
        let types = if planted(Defect::MutationTypeForgotten) { 0.0 } else { types };
        let log = log_y - self.x.log_target() + log_ratio + types;
        if log.is_nan() {
            self.counts[index].nonfinite += 1;
            return 0.0;
        }
        log.min(0.0).exp()
    }
}
