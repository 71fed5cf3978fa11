//! The white furnace: no surface reflects more than it receives, lossless ones reflect all of it. Albedos are means of
//! sampled weights, so that these tests also hold the samplers to the values.

use crate::models::{Model, direction, models, white_plastic};
use etendue::bsdf::albedo::{Albedo, ERROR, moments};
use etendue::bsdf::{Bsdf, Conductor, Dielectric, Fresnel, Ggx, Lambert, MetallicRoughness, Surface, Thin, Wall};
use etendue::geometry::Local;
use etendue::sampling::Density;
use etendue::spectrum::Spectrum;
use etendue::transport::TransportMode;
use etendue_testing::chi_square::sidak;
use etendue_testing::random::{Random, samples};
use statrs::distribution::{ContinuousCDF, Normal};

const ALPHAS: [f32; 7] = [0.0, 1e-4, 1e-3, 0.01, 0.1, 0.3, 1.0];
const COSINES: [f32; 6] = [1.0, 0.7, 0.2, 0.01, 1e-3, 1e-4];

const SAMPLES: u32 = 8000;

/// Mean and standard error of what leaves (all lanes' largest), without the compression of radiance in dense media.
fn albedo(surface: &Surface, known: Local, mode: TransportMode, lane: usize, seed: u64) -> (f64, f64) {
    let mut random = Random::new(seed);
    let n = samples(SAMPLES);
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..n {
        let weight = surface.sample(known, mode, random.cube()).map_or(0.0, |s| {
            let compression = if mode == TransportMode::Radiance { s.eta * s.eta } else { 1.0 };
            let cos = if let Density::Smooth(_) = s.density { s.direction.z.abs() } else { 1.0 };
            f64::from(s.value[lane] * compression * cos / s.density.value())
        });
        sum += weight;
        squares += weight * weight;
    }
    let mean = sum / f64::from(n);
    (mean, ((squares / f64::from(n) - mean * mean).max(0.0) / f64::from(n)).sqrt())
}

/// The z score below which all of `tests` one-sided tests stay with the family's level.
fn z_limit(tests: usize) -> f64 {
    Normal::standard().inverse_cdf(1.0 - sidak(tests))
}

/// Rounding of one weight, a few dozen operations, and its mean.
const ROUNDING: f64 = 32.0 * f32::EPSILON as f64;

/// What tables may add: the error of the layer at this angle, and of its mean, by which the base is divided.
fn table_error(alpha: f32, cos: f32, f0: f32, f90: f32) -> f64 {
    let layer = Albedo::of(Ggx::new(alpha));
    let [f0, f90] = [f0, f90].map(Spectrum::splat);
    let below = 1.0 - layer.at(f64::from(cos)).albedo(f0, f90)[0];
    ERROR * (1.0 + below / (1.0 - f64::from(layer.mean(f0, f90)[0])))
}

#[test]
fn no_surface_creates_light() {
    let white = |alpha: f32| {
        let ggx = Ggx::new(alpha);
        let layer = Fresnel::Schlick { f0: Spectrum::splat(0.04), f90: Spectrum::ONE };
        let named =
            |name: &str, surface| Model { name: format!("white {name}, alpha {alpha}"), surface, eta: 1.0, base: 0.0 };
        vec![
            named("conductor", Surface::Conductor(Conductor { ggx, fresnel: Fresnel::Constant(Spectrum::ONE) })),
            named(
                "glass",
                Surface::Dielectric(Dielectric { ggx, eta: 1.5, reflect: Spectrum::ONE, transmit: Spectrum::ONE }),
            ),
            named("sheet", Surface::Thin(Thin { ggx, fresnel: layer, transmit: Spectrum::ONE })),
            named("plastic", white_plastic(alpha).surface()),
            named(
                "half glass",
                MetallicRoughness { transmission: 0.5, wall: Wall::Solid, ..white_plastic(alpha) }.surface(),
            ),
            named("half sheet", MetallicRoughness { transmission: 0.5, ..white_plastic(alpha) }.surface()),
        ]
    };
    let cases: Vec<(f32, Model)> =
        ALPHAS.iter().flat_map(|&a| white(a).into_iter().chain(models(a)).map(move |m| (a, m))).collect();
    let limit = z_limit(cases.len() * COSINES.len());
    for (i, (alpha, model)) in cases.iter().enumerate() {
        for (j, cos) in COSINES.into_iter().enumerate() {
            let mode = if (i + j) % 2 == 0 { TransportMode::Radiance } else { TransportMode::Importance };
            let known = direction(if (i + j / 2) % 2 == 0 { cos } else { -cos }, 1.0);
            let (mean, error) = albedo(&model.surface, known, mode, 0, (i * 10 + j) as u64);
            let bound = 1.0 + table_error(*alpha, cos, 0.04, 1.0) + limit * error + ROUNDING;
            assert!(mean < bound, "{} cos {cos} {mode:?}: {mean} > {bound}", model.name);
        }
    }
}

#[test]
fn smooth_faces_and_white_matter_lose_nothing() {
    let ggx = Ggx::new(0.0);
    let lossless = [
        Surface::Lambert(Lambert { albedo: Spectrum::ONE }),
        Surface::Conductor(Conductor { ggx, fresnel: Fresnel::Constant(Spectrum::ONE) }),
        Surface::Dielectric(Dielectric { ggx, eta: 1.5, reflect: Spectrum::ONE, transmit: Spectrum::ONE }),
        Surface::Dielectric(Dielectric {
            ggx: Ggx::new(0.3),
            eta: 1.0,
            reflect: Spectrum::ONE,
            transmit: Spectrum::ONE,
        }),
        Surface::Thin(Thin { ggx, fresnel: Fresnel::Dielectric { eta: 1.5 }, transmit: Spectrum::ONE }),
        Surface::Thin(Thin { ggx, fresnel: Fresnel::Constant(Spectrum::splat(0.3)), transmit: Spectrum::ONE }),
    ];
    for (i, surface) in lossless.iter().enumerate() {
        for cos in COSINES.into_iter().flat_map(|c| [c, -c]) {
            for mode in [TransportMode::Radiance, TransportMode::Importance] {
                // every weight is one: no variance
                let (mean, _) = albedo(surface, direction(cos, 0.5), mode, 2, i as u64);
                assert!((mean - 1.0).abs() < ROUNDING, "{surface:?} cos {cos} {mode:?}: {mean}");
            }
        }
    }
}

#[test]
fn a_white_base_under_a_white_layer_loses_nothing() {
    let layers = [(1.5f32, 0.04f32), (1.33, 0.0201), (3.0, 0.25)];
    let limit = z_limit(2 * layers.len() * ALPHAS.len() * COSINES.len());
    for (ior, f0) in layers {
        for alpha in ALPHAS {
            let surface = MetallicRoughness { ior, ..white_plastic(alpha) }.surface();
            for (i, cos) in COSINES.into_iter().enumerate() {
                let (mean, error) = albedo(&surface, direction(cos, 2.0), TransportMode::Radiance, 1, i as u64);
                let bound = table_error(alpha, cos, f0, 1.0) + limit * error + ROUNDING;
                assert!((mean - 1.0).abs() < bound, "ior {ior} alpha {alpha} cos {cos}: {mean}, within {bound}");
            }
        }
    }
}

#[test]
fn rough_metal_reflects_what_quadrature_says() {
    // a mean of weights in [0, 1] of which most are one: Bernstein's inequality, since rare losses are not normal
    let log = (2.0 / sidak(ALPHAS.len() * COSINES.len())).ln();
    let n = f64::from(samples(SAMPLES));
    for alpha in ALPHAS.into_iter().filter(|&a| a > 0.0) {
        let ggx = Ggx::new(alpha);
        let metal = Surface::Conductor(Conductor { ggx, fresnel: Fresnel::Constant(Spectrum::ONE) });
        for (i, cos) in COSINES.into_iter().enumerate() {
            let exact = moments(ggx, f64::from(cos), [24, 48]).white;
            let (mean, _) = albedo(&metal, direction(cos, 2.0), TransportMode::Importance, 1, i as u64);
            let bound = (2.0 * exact * (1.0 - exact) * log / n).sqrt() + log / (3.0 * n) + ROUNDING;
            assert!((mean - exact).abs() < bound, "alpha {alpha} cos {cos}: {mean} for {exact}, within {bound}");
        }
    }
}

#[test]
fn without_specular_and_metal_a_surface_is_lambert() {
    let matte = MetallicRoughness { specular: 0.0, base: Spectrum::splat(0.5), ..white_plastic(0.2) }.surface();
    assert!(matches!(matte, Surface::Lambert(Lambert { albedo }) if albedo == Spectrum::splat(0.5)));
}

#[test]
fn nearly_smooth_surfaces_scatter_like_smooth_ones() {
    // normals deviate by 2 α on average at this angle, and directions by twice that; refraction turns by less
    let (rough, tolerance) = (1e-4f32, 8e-4);
    let mean = |surface: &Surface, mode, seed| {
        let (mut random, n) = (Random::new(seed), samples(40_000));
        let known = direction(0.7, 0.4);
        let mut sums = [0.0f64; 8];
        for _ in 0..n {
            let Some(s) = surface.sample(known, mode, random.cube()) else { continue };
            let cos = if let Density::Smooth(_) = s.density { s.direction.z.abs() } else { 1.0 };
            let weight = f64::from(s.value[1] * cos / s.density.value());
            let side = if s.direction.z > 0.0 { 0 } else { 4 };
            let d = [s.direction.x, s.direction.y, s.direction.z].map(f64::from);
            for (sum, part) in sums[side..].iter_mut().zip([1.0, d[0], d[1], d[2]]) {
                *sum += weight * part / f64::from(n);
            }
        }
        (sums, 1.0 / f64::from(n).sqrt())
    };
    for (smooth, rough) in models(0.0).iter().zip(models(rough)).filter(|(m, _)| !m.name.starts_with("Lambert")) {
        for mode in [TransportMode::Radiance, TransportMode::Importance] {
            let ((a, error), (b, _)) = (mean(&smooth.surface, mode, 1), mean(&rough.surface, mode, 2));
            for (x, y) in a.into_iter().zip(b) {
                // weights times directions are below 2.5 in size: their deviation is at most that, and twice, for both
                // means
                let bound = tolerance + z_limit(16 * 8) * 2.5 * 2f64.sqrt() * error;
                assert!((x - y).abs() < bound, "{} {mode:?}: {a:?} {b:?}", smooth.name);
            }
        }
    }
}
