//! Tail estimation: the shape k of a generalised Pareto distribution fitted to the largest values [Zhang09], as in
//! Pareto-smoothed importance sampling [Vehtari24]. Moments of order 1/k and above do not exist. For k > 1/2 the
//! variance is infinite and a standard error is of little use. In practice intervals hold up to [`UNTRUSTED_SHAPE`].
//!
//! Values are contributions of independent samples, positive and in the units of the estimate. The fit cannot detect
//! modes that were never sampled.

/// From this shape on the mean and standard error of a sample converge too slowly for a reliable interval [Vehtari24].
pub const UNTRUSTED_SHAPE: f64 = 0.7;

/// Least number of exceedances for a fit.
const LEAST_EXCEEDANCES: usize = 5;
/// Factor of the prior scale in the grid of the fit [Zhang09].
const PRIOR_SCALE: f64 = 3.0;
/// Weak prior on k: its weight, in exceedances …
const PRIOR_WEIGHT: f64 = 10.0;
/// … and its value [Vehtari24].
const PRIOR_SHAPE: f64 = 0.5;

/// The 95 % quantile of the normal distribution.
const NORMAL_95: f64 = 1.644_853_6;

/// A fitted tail.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Tail {
    /// Shape k, regularised towards ½ with the weight of ten exceedances. Its standard error is about (1 + k) /
    /// √exceedances.
    pub shape: f64,
    /// Number of values above the threshold.
    pub exceedances: usize,
    /// Lower end of the tail.
    pub threshold: f64,
}

impl Tail {
    /// Returns the upper end of the one-sided 95 % interval of the shape; the prior counts as ten exceedances.
    pub fn upper_shape(&self) -> f64 {
        self.shape + NORMAL_95 * (1.0 + self.shape.max(0.0)) / (self.exceedances as f64 + PRIOR_WEIGHT).sqrt()
    }
}

/// Returns the number of tail values among `n`: min(n/5, 3√n), rounded up [Vehtari24].
pub fn tail_size(n: usize) -> usize {
    (0.2 * n as f64).min(3.0 * (n as f64).sqrt()).ceil() as usize
}

/// Fits the tail of all `values`, which are reordered. `None` if one is not finite or too few exceed the threshold
/// (fewer than 25 values, or nearly all of them equal).
pub fn tail_shape(values: &mut [f64]) -> Option<Tail> {
    let size = tail_size(values.len());
    if size >= values.len() || values.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let below = values.len() - size - 1;
    values.select_nth_unstable_by(below, f64::total_cmp);
    tail_of_largest(&mut values[below..])
}

/// Fits the tail above the smallest of `largest`, which are the [`tail_size`] + 1 largest of all values in any order;
/// they are reordered. `None` if one is not finite or too few exceed the threshold.
pub fn tail_of_largest(largest: &mut [f64]) -> Option<Tail> {
    if largest.iter().any(|v| !v.is_finite()) {
        return None;
    }
    largest.sort_unstable_by(f64::total_cmp);
    let threshold = *largest.first()?;
    let exceedances: Vec<f64> = largest.iter().map(|v| v - threshold).filter(|&x| x > 0.0).collect();
    if exceedances.len() < LEAST_EXCEEDANCES {
        return None;
    }
    let n = exceedances.len() as f64;
    let shape = (fit(&exceedances) * n + PRIOR_SHAPE * PRIOR_WEIGHT) / (n + PRIOR_WEIGHT);
    shape.is_finite().then_some(Tail { shape, exceedances: exceedances.len(), threshold })
}

/// Fits the shape of the generalised Pareto distribution of `x`, positive and ascending. The posterior mean of θ = −k/σ
/// is taken over a grid of prior quantiles, weighted by the profile likelihood [Zhang09].
fn fit(x: &[f64]) -> f64 {
    let n = x.len() as f64;
    let (largest, quartile) = (x[x.len() - 1], x[(0.25 * n + 0.5) as usize - 1]);
    // Normalised by the largest value, to avoid overflow.
    let relative: Vec<f64> = x.iter().map(|x| x / largest).collect();
    let points = 30.0 + n.sqrt().floor();
    let grid = (1..=points as usize)
        .map(|j| 1.0 + (1.0 - (points / (j as f64 - 0.5)).sqrt()) / (PRIOR_SCALE * quartile / largest));
    let candidates: Vec<[f64; 2]> = grid.map(|theta| [theta, n * log_likelihood(theta, &relative)]).collect();
    let most = candidates.iter().map(|c| c[1]).fold(f64::NEG_INFINITY, f64::max);
    let weighted = candidates.iter().map(|[theta, l]| [theta * (l - most).exp(), (l - most).exp()]);
    let [sum, weights] = weighted.fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
    shape_at(sum / weights, &relative)
}

/// Returns the maximum-likelihood shape given θ: mean ln(1 − θ x).
fn shape_at(theta: f64, x: &[f64]) -> f64 {
    x.iter().map(|x| (-theta * x).ln_1p()).sum::<f64>() / x.len() as f64
}

/// Returns the profile log-likelihood of θ per value [Zhang09]; at θ = 0 its limit, that of the exponential
/// distribution.
fn log_likelihood(theta: f64, x: &[f64]) -> f64 {
    let k = shape_at(theta, x);
    let rate = if k.abs() > 0.0 { -theta / k } else { x.len() as f64 / x.iter().sum::<f64>() };
    rate.ln() - k - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::test_random::Random;

    /// n values of the generalised Pareto distribution of shape k and scale 2 above 3, and the threshold itself.
    fn largest(k: f64, n: usize, seed: u64) -> Vec<f64> {
        let mut random = Random::new(seed);
        let mut x = || {
            let e = random.exponential();
            if k.abs() > 0.0 { (k * e).exp_m1() / k } else { e }
        };
        let mut values: Vec<f64> = (0..n).map(|_| 3.0 + 2.0 * x()).collect();
        values.push(3.0);
        values
    }

    /// The estimate without the regularisation towards ½.
    fn unshrunk(tail: &Tail) -> f64 {
        let n = tail.exceedances as f64;
        (tail.shape * (n + 10.0) - 5.0) / n
    }

    /// The standard error of an efficient estimate is (1 + k)/√n for k > −½; two-sided at level 1e-6 (4.9 σ). The bias
    /// is of order 1/n, a hundredth of that.
    #[test]
    fn pareto_shape_is_recovered() {
        for (seed, k) in [-0.3, -0.1, 0.0, 0.2, 0.5, 0.7, 1.0].into_iter().enumerate() {
            let n = 20_000;
            let tail = tail_of_largest(&mut largest(k, n, 50 + seed as u64)).unwrap();
            let slack = 4.9 * (1.0 + k) / f64::from(n as u32).sqrt();
            assert!((unshrunk(&tail) - k).abs() < slack, "{k}: {tail:?}");
            assert_eq!((tail.exceedances, tail.threshold), (n, 3.0));
        }
    }

    /// Uniform values have k = −1, where estimates converge as 1/n; the grid of the fit is as coarse as a few 1/√n.
    #[test]
    fn bounded_values_have_a_negative_shape() {
        let mut random = Random::new(60);
        let mut values: Vec<f64> = (0..100_000).map(|_| random.uniform()).collect();
        let tail = tail_shape(&mut values).unwrap();
        assert!((unshrunk(&tail) + 1.0).abs() < 5.0 / (tail.exceedances as f64).sqrt(), "{tail:?}");
        assert!(tail.shape <= UNTRUSTED_SHAPE);
    }

    /// u^(−k) has exactly a generalised Pareto tail of shape k above every threshold: two-sided at level 1e-6 (4.9 σ),
    /// and k = 1.5 is beyond [`UNTRUSTED_SHAPE`] by 7 σ.
    #[test]
    fn tail_of_all_values_is_fitted() {
        let mut random = Random::new(61);
        let u: Vec<f64> = (0..40_000).map(|_| 1.0 - random.uniform()).collect();
        for (k, trusted) in [(0.3, true), (1.5, false)] {
            let mut values: Vec<f64> = u.iter().map(|u| u.powf(-k)).collect();
            let tail = tail_shape(&mut values).unwrap();
            assert_eq!(tail.exceedances, 600);
            assert!((unshrunk(&tail) - k).abs() < 4.9 * (1.0 + k) / 600_f64.sqrt(), "{k}: {tail:?}");
            assert_eq!(tail.shape <= UNTRUSTED_SHAPE, trusted);
        }
    }

    /// The fit of ArviZ 0.19 to quantiles of a power and of an exponential distribution, to rounding.
    #[test]
    fn agrees_with_arviz() {
        let quantiles = |f: fn(f64) -> f64| (0..1000).map(move |i| f((f64::from(i) + 0.5) / 1000.0));
        for (mut values, shape) in [
            (quantiles(|u| u.powf(-0.6)).collect::<Vec<_>>(), 0.583_865_196_125),
            (quantiles(|u| -u.ln()).collect(), 0.063_030_079_873),
        ] {
            let tail = tail_shape(&mut values).unwrap();
            assert!((tail.shape - shape).abs() < 1e-9, "{tail:?}");
            assert_eq!(tail.exceedances, 95);
        }
    }

    /// A change of unit affects only the threshold, up to some n rounding errors of sums of logarithms.
    #[test]
    fn units_do_not_matter() {
        let mut values = largest(0.4, 500, 62);
        let shape = tail_of_largest(&mut values).unwrap().shape;
        for unit in [1e-200, 1e-3, 1e200] {
            let mut scaled: Vec<f64> = values.iter().rev().map(|v| v * unit).collect();
            assert!((tail_of_largest(&mut scaled).unwrap().shape - shape).abs() < 1e-9, "{unit}");
        }
    }

    #[test]
    fn unfittable_samples_give_no_tail() {
        assert_eq!(tail_shape(&mut []), None);
        assert_eq!(tail_shape(&mut [1.0; 1000]), None);
        let mut few: Vec<f64> = (0..20).map(f64::from).collect();
        assert_eq!(tail_shape(&mut few), None);
        let mut values: Vec<f64> = (0..100).map(f64::from).collect();
        assert!(tail_shape(&mut values).is_some());
        values[7] = f64::NAN;
        assert_eq!(tail_shape(&mut values), None);
        // Half of the tail lies on the threshold: the rest is fitted.
        let mut tied = vec![1.0; 1000];
        tied.iter_mut().take(40).enumerate().for_each(|(i, v)| *v = 2.0 + i as f64);
        assert_eq!(tail_shape(&mut tied).unwrap().exceedances, 40);
    }
}
