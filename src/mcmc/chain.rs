//! Metropolis–Hastings chain over arbitrary states.

use super::Numbers;

/// State of a chain.
pub trait State {
    /// Returns the logarithm of the target density, up to a constant; −∞ where it is 0.
    fn log_target(&self) -> f64;
}

/// Proposal kernel.
pub trait Kernel<S> {
    /// Unnormalised selection probability of this kernel at `x`; 0 where it is not applicable.
    fn suitability(&self, x: &S) -> f64;

    /// Writes the proposal to `y`, which holds any earlier state. Returns the logarithm of the proposal density of `x`
    /// from `y` over that of `y` from `x`. `None` if there is no proposal; `y` is then unspecified.
    fn propose(&self, x: &S, y: &mut S, numbers: &mut Numbers) -> Option<f64>;
}

/// Proposal counts of a kernel.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct KernelCounts {
    /// Times the kernel was selected.
    pub taken: u64,
    /// Proposals with a target above 0.
    pub proposed: u64,
    /// Accepted proposals.
    pub accepted: u64,
    /// Proposals with a NaN acceptance probability, which are rejected.
    pub nonfinite: u64,
}

impl KernelCounts {
    /// Adds the counts of another chain.
    pub fn absorb(&mut self, other: &KernelCounts) {
        self.taken += other.taken;
        self.proposed += other.proposed;
        self.accepted += other.accepted;
        self.nonfinite += other.nonfinite;
    }
}

/// Mixture of kernels, each selected with a probability proportional to its suitability at the current state.
pub struct Mixture<'k, S> {
    kernels: Vec<Box<dyn Kernel<S> + Sync + 'k>>,
}

impl<'k, S> Mixture<'k, S> {
    /// Creates the mixture of `kernels`.
    pub fn new(kernels: Vec<Box<dyn Kernel<S> + Sync + 'k>>) -> Self {
        Mixture { kernels }
    }

    /// Number of kernels.
    pub fn len(&self) -> usize {
        self.kernels.len()
    }

    /// Whether the mixture is empty.
    pub fn is_empty(&self) -> bool {
        self.kernels.is_empty()
    }

    fn suitabilities<'a>(&'a self, x: &'a S) -> impl Iterator<Item = f64> + Clone + 'a {
        self.kernels.iter().map(|kernel| kernel.suitability(x))
    }

    /// Returns the logarithm of the probability of selecting kernel `index` at `x`.
    pub fn log_share(&self, index: usize, x: &S) -> f64 {
        let total: f64 = self.suitabilities(x).sum();
        (self.kernels[index].suitability(x) / total).ln()
    }
}

/// A chain: its state, and the pending deposit weight of the current state.
pub struct Chain<S> {
    x: S,
    y: S,
    weight: f64,
    counts: Vec<KernelCounts>,
}

impl<S: State> Chain<S> {
    /// Starts a chain at `x`, with a target above 0. `y` is storage for proposals.
    pub fn new(x: S, y: S) -> Self {
        debug_assert!(x.log_target() > f64::NEG_INFINITY, "a chain begins where the target is 0");
        Chain { x, y, weight: 0.0, counts: Vec::new() }
    }

    /// Current state.
    pub fn state(&self) -> &S {
        &self.x
    }

    /// Returns the current state and the storage of the last proposal.
    pub fn into_states(self) -> (S, S) {
        (self.x, self.y)
    }

    /// Proposal counts so far, by kernel.
    pub fn counts(&self) -> &[KernelCounts] {
        &self.counts
    }

    /// Advances the chain by one step. Deposits use expected values: a proposal with acceptance probability a deposits
    /// weight a, and the current state 1 − a, whether or not the proposal is accepted [Veach97 §11.3.1]. The weights of
    /// a step sum to 1. The weight of the current state accumulates until the chain leaves it, or until
    /// [`Chain::flush`].
    pub fn step(&mut self, kernels: &Mixture<S>, numbers: &mut Numbers, mut deposit: impl FnMut(&S, f64)) {
        self.counts.resize(kernels.len(), KernelCounts::default());
        let Some(index) = numbers.choose(kernels.suitabilities(&self.x)) else {
            self.weight += 1.0;
            return;
        };
        self.counts[index].taken += 1;
        let proposed = kernels.kernels[index].propose(&self.x, &mut self.y, numbers);
        let acceptance = proposed.map_or(0.0, |log_ratio| self.acceptance(kernels, index, log_ratio));
        self.weight += 1.0 - acceptance;
        if acceptance > 0.0 && numbers.uniform() < acceptance {
            self.counts[index].accepted += 1;
            deposit(&self.x, self.weight);
            self.weight = acceptance;
            std::mem::swap(&mut self.x, &mut self.y);
        } else if acceptance > 0.0 {
            deposit(&self.y, acceptance);
        }
    }

    /// Deposits the pending weight.
    pub fn flush(&mut self, mut deposit: impl FnMut(&S, f64)) {
        deposit(&self.x, self.weight);
        self.weight = 0.0;
    }

    /// Returns the probability of accepting `y`.
    fn acceptance(&mut self, kernels: &Mixture<S>, index: usize, log_ratio: f64) -> f64 {
        let log_y = self.y.log_target();
        if log_y == f64::NEG_INFINITY {
            return 0.0;
        }
        self.counts[index].proposed += 1;
        let types = kernels.log_share(index, &self.y) - kernels.log_share(index, &self.x);
        let log = log_y - self.x.log_target() + log_ratio + types;
        if log.is_nan() {
            self.counts[index].nonfinite += 1;
            return 0.0;
        }
        log.min(0.0).exp()
    }
}
