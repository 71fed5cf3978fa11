//! BSDFs under a shading normal that differs from the geometric normal.

use crate::models::{any_direction, models};
use etendue::bsdf::{Bsdf, Conductor, Dielectric, Fresnel, Ggx, Lambert, Lobes, Shading, Surface};
use etendue::geometry::{Frame, Hit, SurfacePoint};
use etendue::sampling::Density;
use etendue::spectrum::Spectrum;
use etendue::transport::TransportMode;
use etendue_testing::random::{Random, samples};
use glam::Vec3;

fn point(ng: Vec3, ns: Vec3) -> SurfacePoint {
    SurfacePoint {
        p: Vec3::ZERO,
        error: 0.0,
        ng: ng.normalize(),
        frame: Frame::around(ns.normalize()),
        barycentric: [0.3; 2],
        hit: Hit { object: 0, primitive: 0 },
        t: 1.0,
        consistent: true,
        touching: false,
    }
}

fn tilted() -> SurfacePoint {
    point(Vec3::new(0.2, 0.1, 1.0), Vec3::new(-0.3, 0.2, 1.0))
}

fn world(u: [f32; 2]) -> Vec3 {
    let w = any_direction(u);
    Vec3::new(w.x, w.y, w.z)
}

/// Relative: about twenty operations each rounded once, conditioned by the cosines' own division.
const ROUNDING: f32 = 64.0 * f32::EPSILON;

fn close(a: Spectrum, b: Spectrum) -> bool {
    a.zip(b, |x, y| (x - y).abs() / (x.abs() + y.abs()).max(f32::MIN_POSITIVE)).max_lane() < ROUNDING
}

#[test]
fn radiance_and_importance_walks_share_one_bsdf() {
    let (point, mut random) = (tilted(), Random::new(21));
    for model in [0.05, 0.3].into_iter().flat_map(models) {
        for _ in 0..samples(200) {
            let (wi, wo) = (world(random.cube()), world(random.cube()));
            let camera_walk = Shading::new(&point, &model.surface, wo, TransportMode::Radiance);
            let light_walk = Shading::new(&point, &model.surface, wi, TransportMode::Importance);
            let (Some(camera_walk), Some(light_walk)) = (camera_walk, light_walk) else { continue };
            let f = camera_walk.f(wi);
            assert!(close(f, light_walk.f(wo)), "{}: {f:?} {:?}", model.name, light_walk.f(wo));
            let [toward_light, toward_camera] =
                [camera_walk.scattering(wi), light_walk.scattering(wo)].map(|s| s.map_or(Spectrum::ZERO, |s| s.f_cos));
            assert!(close(toward_light, f * wi.dot(point.ng).abs()), "{}", model.name);
            assert!(close(toward_camera, f * wo.dot(point.ng).abs()), "{}", model.name);
        }
    }
}

#[test]
fn light_does_not_leak_between_the_normals() {
    let point = tilted();
    let surface = Surface::Lambert(Lambert { albedo: Spectrum::ONE });
    let (mut random, mut between) = (Random::new(22), 0);
    let up = point.ng;
    let walk = Shading::new(&point, &surface, up, TransportMode::Radiance).unwrap();
    for _ in 0..samples(2000) {
        let w = world(random.cube());
        let sides = [w.dot(point.ng) > 0.0, w.dot(point.frame.n) > 0.0];
        if sides[0] != sides[1] {
            between += 1;
            assert!(walk.f(w).is_black() && walk.scattering(w).is_none());
            assert!(Shading::new(&point, &surface, w, TransportMode::Importance).is_none());
            // a camera there sees the side where it is
            let seen = Shading::new(&point, &surface, w, TransportMode::Radiance).unwrap();
            assert_eq!(seen.scattering(up).is_some(), sides[0]);
        } else {
            assert_eq!(walk.scattering(w).is_some(), sides[0]);
        }
        if let Some(s) = walk.sample(random.cube()) {
            assert!(s.direction.dot(point.ng) > 0.0 && s.direction.dot(point.frame.n) > 0.0);
        }
    }
    assert!(between > 0);
}

#[test]
fn a_sampled_weight_is_the_value_over_the_density() {
    let (point, mut random) = (tilted(), Random::new(23));
    for model in [0.1, 0.5].into_iter().flat_map(models) {
        for i in 0..samples(400) {
            let mode = [TransportMode::Radiance, TransportMode::Importance][i as usize % 2];
            let Some(walk) = Shading::new(&point, &model.surface, world(random.cube()), mode) else { continue };
            let Some(sample) = walk.sample(random.cube()) else { continue };
            let Density::Smooth(pdf) = sample.density else { continue };
            let cos = (point.frame.to_local(sample.direction).z * point.frame.to_local(walk.known()).z).abs();
            if cos < 1e-2 {
                continue; // a world direction's rounding is not small against a grazing cosine
            }
            let back = walk.scattering(sample.direction).unwrap();
            // directions are rounded on the way to the world: 4 units of it over the cosine and the lobe's width. The
            // half vector of refraction, known + η other, moves by 1 + η of that and may be as short as η − 1
            let refraction = if model.eta == 1.0 { 1.0 } else { (1.0 + model.eta) / (1.0 - model.eta).abs() };
            let tolerance = 16.0 * f32::EPSILON * refraction / (cos * 0.1);
            let ratio = sample.weight[1] * pdf.value() / back.f_cos[1];
            assert!((ratio - 1.0).abs() < tolerance, "{} {mode:?}: {ratio}", model.name);
            assert!((back.pdf.value() / pdf.value() - 1.0).abs() < tolerance, "{} {mode:?}", model.name);
        }
    }
}

#[test]
fn a_mirror_keeps_radiance_toward_the_light_and_flux_toward_the_camera() {
    let point = tilted();
    let surface =
        Surface::Conductor(Conductor { ggx: Ggx::new(0.0), fresnel: Fresnel::Constant(Spectrum::splat(0.5)) });
    let known = Vec3::new(0.5, -0.3, 1.0).normalize();
    for mode in [TransportMode::Radiance, TransportMode::Importance] {
        let walk = Shading::new(&point, &surface, known, mode).unwrap();
        let sample = walk.sample([0.5; 3]).unwrap();
        let cos = |w: Vec3, n: Vec3| w.dot(n).abs();
        let (ns, ng) = (point.frame.n, point.ng);
        let adjoint = cos(known, ns) * cos(sample.direction, ng) / (cos(known, ng) * cos(sample.direction, ns));
        let expected = 0.5 * if mode == TransportMode::Radiance { 1.0 } else { adjoint };
        assert!((sample.weight[0] / expected - 1.0).abs() < ROUNDING);
        assert!(sample.density == Density::Delta(1.0) && surface.lobes() == Lobes::DIRAC_REFLECT);
    }
}

/// Points whose normals differ by up to 75 degrees.
fn bent(random: &mut Random) -> SurfacePoint {
    let ng = world(random.cube());
    let ns = loop {
        let ns = world(random.cube());
        if ns.dot(ng) > 0.25 {
            break ns;
        }
    };
    point(ng, ns)
}

fn weight_over_index(sample: &etendue::bsdf::ShadingSample) -> f64 {
    // radiance is scaled by the square of the index and scaled back where it leaves
    f64::from(sample.weight[1] * sample.eta * sample.eta)
}

#[test]
fn lossless_surfaces_conserve_energy_between_the_normals() {
    let ggx = Ggx::new(0.0);
    let glass = Dielectric { ggx, eta: 1.5, reflect: Spectrum::ONE, transmit: Spectrum::ONE };
    let lossless = [
        Surface::Conductor(Conductor { ggx, fresnel: Fresnel::Constant(Spectrum::ONE) }),
        Surface::Dielectric(glass),
        Surface::Lambert(Lambert { albedo: Spectrum::ONE }),
    ];
    let mut random = Random::new(24);
    for surface in &lossless {
        for _ in 0..samples(4000) {
            let (point, known) = (bent(&mut random), world(random.cube()));
            let walk = Shading::new(&point, surface, known, TransportMode::Radiance).unwrap();
            let sample = walk.sample(random.cube()).unwrap();
            // every weight is one: no variance; a folded direction's is of two values over two densities
            let off = (weight_over_index(&sample) - 1.0).abs();
            assert!(off < f64::from(ROUNDING), "{surface:?}: {off}");
        }
    }
}

/// The albedo of rough surfaces for a bent normal is that of a straight one: the mean of weights is, whatever the
/// normals.
#[test]
fn rough_metal_reflects_as_much_where_normals_differ() {
    let surface = Surface::Conductor(Conductor { ggx: Ggx::new(0.3), fresnel: Fresnel::Constant(Spectrum::ONE) });
    let (mut random, n) = (Random::new(25), samples(20_000));
    let ng = Vec3::Z;
    for (tilt, angle) in [(0.3f32, 0.5f32), (0.9, 1.2), (1.1, -1.4)] {
        let ns = Vec3::new(tilt.sin(), 0.0, tilt.cos());
        let known = Vec3::new(angle.sin(), 0.0, angle.cos());
        let [bent, flat] = [point(ng, ns), point(ns, ns)];
        let seen = if known.dot(ns) > 0.0 { known } else { known - ns * (2.0 * known.dot(ns)) };
        let mean = |point: &SurfacePoint, known: Vec3, random: &mut Random| {
            let walk = Shading::new(point, &surface, known, TransportMode::Radiance).unwrap();
            let sum: f64 = (0..n).map(|_| walk.sample(random.cube()).map_or(0.0, |s| f64::from(s.weight[1]))).sum();
            sum / f64::from(n)
        };
        let (a, b) = (mean(&bent, known, &mut random), mean(&flat, seen, &mut random));
        // weights of visible normals are within 0 and 1 and so their means' deviation within 1 / 2 √n each: five of
        // them
        let bound = 5.0 * 0.5 * (2.0 / f64::from(n)).sqrt();
        assert!((a - b).abs() < bound, "tilt {tilt} angle {angle}: {a} and {b}");
    }
}

#[test]
fn adjoint_consistency_over_shading_normal_tilts() {
    let mut random = Random::new(26);
    let mut folded = 0;
    for model in [0.3, 0.6].into_iter().flat_map(models) {
        for _ in 0..samples(400) {
            let (point, wi, wo) = (bent(&mut random), world(random.cube()), world(random.cube()));
            let camera_walk = Shading::new(&point, &model.surface, wo, TransportMode::Radiance).unwrap();
            let Some(light_walk) = Shading::new(&point, &model.surface, wi, TransportMode::Importance) else {
                assert!(camera_walk.f(wi).is_black());
                continue;
            };
            folded += u32::from(wo.dot(point.ng) * wo.dot(point.frame.n) < 0.0);
            let f = camera_walk.f(wi);
            assert!(close(f, light_walk.f(wo)), "{}: {f:?} {:?}", model.name, light_walk.f(wo));
            let [a, b] = [(&camera_walk, wi), (&light_walk, wo)];
            for (walk, w) in [a, b] {
                let f_cos = walk.scattering(w).map_or(Spectrum::ZERO, |s| s.f_cos);
                assert!(close(f_cos, f * w.dot(point.ng).abs()), "{}", model.name);
            }
            // each walk's density is the other's reverse
            let pdfs = [camera_walk.scattering(wi), light_walk.scattering(wo)].map(|s| s.map(|s| s.pdf.value()));
            let back = [light_walk.reverse_pdf(wo), camera_walk.reverse_pdf(wi)].map(|pdf| pdf.value());
            for (pdf, back) in pdfs.into_iter().zip(back) {
                let Some(pdf) = pdf else { continue };
                assert!((pdf / back - 1.0).abs() < ROUNDING, "{}: {pdf} {back}", model.name);
            }
        }
    }
    assert!(folded > 0);
}

/// A Dirac sample of either walk is one that the other walk may take back, with the densities in each other's place.
#[test]
fn dirac_directions_are_reversible_over_shading_normal_tilts() {
    let (mut random, mut pairs) = (Random::new(27), 0);
    for model in models(0.0) {
        for i in 0..samples(1000) {
            let mode = [TransportMode::Radiance, TransportMode::Importance][i as usize % 2];
            let (point, known) = (bent(&mut random), world(random.cube()));
            let Some(walk) = Shading::new(&point, &model.surface, known, mode) else { continue };
            let Some(sample) = walk.sample(random.cube()) else { continue };
            let other = sample.direction;
            let cosines = [known, other].map(|w| w.dot(point.ng).abs().min(w.dot(point.frame.n).abs()));
            // a boundary between one rule and another, and the critical angle, are within roundings there
            if !sample.density.is_delta() || cosines.into_iter().any(|cos| cos < 0.05) {
                continue;
            }
            let there = walk.densities(&sample);
            let back = Shading::new(&point, &model.surface, other, mode.reversed()).expect("the way back");
            let wo = if mode == TransportMode::Radiance { known } else { other };
            let folds = etendue::bsdf::shading::folds(&point, &model.surface, wo, sample.lobe).expect("the component");
            let again = back.dirac(sample.lobe, folds).expect("the component");
            assert!(again.distance(known) < 1e-4, "{} {mode:?}: {known} {again}", model.name);
            assert!(there.into_iter().all(|density| density > 0.0), "{}: {there:?}", model.name);
            pairs += 1;
        }
    }
    assert!(pairs > 1000);
}
