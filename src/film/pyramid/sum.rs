//! The sum over a tile's pixels in one channel, with its error.

use crate::film::Independent;
use crate::stats::Estimate;

/// The replicates of a picture, each with its share of the passes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Replicates(Vec<f64>);

impl Replicates {
    /// Replicates with these numbers of passes; `None` if one is empty or there are fewer than
    /// [`super::LEAST_REPLICATES`].
    pub(crate) fn of(passes: &[u64]) -> Option<Self> {
        let is_usable = passes.len() >= super::LEAST_REPLICATES && passes.iter().all(|&n| n > 0);
        let total: f64 = passes.iter().map(|&n| n as f64).sum();
        is_usable.then(|| Replicates(passes.iter().map(|&n| n as f64 / total).collect()))
    }

    /// Replicates with these shares of the passes, from a file.
    pub(crate) fn of_shares(shares: &[f32]) -> Option<Self> {
        let total: f64 = shares.iter().map(|&share| f64::from(share)).sum();
        let is_usable = shares.len() >= super::LEAST_REPLICATES && shares.iter().all(|&s| s > 0.0 && s.is_finite());
        is_usable.then(|| Replicates(shares.iter().map(|&share| f64::from(share) / total).collect()))
    }

    /// Returns the shares of the passes.
    pub(crate) fn shares(&self) -> &[f64] {
        &self.0
    }

    /// Returns the number of replicates.
    pub(crate) fn count(&self) -> usize {
        self.0.len()
    }

    /// Degrees of freedom of a variance between replicates.
    pub(crate) fn dof(&self) -> f64 {
        self.0.len() as f64 - 1.0
    }

    /// Mean over all passes, from the means of the replicates.
    pub(crate) fn mean(&self, means: &[f64]) -> f64 {
        means.iter().zip(&self.0).map(|(mean, share)| mean * share).sum()
    }

    /// Variance of this mean. Unbiased if the variance of a replicate is inversely proportional to its number of
    /// passes.
    pub(crate) fn variance(&self, means: &[f64]) -> f64 {
        let mean = self.mean(means);
        means.iter().zip(&self.0).map(|(m, share)| share * (m - mean) * (m - mean)).sum::<f64>() / self.dof()
    }

    /// Third cumulant of this mean: Fisher's k₃ over R² for equal shares, to first order for unequal ones.
    pub(crate) fn third(&self, means: &[f64]) -> f64 {
        let (mean, n) = (self.mean(means), self.0.len() as f64);
        let cubes: f64 = means.iter().zip(&self.0).map(|(m, share)| share * share * (m - mean).powi(3)).sum();
        cubes * n / ((n - 1.0) * (n - 2.0))
    }
}

/// Sums over parts of a tile with independent errors: of value, variance, squared variance and third cumulant.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Parts {
    pub(crate) value: f64,
    pub(crate) variance: f64,
    pub(crate) squares: f64,
    pub(crate) third: f64,
}

impl Parts {
    /// One part.
    pub(crate) fn one(value: f64, variance: f64, third: f64) -> Self {
        Parts { value, variance, squares: variance * variance, third }
    }

    pub(crate) fn add(&mut self, other: &Parts) {
        self.value += other.value;
        self.variance += other.variance;
        self.squares += other.squares;
        self.third += other.third;
    }
}

/// A sum over pixels.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Sum {
    /// Pixels with samples of their own: variances add up.
    Pixels(Parts),
    /// Pixels that share light subpaths. Kept by replicate for the variance, and by smallest tile for the skewness,
    /// since a light subpath reaches few of them.
    Splats {
        /// Sum of the pixel means, by replicate.
        by_replicate: Vec<f64>,
        /// Moments summed over the smallest tiles.
        tiles: Parts,
    },
    /// Pixels that share chains: kept by replicate only.
    Chains(Vec<f64>),
}

impl Sum {
    /// An empty sum; `independent` tells which units of the picture are independent.
    pub(crate) fn new(independent: Independent, replicates: &Replicates) -> Self {
        let by_replicate = vec![0.0; replicates.count()];
        match independent {
            Independent::Pixels => Sum::Pixels(Parts::default()),
            Independent::Blocks => Sum::Splats { by_replicate, tiles: Parts::default() },
            Independent::Replicates => Sum::Chains(by_replicate),
        }
    }

    /// Adds a pixel, given its mean in each replicate.
    pub(crate) fn add_pixel(&mut self, means: &[f64], replicates: &Replicates) {
        match self {
            Sum::Pixels(parts) => parts.add(&part(means, replicates)),
            Sum::Splats { by_replicate: sums, .. } | Sum::Chains(sums) => add(sums, means),
        }
    }

    /// Completes a smallest tile after all its pixels were added.
    pub(crate) fn finish(&mut self, replicates: &Replicates) {
        if let Sum::Splats { by_replicate, tiles } = self {
            *tiles = part(by_replicate, replicates);
        }
    }

    /// Adds another tile of the same picture.
    pub(crate) fn merge(&mut self, other: &Sum) {
        match (self, other) {
            (Sum::Pixels(a), Sum::Pixels(b)) => a.add(b),
            (Sum::Splats { by_replicate: a, tiles }, Sum::Splats { by_replicate: b, tiles: more }) => {
                add(a, b);
                tiles.add(more);
            }
            (Sum::Chains(a), Sum::Chains(b)) => add(a, b),
            (a, b) => debug_assert!(false, "{a:?} and {b:?} in one picture"),
        }
    }

    /// Mean over `pixels` pixels.
    pub(crate) fn estimate(&self, pixels: f64, replicates: &Replicates) -> Estimate {
        let own = replicates.dof();
        let of = |value: f64, variance: f64, dof: f64| Estimate {
            value: value / pixels,
            standard_error: variance.sqrt() / pixels,
            dof,
        };
        match self {
            // Satterthwaite's degrees of freedom: if a single firefly dominates a tile's error, they are those of one
            // pixel.
            Sum::Pixels(parts) if parts.squares > 0.0 => {
                of(parts.value, parts.variance, own * parts.variance * parts.variance / parts.squares)
            }
            Sum::Pixels(parts) => of(parts.value, parts.variance, own),
            Sum::Splats { by_replicate, .. } | Sum::Chains(by_replicate) => {
                of(replicates.mean(by_replicate), replicates.variance(by_replicate), own)
            }
        }
    }

    /// Third cumulant of this mean.
    pub(crate) fn third(&self, pixels: f64, replicates: &Replicates) -> f64 {
        let third = match self {
            Sum::Pixels(parts) => parts.third,
            Sum::Splats { by_replicate, tiles } => {
                // Few replicates determine a third cumulant poorly, many smallest tiles together well. If k tiles
                // receive the same light of a subpath, the variance of their sum is k times the sum of their variances,
                // and the third cumulant is k² times the sum of theirs.
                let ties = if tiles.variance > 0.0 { replicates.variance(by_replicate) / tiles.variance } else { 1.0 };
                tiles.third * ties.max(1.0).powi(2)
            }
            Sum::Chains(by_replicate) => replicates.third(by_replicate),
        };
        third / pixels.powi(3)
    }

    /// Scales every mean by `factor`, to simulate a biased renderer.
    #[cfg(test)]
    pub(crate) fn scale(&mut self, factor: f64) {
        let scale = |parts: &mut Parts| {
            parts.value *= factor;
            parts.variance *= factor * factor;
            parts.squares *= factor.powi(4);
            parts.third *= factor.powi(3);
        };
        match self {
            Sum::Pixels(parts) => scale(parts),
            Sum::Splats { by_replicate, tiles } => {
                by_replicate.iter_mut().for_each(|s| *s *= factor);
                scale(tiles);
            }
            Sum::Chains(by_replicate) => by_replicate.iter_mut().for_each(|s| *s *= factor),
        }
    }
}

fn part(means: &[f64], replicates: &Replicates) -> Parts {
    Parts::one(replicates.mean(means), replicates.variance(means), replicates.third(means))
}

fn add(sums: &mut [f64], more: &[f64]) {
    sums.iter_mut().zip(more).for_each(|(sum, m)| *sum += m);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::{Moments, third_cumulant_of_mean};

    /// Rounding of a few operations on values of about 1.
    const ROUNDING: f64 = 64.0 * f64::EPSILON;

    #[test]
    fn replicates_of_equal_length_give_the_usual_moments() {
        let (values, replicates) = ([0.25, 1.0, 2.0, 0.5], Replicates::of(&[3; 4]).unwrap());
        let usual = values.iter().copied().collect::<Moments>().estimate().unwrap();
        assert!((replicates.mean(&values) - usual.value).abs() < ROUNDING);
        assert!((replicates.variance(&values).sqrt() - usual.standard_error).abs() < ROUNDING);
        assert!((replicates.third(&values) - third_cumulant_of_mean(&values, usual.value)).abs() < ROUNDING);
        assert_eq!(Replicates::of(&[4, 4]), None);
        assert_eq!(Replicates::of(&[4, 0, 4, 4]), None);
    }

    /// Two pixels that always have the same value. If they share chains, the standard error of their sum is twice that
    /// of one; if they were independent, √2 times.
    #[test]
    fn pixel_correlation_decides_the_tile_error() {
        let (means, replicates) = ([1.0, 3.0, 2.0, 2.0], Replicates::of(&[1; 4]).unwrap());
        let of = |independent| {
            let mut sum = Sum::new(independent, &replicates);
            sum.add_pixel(&means, &replicates);
            sum.add_pixel(&means, &replicates);
            sum.finish(&replicates);
            sum.estimate(2.0, &replicates)
        };
        let one = replicates.variance(&means).sqrt();
        for (independent, error, dof) in [
            (Independent::Pixels, one / 2.0_f64.sqrt(), 6.0),
            (Independent::Blocks, one, 3.0),
            (Independent::Replicates, one, 3.0),
        ] {
            let estimate = of(independent);
            assert!((estimate.value - 2.0).abs() < ROUNDING && (estimate.dof - dof).abs() < ROUNDING, "{estimate:?}");
            assert!((estimate.standard_error - error).abs() < ROUNDING, "{independent:?}: {estimate:?}");
        }
    }
}
