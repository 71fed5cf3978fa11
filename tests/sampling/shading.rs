//! The one place with two normals.

use crate::models::{any_direction, models};
use crate::random::{Random, samples};
use etendue::bsdf::{Bsdf, Conductor, Fresnel, Ggx, Lambert, Lobes, Shading, Surface};
use etendue::geometry::{Frame, Hit, SurfacePoint};
use etendue::sampling::Density;
use etendue::spectrum::Spectrum;
use etendue::transport::Transport;
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
fn both_walks_see_one_scattering_function() {
    let (point, mut random) = (tilted(), Random::new(21));
    for model in [0.05, 0.3].into_iter().flat_map(models) {
        for _ in 0..samples(200) {
            let (wi, wo) = (world(random.cube()), world(random.cube()));
            let camera_walk = Shading::new(&point, &model.surface, wo, Transport::Light);
            let light_walk = Shading::new(&point, &model.surface, wi, Transport::Camera);
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
    let walk = Shading::new(&point, &surface, up, Transport::Light).unwrap();
    for _ in 0..samples(2000) {
        let w = world(random.cube());
        let sides = [w.dot(point.ng) > 0.0, w.dot(point.frame.n) > 0.0];
        if sides[0] != sides[1] {
            between += 1;
            assert!(walk.f(w).is_black() && walk.scattering(w).is_none());
            assert!(Shading::new(&point, &surface, w, Transport::Light).is_none());
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
            let toward = [Transport::Light, Transport::Camera][i as usize % 2];
            let Some(walk) = Shading::new(&point, &model.surface, world(random.cube()), toward) else { continue };
            let Some(sample) = walk.sample(random.cube()) else { continue };
            let Density::Smooth(pdf) = sample.density else { continue };
            let cos = (point.frame.to_local(sample.direction).z * point.frame.to_local(walk.known()).z).abs();
            if cos < 1e-2 {
                continue; // a world direction's rounding is not small against a grazing cosine
            }
            let back = walk.scattering(sample.direction).unwrap();
            // directions are rounded on the way to the world: 4 units of it over the cosine and the lobe's width. The half vector
            // of refraction, known + η other, moves by 1 + η of that and may be as short as η − 1
            let refraction = if model.eta == 1.0 { 1.0 } else { (1.0 + model.eta) / (1.0 - model.eta).abs() };
            let tolerance = 16.0 * f32::EPSILON * refraction / (cos * 0.1);
            let ratio = sample.weight[1] * pdf.value() / back.f_cos[1];
            assert!((ratio - 1.0).abs() < tolerance, "{} {toward:?}: {ratio}", model.name);
            assert!((back.pdf.value() / pdf.value() - 1.0).abs() < tolerance, "{} {toward:?}", model.name);
        }
    }
}

#[test]
fn a_mirror_keeps_radiance_toward_the_light_and_flux_toward_the_camera() {
    let point = tilted();
    let surface = Surface::Conductor(Conductor { ggx: Ggx::new(0.0), fresnel: Fresnel::Constant(Spectrum::splat(0.5)) });
    let known = Vec3::new(0.5, -0.3, 1.0).normalize();
    for toward in [Transport::Light, Transport::Camera] {
        let walk = Shading::new(&point, &surface, known, toward).unwrap();
        let sample = walk.sample([0.5; 3]).unwrap();
        let cos = |w: Vec3, n: Vec3| w.dot(n).abs();
        let (ns, ng) = (point.frame.n, point.ng);
        let adjoint = cos(known, ns) * cos(sample.direction, ng) / (cos(known, ng) * cos(sample.direction, ns));
        let expected = 0.5 * if toward == Transport::Light { 1.0 } else { adjoint };
        assert!((sample.weight[0] / expected - 1.0).abs() < ROUNDING);
        assert!(sample.density == Density::Delta(1.0) && surface.lobes() == Lobes::DIRAC_REFLECT);
    }
}
