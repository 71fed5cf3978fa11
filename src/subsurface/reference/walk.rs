//! The random walk.

use super::super::fresnel::{external_reflectance, internal_reflectance};
use super::bins::Bins;
use super::split_mix;
use crate::stats::{Estimate, Moments};
use glam::DVec3;
use std::f64::consts::TAU;

/// Directions of the light that enters at the origin, inside the medium.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Incidence {
    /// Straight down.
    Normal,
    /// Those of diffuse light outside that has passed the boundary.
    Diffuse,
}

/// A random walk in the half-space z > 0, or a slab, of extinction 1.
#[derive(Debug, Clone)]
pub struct Walk {
    /// Single-scattering albedos in [0, 1]. The same paths serve all of them, so their errors are correlated.
    pub albedos: Vec<f64>,
    /// Mean cosine g of the Henyey–Greenstein phase function, inside (−1, 1).
    pub mean_cosine: f64,
    /// Index inside over that outside, at least 1.
    pub eta: f64,
    /// Optical depth of a slab, ∞ for a half-space. Light that passes it does not return.
    pub depth: f64,
    /// Directions at entry.
    pub incidence: Incidence,
    /// Rings of the radial profile.
    pub bins: Bins,
}

/// Reflectance of one albedo, as shares of the light that entered.
#[derive(Debug, Clone)]
pub struct Reflectance {
    /// All light that leaves.
    pub total: Estimate,
    /// Light that leaves in each ring.
    pub rings: Vec<Estimate>,
}

/// Batches that the standard errors come from. Their relative error is 1 / √(2 · 63), 9 %.
const BATCHES: usize = 64;

/// Weight of the brightest albedo below which a path is continued with the probability [`SURVIVAL`] only.
const DIM: f64 = 0.05;
const SURVIVAL: f64 = 0.25;

/// Mean cosine below which the formula would divide rounding by rounding.
const ISOTROPIC: f64 = 1e-6;

impl Walk {
    /// Walks about `paths` paths, a multiple of the number of batches, and returns the reflectance of each albedo.
    ///
    /// Each flight towards the surface scores the light that would leave uncollided; then the flight is sampled without
    /// regard to that. Absorption multiplies the weights.
    pub fn run(&self, paths: usize, seed: u64) -> Vec<Reflectance> {
        let per_batch = paths.div_ceil(BATCHES);
        let columns = self.bins.count + 1;
        let mut state = seed;
        let mut batches = Vec::with_capacity(BATCHES);
        for _ in 0..BATCHES {
            let mut sums = vec![0.0; columns * self.albedos.len()];
            for _ in 0..per_batch {
                self.path(&mut state, &mut sums);
            }
            sums.iter_mut().for_each(|x| *x /= per_batch as f64);
            batches.push(sums);
        }
        let estimate = |i: usize| {
            let mut means = Moments::new();
            batches.iter().for_each(|batch| means.push(batch[i]));
            means.estimate().expect("several batches")
        };
        (0..self.albedos.len())
            .map(|a| Reflectance {
                total: estimate(a * columns),
                rings: (1..columns).map(|i| estimate(a * columns + i)).collect(),
            })
            .collect()
    }

    /// Walks one path and adds its scores: for each albedo the total, then the rings.
    fn path(&self, state: &mut u64, sums: &mut [f64]) {
        let mut position = DVec3::ZERO;
        let mut direction = match self.incidence {
            Incidence::Normal => DVec3::Z,
            Incidence::Diffuse => turned(DVec3::Z, refracted_cosine(self.eta, state), split_mix(state)),
        };
        let mut weights = vec![1.0; self.albedos.len()];
        loop {
            let mut internal = 0.0;
            if direction.z < 0.0 {
                let length = -position.z / direction.z;
                internal = internal_reflectance(-direction.z, self.eta);
                let leaving = (1.0 - internal) * (-length).exp();
                self.score(position + length * direction, leaving, &weights, sums);
            }
            let flight = -(1.0 - split_mix(state)).ln();
            let end = position + flight * direction;
            if end.z < 0.0 {
                if internal <= split_mix(state) {
                    return;
                }
                // Free flights have no memory: the path starts anew on the surface.
                let length = -position.z / direction.z;
                position = (position + length * direction).with_z(0.0);
                direction.z = -direction.z;
                continue;
            }
            if end.z > self.depth {
                return;
            }
            position = end;
            weights.iter_mut().zip(&self.albedos).for_each(|(w, a)| *w *= a);
            if weights.iter().all(|&w| w < DIM) {
                if split_mix(state) >= SURVIVAL {
                    return;
                }
                weights.iter_mut().for_each(|w| *w /= SURVIVAL);
            }
            direction = turned(direction, self.turn(split_mix(state)), split_mix(state));
        }
    }

    fn score(&self, place: DVec3, leaving: f64, weights: &[f64], sums: &mut [f64]) {
        let columns = self.bins.count + 1;
        let ring = self.bins.of_squared(place.x * place.x + place.y * place.y);
        for (a, weight) in weights.iter().enumerate() {
            sums[a * columns] += weight * leaving;
            if let Some(ring) = ring {
                sums[a * columns + 1 + ring] += weight * leaving;
            }
        }
    }

    /// Samples the cosine of the turn at a scattering [HenyeyGreenstein41].
    fn turn(&self, u: f64) -> f64 {
        let g = self.mean_cosine;
        if g.abs() < ISOTROPIC {
            return 1.0 - 2.0 * u;
        }
        let ratio = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
        ((1.0 + g * g - ratio * ratio) / (2.0 * g)).clamp(-1.0, 1.0)
    }
}

/// Samples the cosine inside of diffuse light that passes the boundary.
fn refracted_cosine(eta: f64, state: &mut u64) -> f64 {
    loop {
        let outside = (1.0 - split_mix(state)).sqrt();
        if split_mix(state) >= external_reflectance(outside, eta) {
            return (1.0 - (1.0 - outside * outside) / (eta * eta)).sqrt();
        }
    }
}

/// Returns the unit vector at the angle of cosine `cos` from the unit vector `axis`, turned about it by `v` rounds.
fn turned(axis: DVec3, cos: f64, v: f64) -> DVec3 {
    let (x, y) = axis.any_orthonormal_pair();
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (s, c) = (TAU * v).sin_cos();
    (sin * c * x + sin * s * y + cos * axis).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subsurface::MediumLane;
    use crate::subsurface::totals::{diffuse_total, normal_total};

    /// Standard errors of a two-sided test at the level 1e-6 by Student's t with the 63 degrees of freedom of the
    /// batches.
    const SIGMAS: f64 = 5.420;

    const RINGS: Bins = Bins { first: 1e-8, last: 1e8, count: 64 };

    fn walk(albedos: &[f64]) -> Walk {
        Walk {
            albedos: albedos.to_vec(),
            mean_cosine: 0.0,
            eta: 1.0,
            depth: f64::INFINITY,
            incidence: Incidence::Normal,
            bins: RINGS,
        }
    }

    /// Student's tests at the level 1e-6 each.
    #[test]
    fn totals_are_exact() {
        let albedos = [0.2, 0.5, 0.8, 0.9, 0.95];
        for incidence in [Incidence::Normal, Incidence::Diffuse] {
            let results = Walk { incidence, ..walk(&albedos) }.run(300_000, 1);
            for (&omega, found) in albedos.iter().zip(&results) {
                let exact = if incidence == Incidence::Normal {
                    normal_total(&MediumLane::isotropic(omega))
                } else {
                    diffuse_total(&MediumLane::isotropic(omega))
                };
                assert!(found.total.sigmas(exact).abs() < SIGMAS, "{omega} {:?} {exact}", found.total);
            }
        }
    }

    /// The same behind a boundary and with scattering forwards and backwards.
    #[test]
    fn totals_behind_a_boundary_are_exact() {
        for (omega, mean_cosine, eta) in [(0.99, 0.8, 1.4), (0.9, 0.8, 1.4), (0.98, 0.95, 1.0), (0.9, -0.6, 2.0)] {
            let medium = MediumLane { mean_cosine, eta, ..MediumLane::isotropic(omega) };
            for (incidence, exact) in
                [(Incidence::Normal, normal_total(&medium)), (Incidence::Diffuse, diffuse_total(&medium))]
            {
                let found = Walk { incidence, mean_cosine, eta, ..walk(&[omega]) }.run(100_000, 6)[0].total;
                assert!(found.sigmas(exact).abs() < SIGMAS, "{medium:?} {incidence:?} {found:?} {exact}");
            }
        }
    }

    /// The rings reach from 1e-8 to 1e8: what lies outside is below rounding. 2π ∫ r R dr is the total.
    #[test]
    fn rings_sum_to_the_total() {
        for found in walk(&[0.3, 0.9]).run(20_000, 2) {
            let sum: f64 = found.rings.iter().map(|r| r.value).sum();
            assert!((sum / found.total.value - 1.0).abs() < 1e-6, "{sum}");
        }
    }

    /// Giovanelli's value for n = 1.5, μa = 10, μs = 90, as the test of [Wang95]: 0.2600 with the specular reflection
    /// 0.04. The exact total is 0.25992, so that it is wrong by one unit of its last digit, which is added to Student's
    /// test at the level 1e-6.
    #[test]
    fn a_boundary_reflects_as_published() {
        let found = Walk { eta: 1.5, ..walk(&[0.9]) }.run(400_000, 3)[0].total;
        let total = 0.04 + 0.96 * found.value;
        assert!((total - 0.26).abs() < 1e-4 + SIGMAS * 0.96 * found.standard_error, "{total} {found:?}");
    }

    /// Slabs by adding–doubling, the first of them also [Wang95]. The bound adds half a
    /// unit of the last digit to Student's test at the level 1e-6.
    #[test]
    fn slabs_reflect_as_published() {
        let slabs = [
            (Incidence::Normal, 0.9, 0.75, 2.0, 0.097395),
            (Incidence::Diffuse, 0.9, 0.75, 2.0, 0.191090),
            (Incidence::Normal, 0.99, 0.8, 2.0, 0.120111),
            (Incidence::Normal, 0.9, -0.5, 2.0, 0.462772),
            (Incidence::Normal, 1.0, 0.85, 4.0, 0.190914),
            (Incidence::Diffuse, 1.0, 0.0, 5.0, 0.792341),
        ];
        for (incidence, omega, mean_cosine, depth, expected) in slabs {
            let found = Walk { incidence, mean_cosine, depth, ..walk(&[omega]) }.run(200_000, 4)[0].total;
            let bound = 0.5e-6 + SIGMAS * found.standard_error;
            assert!((found.value - expected).abs() < bound, "{omega} {mean_cosine} {depth}: {found:?} {expected}");
        }
    }
}
