//! Inverses: S(S⁻¹(w)) = w, and S⁻¹(S(u)) is uniform when its choices are.

use crate::models::{direction, models};
use etendue::bsdf::Bsdf;
use etendue::geometry::Local;
use etendue::numeric::BELOW_ONE;
use etendue::sampling::Density;
use etendue::transport::TransportMode;
use etendue_testing::chi_square::{sidak, survival};
use etendue_testing::random::{Random, samples};

const ALPHAS: [f32; 4] = [1e-3, 0.05, 0.3, 1.0];
const COSINES: [f32; 4] = [0.95, 0.3, -0.6, -0.05];
/// Cells along each axis of the cube.
const CELLS: usize = 8;

fn distance(a: Local, b: Local) -> f64 {
    let d: Local<f64> = a.cast::<f64>().plus(b.cast::<f64>().reversed());
    d.dot(d).sqrt()
}

fn smooth(sample: Option<etendue::bsdf::BsdfSample>) -> Option<Local> {
    sample.filter(|s| matches!(s.density, Density::Smooth(_))).map(|s| s.direction)
}

#[test]
fn sampling_undoes_inversion() {
    // a direction is rounded in three components, summed to a half vector, halved, reflected: each time to one epsilon
    const DIRECTION: f64 = 16.0 * f32::EPSILON as f64;
    let mut random = Random::new(11);
    for model in ALPHAS.into_iter().flat_map(models) {
        for i in 0..samples(400) {
            let known = direction(COSINES[i as usize % 4], 0.3);
            let Some(other) = smooth(model.surface.sample(known, TransportMode::Radiance, random.cube())) else {
                continue;
            };
            let Some((u, log)) = model.surface.invert(known, other, TransportMode::Radiance, random.cube()) else {
                panic!("{}: {known:?} {other:?} was sampled and has no inverse", model.name);
            };
            assert!(log.is_finite() && u.iter().all(|x| (0.0..1.0).contains(x)), "{}: {u:?} {log}", model.name);
            let again = |v: [f32; 3]| smooth(model.surface.sample(known, TransportMode::Radiance, v));
            // the random numbers themselves are rounded, to 2⁻²⁴ of turns and heights
            let moved = [1, 2].map(|axis| {
                [-1.0, 1.0].map(|sign| {
                    let mut v = u;
                    v[axis] = (v[axis] + sign * 4.0 * f32::EPSILON).clamp(0.0, BELOW_ONE);
                    again(v).zip(again(u)).map_or(0.0, |(a, b)| distance(a, b))
                })
            });
            let slack = DIRECTION + moved.as_flattened().iter().sum::<f64>();
            let Some(back) = again(u) else {
                let is_along_the_surface = f64::from(other.z.abs()) < slack; // rounding takes it to the other side
                assert!(is_along_the_surface, "{}: {u:?} of {other:?} samples nothing", model.name);
                continue;
            };
            assert!(distance(back, other) < slack, "{}: {other:?} became {back:?} by {u:?} ({slack})", model.name);
        }
    }
}

/// The p-value of inverted samples being uniform over the random numbers that give a smooth direction.
fn inversion_is_uniform(surface: &impl Bsdf, known: Local, seed: u64) -> f64 {
    let mut random = Random::new(seed);
    let cell = |u: [f32; 3]| u.iter().fold(0, |i, x| i * CELLS + (x * CELLS as f32) as usize);
    let (mut before, mut after) = (vec![0.0; CELLS.pow(3)], vec![0.0; CELLS.pow(3)]);
    for _ in 0..samples(40_000) {
        let u: [f32; 3] = random.cube();
        let Some(other) = smooth(surface.sample(known, TransportMode::Importance, u)) else { continue };
        // of two independent streams one counts the random numbers themselves, the other their images
        if random.f32() < 0.5 {
            before[cell(u)] += 1.0;
        } else if let Some((v, _)) = surface.invert(known, other, TransportMode::Importance, random.cube()) {
            after[cell(v)] += 1.0;
        }
    }
    two_samples(&before, &after)
}

/// χ² for two histograms of one distribution: each cell of either against its share of both, cells with small counts
/// left out; a pair of cells is bound by its sum.
fn two_samples(a: &[f64], b: &[f64]) -> f64 {
    let [n, m] = [a, b].map(|h| h.iter().sum::<f64>());
    let (mut statistic, mut degrees) = (0.0, -1.0);
    for (x, y) in a.iter().zip(b) {
        let expected = [n, m].map(|k| (x + y) * k / (n + m));
        if expected[0].min(expected[1]) > 5.0 {
            statistic += (x - expected[0]).powi(2) / expected[0] + (y - expected[1]).powi(2) / expected[1];
            degrees += 1.0;
        }
    }
    survival(statistic, degrees)
}

#[test]
fn inverted_samples_are_uniform_in_the_unit_cube() {
    let mut results = Vec::new();
    for (a, alpha) in ALPHAS.into_iter().enumerate() {
        for (m, model) in models(alpha).iter().enumerate() {
            let known = direction(COSINES[(a + m) % 4], 0.3);
            results.push((inversion_is_uniform(&model.surface, known, (a * 100 + m) as u64), model.name.clone()));
        }
    }
    let level = sidak(results.len());
    let failed: Vec<_> = results.into_iter().filter(|(p, _)| *p < level).collect();
    assert!(failed.is_empty(), "p-values below {level:e}: {failed:#?}");
}
