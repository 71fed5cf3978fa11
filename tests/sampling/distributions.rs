//! χ² of every BSDF sampler against its density: expected counts below 5 are pooled, levels follow Šidák.

use crate::chi_square::{SphereCells, p_value, sidak};
use crate::models::{Model, direction, models};
use crate::random::{Random, samples};
use etendue::bsdf::{Bsdf, Lobes};
use etendue::geometry::Local;
use etendue::transport::Transport;

const ALPHAS: [f32; 4] = [1e-3, 0.05, 0.3, 1.0];
const COSINES: [f32; 4] = [1.0, 0.6, -0.6, -0.05];
/// Absolute error of each cell's probability.
const TOLERANCE: f64 = 2e-7;

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
        // between the width of the lobe and the hemisphere, since diffuse light is there too
        let width = f64::from(alpha);
        let mirror = SphereCells::new([-k.x, -k.y, k.z], width);
        Cells { known, sides: [mirror, SphereCells::new([x, y, z].map(|c| c / length), width)] }
    }

    fn len(&self) -> usize {
        self.sides[0].len() + self.sides[1].len()
    }

    fn index(&self, w: Local) -> usize {
        let d = [w.x, w.y, w.z].map(f64::from);
        if self.known.same_side(w) { self.sides[0].index(d) } else { self.sides[0].len() + self.sides[1].index(d) }
    }

    /// Probability of each cell.
    fn integrate(&self, pdf: impl Fn(Local<f64>) -> f64) -> Vec<f64> {
        let known: Local<f64> = self.known.cast();
        let side = |side: usize| {
            self.sides[side].integrate(TOLERANCE, &|[x, y, z]| {
                let w = Local::new(x, y, z);
                if known.same_side(w) == (side == 0) { pdf(w) } else { 0.0 }
            })
        };
        [side(0), side(1)].concat()
    }
}

fn directions_follow_the_density(model: &Model, alpha: f32, known: Local, toward: Transport, seed: u64) -> f64 {
    let cells = Cells::new(model, known, alpha);
    let mut expected = cells.integrate(|w| model.surface.pdf(known.cast(), w, toward, Lobes::SMOOTH));
    let total: f64 = expected.iter().sum();
    assert!(total < 1.0 + TOLERANCE * cells.len() as f64, "{}: the density integrates to {total}", model.name);
    // the last cell: no direction, or a Dirac one
    expected.push((1.0 - total).max(0.0));
    let n = samples(60_000);
    let mut observed = vec![0.0; expected.len()];
    let mut random = Random::new(seed);
    for _ in 0..n {
        let cell = match model.surface.sample(known, toward, random.cube()) {
            Some(sample) if !sample.density.is_delta() => {
                assert!(sample.density.value() > 0.0, "{}: sampled where the density is zero", model.name);
                cells.index(sample.direction)
            }
            _ => cells.len(),
        };
        observed[cell] += 1.0;
    }
    let expected: Vec<f64> = expected.iter().map(|p| p * f64::from(n)).collect();
    p_value(&observed, &expected)
}

#[test]
fn every_sampler_follows_its_density() {
    let mut results = Vec::new();
    for (a, alpha) in ALPHAS.into_iter().enumerate() {
        for (m, model) in models(alpha).iter().enumerate() {
            for (c, cos) in COSINES.into_iter().enumerate() {
                let toward = if (a + m + c) % 2 == 0 { Transport::Light } else { Transport::Camera };
                let seed = (a * 1000 + m * 10 + c) as u64;
                let p = directions_follow_the_density(model, alpha, direction(cos, 0.7), toward, seed);
                results.push((p, format!("{}, cos {cos}, toward {toward:?}", model.name)));
            }
        }
    }
    let level = sidak(results.len());
    let failed: Vec<_> = results.into_iter().filter(|(p, _)| *p < level).collect();
    assert!(failed.is_empty(), "p-values below {level:e}: {failed:#?}");
}
