//! Values against formulas as textbooks print them, in double precision and written from the books and not from the
//! code.

use crate::models::{any_direction, white_plastic};
use etendue::bsdf::{
    Bsdf, Conductor, Dielectric, Fresnel, Ggx, Lobes, MetallicRoughness, Surface, Thin, Wall, fresnel,
};
use etendue::geometry::Local;
use etendue::spectrum::Spectrum;
use etendue_testing::random::{Random, samples};
use std::f64::consts::PI;

fn tan2(w: Local<f64>) -> f64 {
    (1.0 - w.z * w.z) / (w.z * w.z)
}

/// D(h) in the angle, Λ in the tangent, and masking of heights that are correlated: Walter et al. 2007 (33), Heitz 2014
/// (72) and (99).
#[test]
fn rough_reflection_is_the_textbooks() {
    // the textbook's 1 − cos² cancels: one rounding over the smallest α² cos⁴, of a half vector at cos 0.05
    const CANCELLATION: f64 = f64::EPSILON / (2.5e-3 * 6.25e-6);
    let mut random = Random::new(8);
    for alpha in [0.05f32, 0.3, 1.0] {
        let (ggx, a2) = (Ggx::new(alpha), f64::from(alpha).powi(2));
        for _ in 0..samples(300) {
            let upper = |u: [f32; 2]| {
                let w = any_direction(u).cast::<f64>();
                Local::new(w.x, w.y, w.z.abs().max(0.05)).normalized()
            };
            let (wi, wo) = (upper(random.cube()), upper(random.cube()));
            let sum = wi.plus(wo);
            let h = sum.scale(1.0 / sum.dot(sum).sqrt());
            let d = a2 / (PI * h.z.powi(4) * (a2 + tan2(h)).powi(2));
            let lambda = |w| ((1.0 + a2 * tan2(w)).sqrt() - 1.0) / 2.0;
            let expected = d / (1.0 + lambda(wi) + lambda(wo)) / (4.0 * wi.z * wo.z);
            let got = ggx.reflection(wi, wo, h);
            assert!((got / expected - 1.0).abs() < CANCELLATION, "alpha {alpha} {wi:?} {wo:?}: {got}, not {expected}");
        }
    }
}

/// Schlick 1994 (15) at 60 degrees: 1/32 of the way from f0 to f90.
#[test]
fn schlicks_reflectance_has_the_fifth_power() {
    let (f0, f90) = (Spectrum([0.04, 0.3, 0.9]), Spectrum([1.0, 0.8, 1.0]));
    for (cos, share) in [(1.0, 0.0), (0.5, 1.0 / 32.0), (0.75, 1.0 / 1024.0), (0.0, 1.0)] {
        let got = fresnel::schlick::<f64>(f0, f90, cos);
        for lane in 0..3 {
            let expected = f64::from(f0[lane]) * (1.0 - share) + f64::from(f90[lane]) * share;
            assert!((got[lane] - expected).abs() < 4.0 * f64::EPSILON, "cos {cos}: {got:?}");
        }
    }
}

/// α is the square of a file's roughness, for metal, glass and sheets alike [glTF 2.0, appendix B].
#[test]
fn alpha_is_the_square_of_roughness() {
    for roughness in [0.0f32, 0.1, 0.5, 0.9, 1.0] {
        let plastic = MetallicRoughness { roughness, ..white_plastic(1.0) };
        let metal = MetallicRoughness { metallic: 1.0, ..plastic };
        let clear = MetallicRoughness { transmission: 1.0, ..plastic };
        for surface in [metal, clear, MetallicRoughness { wall: Wall::Solid, ..clear }].map(|m| m.surface()) {
            let (Surface::Conductor(Conductor { ggx, .. })
            | Surface::Thin(Thin { ggx, .. })
            | Surface::Dielectric(Dielectric { ggx, .. })) = surface
            else {
                panic!("{surface:?} is a mixture")
            };
            assert_eq!(ggx.alpha(), roughness * roughness, "{surface:?}");
        }
    }
}

/// KHR_materials_specular: its strength scales the reflection of a dielectric at every angle, its colour at normal
/// incidence alone and up to 1; of sheets and of opaque surfaces alike. What is mirrored meets a facet at its own
/// cosine.
#[test]
fn specular_strength_scales_reflection_at_every_angle() {
    // the eight roundings of f0 and f90
    const ROUNDING: f64 = 8.0 * 0.5 * f32::EPSILON as f64;
    let color = Spectrum([0.5, 1.0, 40.0]);
    for strength in [0.25f32, 0.7, 1.0] {
        let sheet =
            MetallicRoughness { transmission: 1.0, specular: strength, specular_color: color, ..white_plastic(0.25) };
        let Surface::Thin(Thin { fresnel, ggx, .. }) = sheet.surface() else { panic!("not a sheet") };
        let opaque = MetallicRoughness { base: Spectrum::ZERO, transmission: 0.0, ..sheet }.surface();
        for cos in [1.0f64, 0.5, 0.1, 0.01] {
            let wo = Local::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            let wi = Local::new(-wo.x, 0.0, cos);
            let mirrored = opaque.eval(wi, wo, Lobes::SMOOTH);
            let facets = ggx.reflection(wi, wo, Local::new(0.0, 0.0, 1.0));
            for lane in 0..3 {
                let f0 = (0.04 * f64::from(color[lane])).min(1.0);
                let expected = f64::from(strength) * (f0 + (1.0 - f0) * (1.0 - cos).powi(5));
                for got in [fresnel.reflectance(cos)[lane], mirrored[lane] / facets] {
                    assert!(
                        (got / expected - 1.0).abs() < ROUNDING,
                        "strength {strength} cos {cos}: {got}, not {expected}"
                    );
                }
            }
        }
    }
}

/// Unpolarised reflectance by Snell's law and the two amplitudes, in sines and cosines; all of it beyond the critical
/// angle.
#[test]
fn a_clear_boundary_reflects_what_fresnels_amplitudes_say() {
    for eta in [1.5f32, 1.0 / 1.5, 2.4] {
        for i in 1..=100 {
            let cos = f64::from(i) / 100.0;
            let n = f64::from(eta);
            let sin_t = (1.0 - cos * cos).sqrt() / n;
            let got = Fresnel::Dielectric { eta }.reflectance(cos)[0];
            let expected = if sin_t >= 1.0 {
                1.0
            } else {
                let cos_t = (1.0 - sin_t * sin_t).sqrt();
                let s = (cos - n * cos_t) / (cos + n * cos_t);
                let p = (n * cos - cos_t) / (n * cos + cos_t);
                0.5 * (s * s + p * p)
            };
            // ten roundings, and those of a cosine near the critical angle of at least 1e-3
            assert!((got - expected).abs() < 10.0 * f64::EPSILON * 1e3, "eta {eta} cos {cos}: {got}, not {expected}");
        }
    }
}
