//! Pixel filters, applied by filter importance sampling [Ernst06]: film positions are drawn from the filter, so that
//! every sample has weight 1 and belongs to one pixel. This requires nonnegative filters.

use etendue_lanes::{Float, Int};
use statrs::function::erf::erf;
use std::f64::consts::{PI, SQRT_2};
use std::sync::Arc;

/// A separable reconstruction filter. Radii are in pixels.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    Default,
    serde::Serialize,
    serde::Deserialize,
    strum::VariantArray,
    strum::IntoStaticStr,
    strum::EnumMessage,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Filter {
    /// Constant over the pixel: radius 0.5.
    Box,
    /// Linear fall-off: radius 1.
    Tent,
    /// σ 0.5, truncated at radius 1.5 and shifted to zero there [PBRT4 §8.8.3].
    Gaussian,
    /// 4-term Blackman–Harris window, −92 dB [Harris78 table 1], radius 1.5: close to a Gaussian of σ 0.43, but zero at
    /// the radius.
    #[default]
    BlackmanHarris,
}

/// Terms of the Blackman–Harris window, cos(k π x / r).
const BLACKMAN_HARRIS: [f64; 4] = [0.35875, 0.48829, 0.14128, 0.01168];
const GAUSSIAN_SIGMA: f64 = 0.5;
/// Intervals of the inverse CDF table over half the filter. Linear interpolation has a CDF error below 1e-6 (measured
/// in the tests).
const INTERVALS: usize = 1024;

impl Filter {
    /// Returns the radius of the filter in pixels.
    pub fn radius(self) -> f64 {
        match self {
            Filter::Box => 0.5,
            Filter::Tent => 1.0,
            Filter::Gaussian | Filter::BlackmanHarris => 1.5,
        }
    }

    /// Returns the CDF of the one-dimensional filter between the centre and `x` ≥ 0, normalised over that half: 0 at 0,
    /// 1 from the radius on.
    pub fn half_cdf(self, x: f64) -> f64 {
        let x = x.min(self.radius());
        match self {
            Filter::Box => 2.0 * x,
            Filter::Tent => x * (2.0 - x),
            Filter::Gaussian => gaussian_integral(x) / gaussian_integral(self.radius()),
            Filter::BlackmanHarris => {
                let term = |k: usize| BLACKMAN_HARRIS[k] * (k as f64 * PI * x / self.radius()).sin() / (k as f64 * PI);
                x / self.radius() + (term(1) + term(2) + term(3)) / BLACKMAN_HARRIS[0]
            }
        }
    }
}

impl Filter {
    /// Returns the normalised one-dimensional filter at the offset `x` from the centre.
    #[inline]
    pub fn density(self, x: f32) -> f32 {
        let r = self.radius() as f32;
        match self {
            // Half-open, so that every point belongs to one pixel.
            Filter::Box => f32::from(u8::from((-0.5..0.5).contains(&x))),
            _ if x.abs() >= r => 0.0,
            Filter::Tent => 1.0 - x.abs(),
            Filter::Gaussian => ((-2.0 * x * x).exp() - GAUSSIAN_EDGE) * GAUSSIAN_SCALE,
            Filter::BlackmanHarris => {
                // The window as a polynomial in the cosine, by multiple-angle formulae.
                let [a0, a1, a2, a3] = BLACKMAN_HARRIS.map(|a| (a / BLACKMAN_HARRIS[0]) as f32);
                let c = (std::f32::consts::PI * x / r).cos();
                let window = a0 - a2 + (a1 - 3.0 * a3) * c + 2.0 * a2 * c * c + 4.0 * a3 * c * c * c;
                window.max(0.0) / (2.0 * r)
            }
        }
    }
}

/// exp(−r²/2σ²), the shift of the Gaussian, and 1 over its integral: see the tests.
const GAUSSIAN_EDGE: f32 = 0.011_108_997;
const GAUSSIAN_SCALE: f32 = 0.821_960_5;

/// ∫₀ˣ exp(−t²/2σ²) − exp(−r²/2σ²) dt.
fn gaussian_integral(x: f64) -> f64 {
    let scale = GAUSSIAN_SIGMA * SQRT_2;
    let edge = (-(Filter::Gaussian.radius() / scale).powi(2)).exp();
    0.5 * PI.sqrt() * scale * erf(x / scale) - edge * x
}

/// Samples offsets from the pixel centre with the filter as density. Clones share the table.
#[derive(Debug, Clone)]
pub struct FilterSampler {
    shape: Shape,
}

#[derive(Debug, Clone)]
enum Shape {
    Box,
    Tent,
    /// Offsets from the radius down to 0, at equal steps of √(1 − half CDF). In this variable they are almost linear
    /// near the radius.
    Table(Arc<[f32]>),
}

impl FilterSampler {
    /// Returns the sampler of a filter.
    pub fn new(filter: Filter) -> Self {
        let shape = match filter {
            Filter::Box => Shape::Box,
            Filter::Tent => Shape::Tent,
            Filter::Gaussian | Filter::BlackmanHarris => Shape::Table(inverse_table(filter)),
        };
        FilterSampler { shape }
    }

    /// Returns the offset for `u` in [0, 1)²; monotone in each dimension.
    #[inline]
    pub fn sample<F: Float>(&self, [u, v]: [F; 2]) -> [F; 2] {
        let one = F::splat(1.0);
        match &self.shape {
            Shape::Box => [u - F::splat(0.5), v - F::splat(0.5)],
            Shape::Tent => {
                let half = |v: F| one - (one - v).sqrt();
                [mirrored(u, half), mirrored(v, half)]
            }
            Shape::Table(table) => [mirrored(u, |v| interpolate(table, v)), mirrored(v, |v| interpolate(table, v))],
        }
    }
}

/// Applies the inverse half CDF on both sides of the centre.
#[inline(always)]
fn mirrored<F: Float>(u: F, half: impl Fn(F) -> F) -> F {
    let v = F::splat(2.0) * u - F::splat(1.0);
    half(v.abs()).copysign(v)
}

#[inline(always)]
fn interpolate<F: Float>(table: &[f32], v: F) -> F {
    let at = (F::splat(1.0) - v).sqrt() * F::splat(INTERVALS as f32);
    let i = at.min(F::splat((INTERVALS - 1) as f32)).to_int();
    let low = F::from_fn(|lane| table[i.lane(lane) as usize]);
    let high = F::from_fn(|lane| table[i.lane(lane) as usize + 1]);
    low + (at - F::from_int(i)) * (high - low)
}

/// Tabulates the inverse by bisection to f64 precision.
fn inverse_table(filter: Filter) -> Arc<[f32]> {
    let invert = |target: f64| {
        let (mut low, mut high) = (0.0, filter.radius());
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if filter.half_cdf(middle) < target { low = middle } else { high = middle }
        }
        high
    };
    let inner = (1..INTERVALS).map(|k| invert(1.0 - (k as f64 / INTERVALS as f64).powi(2)) as f32);
    std::iter::once(filter.radius() as f32).chain(inner).chain(std::iter::once(0.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::test_random::Random;
    use etendue_testing::chi_square::p_value;

    const ALL: [Filter; 4] = [Filter::Box, Filter::Tent, Filter::Gaussian, Filter::BlackmanHarris];

    /// The filter itself, written from its definition.
    fn profile(filter: Filter, x: f64) -> f64 {
        let r = filter.radius();
        match filter {
            Filter::Box => 1.0,
            Filter::Tent => 1.0 - x.abs(),
            Filter::Gaussian => (-2.0 * x * x).exp() - (-2.0 * r * r).exp(),
            Filter::BlackmanHarris => {
                let c = |k: f64| (k * PI * x / r).cos();
                0.35875 + 0.48829 * c(1.0) + 0.14128 * c(2.0) + 0.01168 * c(3.0)
            }
        }
    }

    /// The CDF against the midpoint rule on the profile, whose error is below h² max|f″| / 24 < 1e-7 here.
    #[test]
    fn cdf_is_the_integral_of_the_profile() {
        for filter in ALL {
            let n = 10_000;
            let h = filter.radius() / f64::from(n);
            let mut sums = vec![0.0];
            (0..n).for_each(|i| sums.push(sums[i as usize] + profile(filter, (f64::from(i) + 0.5) * h)));
            for i in 0..=n {
                let x = h * f64::from(i);
                let error = filter.half_cdf(x) - sums[i as usize] / sums[n as usize];
                assert!(error.abs() < 1e-7, "{filter:?} at {x}: {error}");
            }
        }
    }

    /// The density is the profile over its integral, by the midpoint rule whose error is below 1e-7: 16 roundings of
    /// f32.
    #[test]
    fn density_is_the_profile_over_its_integral() {
        for filter in ALL {
            let n = 10_000;
            let h = filter.radius() / f64::from(n);
            let integral = 2.0 * h * (0..n).map(|i| profile(filter, (f64::from(i) + 0.5) * h)).sum::<f64>();
            for i in -2000..2000 {
                let x = f64::from(i) * 1e-3;
                let inside = if filter == Filter::Box { (-0.5..0.5).contains(&x) } else { x.abs() < filter.radius() };
                let want = if inside { profile(filter, x) / integral } else { 0.0 };
                let found = f64::from(filter.density(x as f32));
                assert!((found - want).abs() < 16.0 * f64::from(f32::EPSILON), "{filter:?} at {x}: {found} {want}");
            }
        }
    }

    /// sup |F(x(u)) − u|: f32 rounding (4 ε) for the exact inverses; 1e-6 for the tables, the bound
    /// that is stated at their size.
    #[test]
    fn inverse_is_accurate_and_monotone() {
        for filter in ALL {
            let sampler = FilterSampler::new(filter);
            let (mut worst, mut last) = (0.0_f64, f32::NEG_INFINITY);
            for i in 0..1_000_000 {
                let u = i as f32 / 1e6;
                let x: f32 = sampler.sample([u, 0.5])[0];
                assert!(x >= last && f64::from(x.abs()) <= filter.radius());
                last = x;
                let cdf = 0.5 + 0.5 * filter.half_cdf(f64::from(x.abs())).copysign(f64::from(x));
                worst = worst.max((cdf - f64::from(u)).abs());
            }
            let bound = if matches!(filter, Filter::Box | Filter::Tent) { 4.0 * f64::from(f32::EPSILON) } else { 1e-6 };
            println!("{filter:?}: {worst:.2e}");
            assert!(worst < bound, "{filter:?}: {worst}");
        }
    }

    /// χ² on 64 × 64 bins of 10⁶ samples, level 1e-6.
    #[test]
    fn samples_follow_the_filter() {
        for (i, filter) in ALL.into_iter().enumerate() {
            let (sampler, mut random) = (FilterSampler::new(filter), Random::new(i as u64));
            let (samples, bins, r) = (1_000_000, 64, filter.radius());
            let bin = |x: f32| (((f64::from(x) / r + 1.0) * 0.5 * bins as f64) as usize).min(bins - 1);
            let mut counts = vec![0.0; bins * bins];
            for _ in 0..samples {
                let [x, y] = sampler.sample([random.uniform() as f32, random.uniform() as f32]);
                counts[bin(y) * bins + bin(x)] += 1.0;
            }
            let edge = |k: usize| r * (2.0 * k as f64 / bins as f64 - 1.0);
            let cdf = |x: f64| 0.5 + 0.5 * filter.half_cdf(x.abs()).copysign(x);
            let p: Vec<f64> = (0..bins).map(|k| cdf(edge(k + 1)) - cdf(edge(k))).collect();
            let expected: Vec<f64> = (0..bins * bins).map(|k| f64::from(samples) * p[k / bins] * p[k % bins]).collect();
            let p = p_value(&counts, &expected);
            assert!(p > 1e-6, "{filter:?}: {p}");
        }
    }
}
