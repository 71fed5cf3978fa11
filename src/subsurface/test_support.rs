//! Random numbers and hypothesis tests of the tests.

use super::numeric::integrate_to_infinity;

/// SplitMix64 [Steele14].
pub(super) struct Random(pub(super) u64);

impl Random {
    /// Returns a uniform variate in [0, 1).
    pub(super) fn uniform(&mut self) -> f64 {
        super::reference::split_mix(&mut self.0)
    }
}

/// Standard deviations of a two-sided normal test at the level 1e-6.
pub(super) const SIGMAS: f64 = 4.8916;

/// Number of equally probable bins of [`chi_square`].
pub(super) const BINS: usize = 32;

/// Quantile of χ² with 31 degrees of freedom that is exceeded with probability 1e-6.
const CRITICAL: f64 = 83.64;

/// Tests at the level 1e-6 whether shares in [0, 1] are uniform.
///
/// # Panics
/// If the test fails.
pub(super) fn assert_uniform(shares: impl Iterator<Item = f64>, what: &str) {
    let mut counts = [0u32; BINS];
    let mut total = 0.0;
    for share in shares {
        counts[((share * BINS as f64) as usize).min(BINS - 1)] += 1;
        total += 1.0;
    }
    let expected = total / BINS as f64;
    let statistic: f64 = counts.iter().map(|&n| (f64::from(n) - expected).powi(2) / expected).sum();
    assert!(statistic < CRITICAL, "{what}: χ² = {statistic} of {} bins", BINS);
}

/// Returns 2π ∫ r f(r) dr over (0, ∞), for `f` that falls like e^(−r / `length`) or faster at the end.
pub(super) fn integrate_plane(length: f64, f: impl Fn(f64) -> f64) -> f64 {
    std::f64::consts::TAU * length * length * integrate_to_infinity(|x| x * f(length * x))
}
