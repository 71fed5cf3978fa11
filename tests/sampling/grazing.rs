//! Reciprocity where it is hardest: directions along the surface, down to cosines of 1e-4, and inside narrow lobes,
//! which random pairs of directions miss.

use crate::identities::value;
use crate::models::{Model, any_direction, direction, models};
use etendue::bsdf::{Bsdf, Lobes};
use etendue::geometry::Local;
use etendue::transport::TransportMode;
use etendue_testing::backward::range;
use etendue_testing::random::{Random, samples};

const ALPHAS: [f32; 6] = [1e-4, 1e-3, 0.01, 0.05, 0.3, 1.0];

/// By how much a planted model is not reciprocal.
const PLANTED: f64 = 1e-3;

/// f(a → b) / η_b² in light flow.
fn reduced(model: &Model, a: Local<f64>, b: Local<f64>) -> f64 {
    let index = if b.z > 0.0 { 1.0 } else { f64::from(model.eta) };
    value(&model.surface, TransportMode::Importance, a, b) / index.powi(2)
}

/// A direction of cosine 1e-4 to 1 on either side, evenly in the logarithm.
fn steep_or_grazing(random: &mut Random) -> Local {
    let [u, side, phi] = random.cube();
    let cos = 1e-4f32.powf(u);
    direction(if side < 0.5 { cos } else { -cos }, 7.0 * phi)
}

/// Some other direction: by the lobes, or anywhere, or grazing.
fn partner(model: &Model, a: Local, i: u32, random: &mut Random) -> Option<Local> {
    match i % 3 {
        0 => model
            .surface
            .sample(a, TransportMode::Radiance, random.cube())
            .filter(|s| !s.density.is_delta())
            .map(|s| s.direction),
        1 => Some(any_direction(random.cube())),
        _ => Some(steep_or_grazing(random)),
    }
}

/// Whether the values of a pair agree up to the rounding of f64 that [`range`] bounds on either way; `None` where they
/// are zero or not resolved. Both ways have a range, since they are different functions of directions whose length is
/// not quite one: one takes the cosine of wi to the half vector and the other that of wo, which along the surface moves
/// them apart.
fn reciprocal(model: &Model, [a, b]: [Local; 2], factor: f64) -> Option<bool> {
    let pair = [a, b].map(|w| w.cast::<f64>().normalized());
    let [back_low, back_high] = range(pair, f64::EPSILON, model.base, |a, b| reduced(model, b, a))?;
    if back_high - back_low > 0.25 * PLANTED * back_high {
        return None; // under a layer that reflects nearly all, what is left is a difference of rounded numbers
    }
    let [low, high] = range(pair, f64::EPSILON, model.base, |a, b| factor * reduced(model, a, b))?;
    (high > 0.0).then_some(low <= back_high && back_low <= high)
}

#[test]
fn every_model_is_reciprocal_along_the_surface_and_within_its_lobes() {
    let mut random = Random::new(71);
    let smooth = |m: &Model| m.surface.lobes().intersects(Lobes::SMOOTH);
    for model in ALPHAS.into_iter().flat_map(models).filter(smooth) {
        let (mut compared, mut convicted) = (0, 0);
        for i in 0..samples(600) {
            let a = steep_or_grazing(&mut random);
            let Some(b) = partner(&model, a, i, &mut random) else { continue };
            let Some(right) = reciprocal(&model, [a, b], 1.0) else { continue };
            assert!(right, "{} {a:?} {b:?}", model.name);
            compared += 1;
            convicted += u32::from(reciprocal(&model, [a, b], 1.0 + PLANTED) == Some(false));
        }
        assert!(compared >= samples(100) && convicted == compared, "{}: {compared}, {convicted}", model.name);
    }
}
