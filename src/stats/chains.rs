//! Statistics of correlated series, such as Markov chains: batch means, effective sample size, split-R̂.
//!
//! Chains must have equal length, be in order, and have at least [`SHORTEST`] values. All three statistics require a
//! finite variance; take logarithms of radiance with rare fireflies. They are diagnostics of mixing. The reported error
//! of an image comes from replicates instead.

use super::{Estimate, Moments};

/// Least length of a chain: two halves of four values.
pub const SHORTEST: usize = 8;

/// Returns the mean of a series and its standard error from the means of `batches` equal batches, with batches − 1
/// degrees of freedom. The remainder at the beginning, less than a batch, is dropped. Batches must be long compared to
/// the correlation time; √n batches are usual. `None` below two batches of one value each [Flegal10].
pub fn batch_means(series: &[f64], batches: usize) -> Option<Estimate> {
    let length = series.len().checked_div(batches).filter(|&length| length > 0)?;
    let used = &series[series.len() - length * batches..];
    let means: Moments = used.chunks_exact(length).map(mean).collect();
    means.estimate()
}

/// Returns the effective sample size: the number of independent values whose mean has the same error as that of all
/// `chains` [Vehtari21]. Each chain is split in two, so that poorly mixed chains reduce the result. Autocorrelations
/// are summed over Geyer's initial monotone sequence [Geyer92 §3.3]. The result exceeds the number of values if
/// neighbours are anticorrelated; it is at most n log₁₀ n. `None` if chains are too short, of different lengths, not
/// finite, or constant.
pub fn effective_sample_size(chains: &[&[f64]]) -> Option<f64> {
    let halves = split(chains)?;
    let spread = Spread::of(&halves)?;
    let correlation = |lag: usize| {
        let covariance = halves.iter().zip(&spread.means).map(|(h, &m)| autocovariance(h, m, lag)).sum::<f64>();
        1.0 - (spread.within - covariance / halves.len() as f64) / spread.total
    };
    let total = (spread.length * halves.len()) as f64;
    Some(total / integrated_time(correlation, spread.length).max(1.0 / total.log10()))
}

/// Returns the potential scale reduction factor, from the differences between the halves of all chains. It is 1 for
/// identical distributions, and below 1.01 for chains that have mixed [Gelman13 §11.4; Vehtari21]. `None` as for
/// [`effective_sample_size`].
pub fn split_r_hat(chains: &[&[f64]]) -> Option<f64> {
    let spread = Spread::of(&split(chains)?)?;
    Some((spread.total / spread.within).sqrt())
}

/// Splits every chain into halves; the middle value of an odd length is dropped.
fn split<'a>(chains: &[&'a [f64]]) -> Option<Vec<&'a [f64]>> {
    let length = chains.first()?.len();
    let is_usable = |chain: &&[f64]| chain.len() == length && chain.iter().all(|x| x.is_finite());
    if length < SHORTEST || !chains.iter().all(is_usable) {
        return None;
    }
    Some(chains.iter().flat_map(|chain| [&chain[..length / 2], &chain[length - length / 2..]]).collect())
}

/// Variance within and between chains.
struct Spread {
    length: usize,
    means: Vec<f64>,
    /// Mean of the chains' variances, W.
    within: f64,
    /// Estimate of the variance of the whole distribution, (n − 1)/n W + variance of the chains' means.
    total: f64,
}

impl Spread {
    fn of(chains: &[&[f64]]) -> Option<Spread> {
        let moments: Vec<Moments> = chains.iter().map(|chain| chain.iter().copied().collect()).collect();
        let means: Vec<f64> = moments.iter().map(Moments::mean).collect();
        let variances: Moments = moments.iter().filter_map(Moments::variance).collect();
        let (within, length) = (variances.mean(), chains.first()?.len());
        let between = means.iter().copied().collect::<Moments>().variance()?;
        let n = length as f64;
        (within > 0.0).then_some(Spread { length, means, within, total: (n - 1.0) / n * within + between })
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Autocovariance of a chain at `lag`, normalised by n.
fn autocovariance(chain: &[f64], mean: f64, lag: usize) -> f64 {
    chain.iter().zip(&chain[lag..]).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>() / chain.len() as f64
}

/// Returns 1 + 2 Σ ρ(t). Sums of two neighbouring correlations are positive and decreasing for reversible chains. They
/// are included while positive, and capped by their predecessor [Geyer92 §3.3]. The correlation after them counts once
/// if it is positive [Vehtari21].
fn integrated_time(correlation: impl Fn(usize) -> f64, length: usize) -> f64 {
    let mut pair = [1.0, correlation(1)];
    let (mut sum, mut least, mut lag) = (0.0, f64::INFINITY, 2);
    while pair[0] + pair[1] > 0.0 && lag + 2 < length {
        least = (pair[0] + pair[1]).min(least);
        sum += least;
        pair = [correlation(lag), correlation(lag + 1)];
        lag += 2;
    }
    2.0 * sum - 1.0 + pair[0].max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::test_random::Random;

    /// x' = ρ x + √(1 − ρ²) ξ from its stationary distribution: mean 0, variance 1, correlation ρ^t.
    fn autoregressive(rho: f64, n: usize, random: &mut Random) -> Vec<f64> {
        let mut x = random.normal();
        let step = |_| {
            x = rho * x + (1.0 - rho * rho).sqrt() * random.normal();
            x
        };
        (0..n).map(step).collect()
    }

    fn slices(chains: &[Vec<f64>]) -> Vec<&[f64]> {
        chains.iter().map(Vec::as_slice).collect()
    }

    /// n (1 − ρ)/(1 + ρ). The relative standard deviation of a windowed estimate of τ is about √(2 (2w + 1)/n) with
    /// a window w of some 5 τ [Sokal97 (3.19)]; two-sided at level 1e-6 (4.9 σ).
    #[test]
    fn effective_size_of_an_autoregressive_chain() {
        let mut random = Random::new(70);
        for rho in [0.9, 0.5, 0.0, -0.5] {
            let chains: Vec<_> = (0..4).map(|_| autoregressive(rho, 10_000, &mut random)).collect();
            let (n, tau) = (40_000.0, (1.0 + rho) / (1.0 - rho));
            let window = 5.0 * f64::max(tau, 1.0);
            let slack = 4.9 * (2.0 * (2.0 * window + 1.0) / n).sqrt();
            let ess = effective_sample_size(&slices(&chains)).unwrap();
            assert!((ess * tau / n - 1.0).abs() < slack, "{rho}: {ess}, {}", n / tau);
        }
    }

    /// `ess(method="mean")` and `rhat(method="split")` of ArviZ 0.19 for three series of 501 moving sums of ((31 i² +
    /// 7919 i) mod 1009)/1009, i from 1000 c; then the second shifted by 0.2; then differences instead of sums, where
    /// the cap n log₁₀ n holds; then sums of 20, whose correlations are not monotone. To the rounding errors of sums of
    /// 1500 values.
    #[test]
    fn agrees_with_arviz() {
        let y = |i: u64| ((i * i * 31 + i * 7919) % 1009) as f64 / 1009.0;
        let series = |f: fn(f64, f64, f64) -> f64| {
            [0, 1000, 2000].map(|c| (c..c + 501).map(|i| f(y(i), y(i + 1), y(i + 2))).collect())
        };
        let figures = |chains: &[Vec<f64>; 3]| {
            (effective_sample_size(&slices(chains)).unwrap(), split_r_hat(&slices(chains)).unwrap())
        };
        let mut sums: [Vec<f64>; 3] = series(|a, b, c| a + b + c);
        let (ess, r_hat) = figures(&sums);
        assert!((ess - 520.045_179_852_7).abs() < 1e-6 && (r_hat - 1.001_403_304_28).abs() < 1e-9, "{ess} {r_hat}");
        sums[1].iter_mut().for_each(|x| *x += 0.2);
        let (ess, r_hat) = figures(&sums);
        assert!((ess - 456.817_070_290_6).abs() < 1e-6 && (r_hat - 1.026_519_977_79).abs() < 1e-9, "{ess} {r_hat}");
        let (ess, _) = figures(&series(|a, b, _| b - a));
        assert!((ess - 4_764.136_888_583_5).abs() < 1e-6, "{ess}");
        let sum_of_20 = |i: u64| (i..i + 20).map(y).sum();
        let (ess, _) = figures(&[0, 1000, 2000].map(|c| (c..c + 501).map(sum_of_20).collect()));
        assert!((ess - 78.489_427_134_86).abs() < 1e-6, "{ess}");
    }

    /// Of 1000 intervals from 32 batches 95 % hold the mean: binomial at level 1e-6 (4.9 σ). Batches of 64 values with
    /// τ = 3 underestimate the variance by about (τ² − 1)/(2 × 64 τ) = 2 %, which costs 0.25 % of coverage.
    #[test]
    fn batches_cover_where_single_values_do_not() {
        let mut random = Random::new(71);
        let trials = 1000;
        let [mut batched, mut single] = [0; 2];
        for _ in 0..trials {
            let chain = autoregressive(0.5, 2051, &mut random);
            let covers = |estimate: Estimate| {
                let [low, high] = estimate.interval95();
                u32::from(low < 0.0 && high > 0.0)
            };
            batched += covers(batch_means(&chain, 32).unwrap());
            single += covers(batch_means(&chain, chain.len()).unwrap());
        }
        let n = f64::from(trials);
        assert!((f64::from(batched) - 0.95 * n).abs() < 4.9 * (n * 0.95 * 0.05).sqrt() + 0.0025 * n, "{batched}");
        assert!(f64::from(single) < 0.85 * n, "{single}");
    }

    #[test]
    fn batches_of_known_values() {
        let estimate = batch_means(&[9.0, 1.0, 3.0, 2.0, 6.0], 2).unwrap();
        assert_eq!((estimate.value, estimate.dof), (3.0, 1.0));
        assert!((estimate.standard_error - 1.0).abs() < f64::EPSILON);
        for (series, batches) in [(&[1.0, 2.0][..], 0), (&[1.0, 2.0], 1), (&[1.0], 2), (&[], 2)] {
            assert_eq!(batch_means(series, batches), None);
        }
    }

    /// R̂ of mixed chains of n values is 1 + O(1/n); a chain shifted by half a standard deviation gives √(1 + between),
    /// where the 8 halves' means have variance 0.25 × 12/56.
    #[test]
    fn r_hat_flags_a_chain_that_is_elsewhere_or_drifts() {
        let mut random = Random::new(72);
        let mut chains: Vec<_> = (0..4).map(|_| autoregressive(0.3, 4000, &mut random)).collect();
        let mixed = split_r_hat(&slices(&chains)).unwrap();
        assert!((0.999..1.005).contains(&mixed), "{mixed}");
        let size = effective_sample_size(&slices(&chains)).unwrap();
        chains[2].iter_mut().for_each(|x| *x += 0.5);
        let shifted = split_r_hat(&slices(&chains)).unwrap();
        assert!((shifted - (1.0 + 0.25 * 12.0 / 56.0_f64).sqrt()).abs() < 0.01, "{shifted}");
        assert!(effective_sample_size(&slices(&chains)).unwrap() < 0.05 * size);
        let drift: Vec<f64> = (0..4000).map(|i| random.normal() + f64::from(i) / 2000.0).collect();
        assert!(split_r_hat(&[&drift]).unwrap() > 1.1);
    }

    #[test]
    fn what_cannot_be_judged_is_not() {
        let fine = [0.0, 1.0, 0.5, 2.0, 1.5, 0.0, 1.0, 3.0];
        assert!(effective_sample_size(&[&fine]).is_some() && split_r_hat(&[&fine, &fine]).is_some());
        let mut odd = fine;
        odd[3] = f64::NAN;
        let cases: [&[&[f64]]; 5] = [&[], &[&fine[1..]], &[&fine, &[0.0; 9]], &[&odd], &[&[2.0; 8]]];
        for chains in cases {
            assert!(effective_sample_size(chains).is_none() && split_r_hat(chains).is_none(), "{chains:?}");
        }
    }
}
