//! Discrete distributions.

use super::{Discrete, Pdf};
use crate::numeric::BELOW_ONE;
use etendue_lanes::{Float, Int};

/// Samples an index with probability proportional to its weight, by monotone inversion of the CDF. Unlike alias tables,
/// this preserves stratification.
#[derive(Debug, Clone)]
pub struct Distribution {
    /// CDF at the upper end of each index, rounded to f32 so that samples and probabilities agree exactly.
    upper: Vec<f32>,
}

/// Number of indices up to which all are compared.
const FEW: usize = 8;

impl Distribution {
    /// Returns the distribution of `weights` (finite, not negative), or `None` if all are zero or there are none.
    pub fn new(weights: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sum = 0.0f64;
        let sums: Vec<f64> = weights
            .into_iter()
            .map(|w| {
                debug_assert!(w.is_finite() && w >= 0.0, "weight {w}");
                sum += w;
                sum
            })
            .collect();
        if sum <= 0.0 || !sum.is_finite() {
            return None;
        }
        let mut upper: Vec<f32> = sums.iter().map(|s| (s / sum) as f32).collect();
        // The last index of positive weight must reach exactly 1.
        let last = sums.iter().position(|&s| s >= sum)?;
        upper[last..].fill(1.0);
        Some(Distribution { upper })
    }

    /// Returns the number of indices.
    #[inline]
    pub fn len(&self) -> usize {
        self.upper.len()
    }

    /// Returns whether there is no index; never true for a constructed distribution.
    pub fn is_empty(&self) -> bool {
        self.upper.is_empty()
    }

    /// Returns the probability of index `i`.
    #[inline]
    pub fn pmf(&self, i: usize) -> Pdf<Discrete> {
        let lower = if i == 0 { 0.0 } else { self.upper[i - 1] };
        Pdf::new(self.upper[i] - lower)
    }

    /// Samples the index at `u` in [0, 1); returns it with its probability, which is positive.
    #[inline]
    pub fn sample(&self, u: f32) -> (usize, Pdf<Discrete>) {
        let i = self.upper.partition_point(|&c| c <= u);
        (i, self.pmf(i))
    }

    /// Whether there are so few indices that a number that has chosen one is precise enough to be used again.
    #[inline]
    pub fn is_short(&self) -> bool {
        self.upper.len() <= FEW
    }

    /// Samples an index at each `u` in [0, 1). Returns it with its probability and the rescaled `u`, which is uniform in
    /// [0, 1) again. Few indices are compared with all at once, which saves branches.
    #[inline(always)]
    pub fn sample_lanes<F: Float>(&self, u: F) -> (F::Int, F, F) {
        let (index, lower, upper) = if self.is_short() { self.compared(u) } else { self.searched(u) };
        let pmf = upper - lower;
        (index, pmf, ((u - lower) / pmf).min(F::splat(BELOW_ONE)))
    }

    /// Returns the indices at `u` and their bounds.
    #[inline(always)]
    fn searched<F: Float>(&self, u: F) -> (F::Int, F, F) {
        let index = F::Int::from_fn(|lane| self.upper.partition_point(|&c| c <= u.lane(lane)) as u32);
        let bound = |at: usize| if at == 0 { 0.0 } else { self.upper[at - 1] };
        let bounds = |beyond: usize| F::from_fn(|lane| bound(index.lane(lane) as usize + beyond));
        (index, bounds(0), bounds(1))
    }

    /// Does [`Distribution::searched`] by comparisons with all bounds.
    #[inline(always)]
    fn compared<F: Float>(&self, u: F) -> (F::Int, F, F) {
        let (mut index, mut lower, mut upper) = (F::splat(0.0), F::splat(0.0), F::splat(self.upper[0]));
        for pair in self.upper.windows(2) {
            let beyond = !u.below(F::splat(pair[0]));
            index = index + F::select(beyond, F::splat(1.0), F::splat(0.0));
            lower = F::select(beyond, F::splat(pair[0]), lower);
            upper = F::select(beyond, F::splat(pair[1]), upper);
        }
        (index.to_int(), lower, upper)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::next_down;

    #[test]
    fn probabilities_sum_to_one_and_zero_weights_are_never_chosen() {
        let d = Distribution::new([0.0, 3.0, 0.0, 1.0, 0.0]).expect("positive");
        let total: f32 = (0..d.len()).map(|i| d.pmf(i).value()).sum();
        assert_eq!(total, 1.0);
        for (u, want) in [(0.0, 1), (0.7499, 1), (0.75, 3), (0.999_999_94, 3)] {
            assert_eq!(d.sample(u).0, want);
        }
        assert_eq!(d.pmf(1).value(), 0.75);
    }

    #[test]
    fn all_zero_weights_give_no_distribution() {
        assert!(Distribution::new([]).is_none());
        assert!(Distribution::new([0.0, 0.0]).is_none());
    }

    /// Rounding to f32 must not silently remove the probability of a positive weight: samples have the stated
    /// probability, checked at every boundary.
    #[test]
    fn choices_agree_with_their_probability_at_every_boundary() {
        let d = Distribution::new((1..=1000).map(f64::from)).expect("positive");
        for i in 0..1000 {
            let lower = if i == 0 { 0.0 } else { d.upper[i - 1] };
            assert_eq!(d.sample(lower).0, i);
            assert_eq!(d.sample(next_down(d.upper[i])).0, i);
        }
    }
}
