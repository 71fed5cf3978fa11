//! χ² of every BSDF sampler against its density, toward the light and toward the camera: expected counts below 5 are
//! pooled, levels follow Šidák. Deep: 1.2 million samples a model, roughness, angle and direction of the walk.

use crate::models::{Model, direction, models};
use etendue::bsdf::{Bsdf, Lobes};
use etendue::geometry::Local;
use etendue::transport::TransportMode;
use etendue_testing::chi_square::{SphereCells, p_value, sidak};
use etendue_testing::random::{Random, samples};
use rayon::prelude::*;

const ALPHAS: [f32; 6] = [1e-4, 1e-3, 0.01, 0.05, 0.3, 1.0];
const COSINES: [f32; 6] = [1.0, 0.6, 0.01, 1e-4, -0.6, -0.05];
const WAYS: [TransportMode; 2] = [TransportMode::Radiance, TransportMode::Importance];
/// Per model, roughness, angle and direction of the walk in everyday tests.
const SAMPLES: u32 = 12_000;
/// Error of each cell's expected count: a cell of five, below which they are pooled, scatters by 2.2.
const TOLERANCE: f64 = 0.2;

/// Cells for either side of the surface: around the mirror direction, and around the refracted one.
struct Cells {
    known: Local,
    sides: [SphereCells; 2],
}

impl Cells {
    fn new(model: &Model, known: Local, alpha: f32) -> Self {
        let k: Local<f64> = known.cast();
        let eta = if known.z > 0.0 { f64::from(model.eta) } else { 1.0 / f64::from(model.eta) };
        let (x, y) = (-k.x / eta, -k.y / eta);
        // under total reflection any axis will do
        let z = (1.0 - x * x - y * y).max(0.0).sqrt().copysign(-k.z);
        let length = (x * x + y * y + z * z).sqrt();
        let width = 0.25 * f64::from(alpha).powi(2);
        let mirror = SphereCells::new([-k.x, -k.y, k.z], width);
        Cells { known, sides: [mirror, SphereCells::new([x, y, z].map(|c| c / length), width)] }
    }

    fn len(&self) -> usize {
        self.sides[0].count() + self.sides[1].count()
    }

    fn index(&self, w: Local) -> usize {
        let d = [w.x, w.y, w.z].map(f64::from);
        if self.known.same_side(w) { self.sides[0].index(d) } else { self.sides[0].count() + self.sides[1].index(d) }
    }

    /// Probability of each cell.
    fn integrate(&self, pdf: impl Fn(Local<f64>) -> f64) -> Vec<f64> {
        let known: Local<f64> = self.known.cast();
        let side = |side: usize| {
            self.sides[side].integrate(TOLERANCE / f64::from(samples(SAMPLES)), &|[x, y, z]| {
                let w = Local::new(x, y, z);
                if known.same_side(w) == (side == 0) { pdf(w) } else { 0.0 }
            })
        };
        [side(0), side(1)].concat()
    }
}

/// p-values for walks toward the light and toward the camera, which have one density.
fn directions_follow_the_density(model: &Model, alpha: f32, known: Local, seed: u64) -> [f64; 2] {
    let cells = Cells::new(model, known, alpha);
    let mut expected = cells.integrate(|w| model.surface.pdf(known.cast(), w, TransportMode::Radiance, Lobes::SMOOTH));
    let total: f64 = expected.iter().sum();
    let n = samples(SAMPLES);
    assert!(
        total < 1.0 + TOLERANCE * cells.len() as f64 / f64::from(n),
        "{}: the density integrates to {total}",
        model.name
    );
    // the last cell: no direction, or a Dirac one
    expected.push((1.0 - total).max(0.0));
    let expected: Vec<f64> = expected.iter().map(|p| p * f64::from(n)).collect();
    WAYS.map(|mode| p_value(&counts(model, known, mode, &cells, seed), &expected))
}

fn counts(model: &Model, known: Local, mode: TransportMode, cells: &Cells, seed: u64) -> Vec<f64> {
    let mut observed = vec![0.0; cells.len() + 1];
    let mut random = Random::new(seed + 7919 * (mode == TransportMode::Importance) as u64);
    for _ in 0..samples(SAMPLES) {
        let cell = match model.surface.sample(known, mode, random.cube()) {
            Some(sample) if !sample.density.is_delta() => {
                assert!(sample.density.value() > 0.0, "{}: sampled where the density is zero", model.name);
                cells.index(sample.direction)
            }
            _ => cells.len(),
        };
        observed[cell] += 1.0;
    }
    observed
}

/// Every model at every roughness and angle that directions of f32 resolve: seen along the surface a lobe is α cos
/// wide, and directions are rounded to 2⁻²⁴. The shift of a count by that is seen against its scatter the better the
/// more samples there are, with their root. Everyday tests take every fourth.
fn cases() -> Vec<(f32, Model, f32)> {
    let resolved = 16.0 * 0.5 * f32::EPSILON * (samples(SAMPLES) as f32 / SAMPLES as f32).sqrt();
    let angles = |alpha: f32| COSINES.into_iter().filter(move |cos| alpha * cos.abs() >= resolved);
    let of = |alpha: f32| angles(alpha).flat_map(move |cos| models(alpha).into_iter().map(move |m| (alpha, m, cos)));
    // 4 and the 9 models have no common divisor: each model gets its turn at each angle of some roughness
    let step = if samples(1) > 1 { 1 } else { 4 };
    ALPHAS.into_iter().flat_map(of).step_by(step).collect()
}

#[test]
fn every_sampler_follows_its_density() {
    let test = |(i, (alpha, model, cos)): (usize, &(f32, Model, f32))| {
        let p = directions_follow_the_density(model, *alpha, direction(*cos, 0.7), i as u64);
        p.into_iter().zip(WAYS).map(|(p, way)| (p, format!("{}, cos {cos}, mode {way:?}", model.name))).collect()
    };
    let results: Vec<Vec<(f64, String)>> = cases().par_iter().enumerate().map(test).collect();
    let results = results.concat();
    let level = sidak(results.len());
    println!("{} tests, least p {:.2e}", results.len(), results.iter().map(|r| r.0).fold(1.0, f64::min));
    let failed: Vec<_> = results.into_iter().filter(|(p, _)| *p < level).collect();
    assert!(failed.is_empty(), "p-values below {level:e}: {failed:#?}");
}

/// Planted: directions of a roughness 20 % off, in the deep test 2 %.
#[test]
fn a_sampler_of_another_roughness_is_convicted() {
    let off = 0.2 / (f64::from(samples(SAMPLES)) / f64::from(SAMPLES)).sqrt();
    for alpha in ALPHAS {
        let (right, wrong) = (models(alpha), models(alpha * (1.0 - off as f32)));
        let known = direction(0.6, 0.7);
        for (right, wrong) in right.iter().zip(&wrong).filter(|(m, _)| m.name.starts_with("conductor")) {
            let cells = Cells::new(right, known, alpha);
            let expected =
                cells.integrate(|w| right.surface.pdf(known.cast(), w, TransportMode::Radiance, Lobes::SMOOTH));
            let expected: Vec<f64> = expected.iter().map(|p| p * f64::from(samples(SAMPLES))).collect();
            let observed = counts(wrong, known, TransportMode::Radiance, &cells, 1);
            assert!(p_value(&observed[..expected.len()], &expected) < sidak(1), "alpha {alpha}");
        }
    }
}
