//! Pearson's χ² test of a sampler against its density. Cells whose expected count is below 5 are pooled, and p-values
//! are compared with a family-wise level by Šidák's correction.

use crate::levels::sidak_level;
use crate::quadrature::Rectangle;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::f64::consts::{PI, TAU};

/// Probability that any test of a family fails although all samplers are right.
pub const FAMILY_LEVEL: f64 = 0.01;
/// Expected count below which a cell is pooled.
const POOL: f64 = 5.0;

/// The level of one test out of a family of `tests`.
pub fn sidak(tests: usize) -> f64 {
    sidak_level(FAMILY_LEVEL, tests as u64)
}

/// The p-value of `observed` counts under `expected` ones. Samples where hardly any are expected land in the pools;
/// that none has a density of zero is for the caller to see, since quadrature may miss the corner of a cell.
pub fn p_value(observed: &[f64], expected: &[f64]) -> f64 {
    let mut cells: Vec<(f64, f64)> = observed.iter().copied().zip(expected.iter().copied()).collect();
    cells.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (mut statistic, mut degrees, mut pooled) = (0.0, -1.0, (0.0, 0.0));
    for (count, mean) in cells {
        pooled = (pooled.0 + count, pooled.1 + mean);
        if pooled.1 >= POOL {
            statistic += (pooled.0 - pooled.1).powi(2) / pooled.1;
            degrees += 1.0;
            pooled = (0.0, 0.0);
        }
    }
    survival(statistic, degrees)
}

/// Probability that χ² with so many `degrees` of freedom exceeds `statistic`; one without any degree.
pub fn survival(statistic: f64, degrees: f64) -> f64 {
    if degrees < 1.0 { 1.0 } else { ChiSquared::new(degrees).expect("degrees of freedom").sf(statistic) }
}

/// The sphere in cells around an axis. With S = sin²(angle / 2), whose 2 dS dφ is solid angle, the radial coordinate x
/// is S = k ((1 + 1/k)ˣ − 1): even in S for large k, in its logarithm from k on for small k. A lobe of half width √k
/// and a diffuse base below it are both resolved.
pub struct SphereCells {
    axis: [[f64; 3]; 3],
    k: f64,
    radial: usize,
    around: usize,
}

impl SphereCells {
    /// Cells around the unit vector `axis` for lobes of half angle about 2 √`k` and more.
    pub fn new(axis: [f64; 3], k: f64) -> Self {
        SphereCells { axis: frame(axis), k, radial: 40, around: 32 }
    }

    /// How many cells there are.
    pub fn count(&self) -> usize {
        self.radial * self.around
    }

    /// The cell of a direction.
    pub fn index(&self, w: [f64; 3]) -> usize {
        let length = dot(w, w).sqrt();
        let [s, t, n] = self.axis;
        let away: f64 = (0..3).map(|i| (w[i] / length - n[i]).powi(2)).sum::<f64>() / 4.0;
        let x = (away / self.k).ln_1p() / self.k.recip().ln_1p();
        let phi = (dot(w, t).atan2(dot(w, s)) + PI) / TAU;
        let cell = |v: f64, n: usize| ((v * n as f64) as usize).min(n - 1);
        cell(x, self.radial) * self.around + cell(phi, self.around)
    }

    /// ∫ of the density `pdf` per solid angle over each cell, each within `tolerance`.
    pub fn integrate(&self, tolerance: f64, pdf: &impl Fn([f64; 3]) -> f64) -> Vec<f64> {
        let integrand = |x: f64, turn: f64| {
            let range = self.k.recip().ln_1p();
            let away = self.k * (x * range).exp_m1();
            2.0 * (self.k + away) * range * TAU * pdf(self.direction(away, turn))
        };
        let edge = |i: usize, n: usize| [i as f64 / n as f64, (i + 1) as f64 / n as f64];
        let cell =
            |i: usize| Rectangle { x: edge(i / self.around, self.radial), y: edge(i % self.around, self.around) };
        (0..self.count()).map(|i| cell(i).integrate(tolerance, &integrand)).collect()
    }

    fn direction(&self, away: f64, turn: f64) -> [f64; 3] {
        let (sin, cos) = (TAU * turn - PI).sin_cos();
        let sine = 2.0 * (away * (1.0 - away)).max(0.0).sqrt(); // rounding may take S beyond 1
        let [s, t, n] = self.axis;
        std::array::from_fn(|i| sine * (cos * s[i] + sin * t[i]) + (1.0 - 2.0 * away) * n[i])
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn frame(n: [f64; 3]) -> [[f64; 3]; 3] {
    let other = if n[0].abs() < 0.5 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let s = cross(n, other);
    let s = s.map(|x| x / dot(s, s).sqrt());
    [s, cross(n, s), n]
}

#[test]
fn the_right_density_passes_and_one_wrong_by_two_percent_fails() {
    let mut random = crate::random::Random::new(7);
    let mut observed = vec![0.0; 100];
    for _ in 0..1_000_000 {
        observed[(random.f64() * 100.0) as usize] += 1.0;
    }
    let right = vec![1e4; 100];
    let wrong: Vec<f64> = (0..100).map(|i| if i % 2 == 0 { 1.02e4 } else { 0.98e4 }).collect();
    assert!(p_value(&observed, &right) > sidak(1));
    assert!(p_value(&observed, &wrong) < sidak(1));
}
