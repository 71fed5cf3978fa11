//! Lights seen by mirrors, through glass and over polygons: irradiances known on paper (light-transport.md, section
//! 3.2).

use crate::lamps::{ground, reflected};
use crate::picture::{Picture, Shot, about, expect, render, scene, scene_under, verdict};
use etendue::accel::Backend;
use etendue::integrator::Method;
use etendue::light::EnvironmentMap;
use etendue::scene::description::{CameraDescription, Description, EnvironmentDescription, Projection, Volume};
use etendue::spectrum::Spectrum;
use etendue::texture::RadianceMap;
use etendue_testing::deep;
use etendue_testing::random::Random;
use etendue_testing::studio::{Ball, add, add_box, add_square, camera, glass, matte, metal, narrow, with_model};
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Roundings of positions and products of a sample.
const ROUNDING: f64 = 64.0 * f32::EPSILON as f64;

/// Irradiance at the origin on a plane of normal +y under a polygon of radiance 1 above it: ½ |Σ Θᵢ Γᵢ·n| over its
/// edges.
fn lambert(corners: &[DVec3]) -> f64 {
    let edge = |i: usize| {
        let (a, b) = (corners[i].normalize(), corners[(i + 1) % corners.len()].normalize());
        a.angle_between(b) * a.cross(b).normalize().y
    };
    0.5 * (0..corners.len()).map(edge).sum::<f64>().abs()
}

#[test]
fn lamberts_formula_gives_the_unit_square_its_value() {
    let square = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(x, z)| DVec3::new(x, 1.0, z));
    assert!((lambert(&square) - 0.752_275).abs() < 1e-6, "{}", lambert(&square)); // as many digits as are known
}

/// Any triangle above the horizon, near or far, seen from its front or its back.
#[test]
fn triangles_of_light_give_the_irradiance_of_lamberts_formula() {
    let (count, spp) = if deep() { (40, 4096) } else { (4, 512) };
    let mut random = Random::new(11);
    for i in 0..count {
        let size = 0.4 * (1.0 + f64::from(i % 4));
        let corner = |random: &mut Random| DVec3::from([(); 3].map(|()| size * (random.f64() - 0.5)));
        let centre = DVec3::new(random.f64() - 0.5, size + 0.2, random.f64() - 0.5);
        let corners: Vec<Vec3> = (0..3).map(|_| (centre + corner(&mut random)).as_vec3()).collect();
        let exact = lambert(&corners.iter().map(|c| c.as_dvec3()).collect::<Vec<_>>());
        let mut scene = ground(2.0);
        add(&mut scene, corners, vec![[0, 1, 2]], matte(0.0, 5.0));
        let scene = scene_under(Backend::AVAILABLE[i as usize % Backend::AVAILABLE.len()], scene);
        for method in [Method::Path, Method::PathNee] {
            let picture = render(&scene, Shot::new(method, 16, spp));
            // The patch's own extent, 1e-3 wide, moves its mean by as much squared over the distance's square.
            expect(
                &picture,
                about(reflected(5.0 * exact), 1e-5 + ROUNDING),
                0.05,
                &format!("triangle {i}, {method:?}"),
            );
        }
    }
}

/// A lamp beside a mirror shines as the lamp and its image behind the mirror, the image times the mirror's reflectance.
#[test]
fn a_plane_mirror_shows_the_image_of_the_lamp() {
    const MIRROR: f32 = 0.7;
    let lamp =
        |x: f64| [(-0.3, -0.3), (0.3, -0.3), (0.3, 0.3), (-0.3, 0.3)].map(|(u, v)| DVec3::new(x + u, 1.0 + 0.5 * u, v));
    let image = lamp(0.2).map(|p| DVec3::new(2.0 - p.x, p.y, p.z));
    let exact = lambert(&lamp(0.2)) + f64::from(MIRROR) * lambert(&image);
    for &backend in Backend::AVAILABLE {
        let mut scene = ground(0.01);
        add_square(&mut scene, Vec3::X, Vec3::Z * 20.0, Vec3::Y * 20.0, metal(MIRROR, 0.0));
        add(&mut scene, lamp(0.2).map(|p| p.as_vec3()).to_vec(), vec![[0, 1, 2], [0, 2, 3]], matte(0.0, 5.0));
        let scene = scene_under(backend, scene);
        for method in [Method::Path, Method::PathNee] {
            let picture =
                render(&scene, Shot { depth: Some(2), ..Shot::new(method, 16, if deep() { 8192 } else { 512 }) });
            let what = format!("plane mirror, {method:?}, {backend:?}");
            expect(&picture, about(reflected(5.0 * exact), 1e-5 + ROUNDING), 0.05, &what);
            // The test sees whether the image is there.
            assert!(verdict(&picture, about(reflected(5.0 * lambert(&lamp(0.2))), ROUNDING)).is_err(), "{what}");
        }
    }
}

/// A point light above a glass slab above a plane: heights of 0.5, 0.2, 0.5, index 1.5, intensity 1.
struct Slab;

impl Slab {
    const AIR: f64 = 1.0;
    const GLASS: f64 = 0.2;
    const INDEX: f64 = 1.5;

    /// Where the ray of angle θ lands.
    fn lands(theta: f64) -> f64 {
        Self::AIR * theta.tan() + Self::GLASS * (theta.sin() / Self::INDEX).asin().tan()
    }

    /// The angle of the ray that lands at `x`.
    fn angle(x: f64) -> f64 {
        let (mut low, mut high) = (0.0, 0.5 * PI);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if Self::lands(middle) < x { low = middle } else { high = middle }
        }
        low
    }

    /// Directly transmitted irradiance at `x`: the flux T sin θ dθ dφ over the ring x dx dφ, T by Fresnel's equations
    /// twice.
    fn irradiance(x: f64) -> f64 {
        const STEP: f64 = 1e-5; // differences are good to its square
        let theta = Self::angle(x);
        let (cos, inside) = (theta.cos(), (1.0 - (theta.sin() / Self::INDEX).powi(2)).sqrt());
        let s = (cos - Self::INDEX * inside) / (cos + Self::INDEX * inside);
        let p = (Self::INDEX * cos - inside) / (Self::INDEX * cos + inside);
        let through = 1.0 - 0.5 * (s * s + p * p);
        let dx = (Self::lands(theta + STEP) - Self::lands(theta - STEP)) / (2.0 * STEP);
        through * through * theta.sin() / (x * dx)
    }
}

#[test]
fn the_slabs_irradiances_are_those_of_the_table() {
    for (x, e) in [(0.1, 0.709_924), (0.5, 0.560_029), (1.0, 0.311_650), (2.0, 0.078_511_5)] {
        assert!((Slab::irradiance(x) / e - 1.0).abs() < 1e-5, "{x}: {} {e}", Slab::irradiance(x)); // as many digits as are known
    }
}

/// No method here finds a point light through glass, so light and camera are swapped: what a pinhole receives from a
/// small patch of radiance 1, ∫ L dω, is the patch's area times the irradiance that a point light of intensity 1 gives
/// it.
#[test]
fn a_patch_behind_a_glass_slab_is_as_bright_as_fresnel_and_snell_say() {
    const HALF: f64 = 0.01;
    const SIDE: usize = 32;
    for (i, x) in [0.1, 0.5, 1.0, 2.0].into_iter().enumerate() {
        let mut room = Description::default();
        let patch = Vec3::new(x as f32, 0.0, 0.0);
        add_square(&mut room, patch, Vec3::X * HALF as f32, Vec3::NEG_Z * HALF as f32, matte(0.0, 1.0));
        add_box(&mut room, Vec3::new(0.0, 0.6, 0.0), Vec3::new(20.0, 0.1, 20.0), glass(0.0));
        let (eye, theta) = (DVec3::Y * 1.2, Slab::angle(x));
        let view = 4.0 * HALF * theta.cos() / 1.2;
        room.cameras.push(narrow(camera(eye, eye + DVec3::new(theta.sin(), -theta.cos(), 0.0)), view));
        let room = scene_under(Backend::AVAILABLE[i % Backend::AVAILABLE.len()], room);
        let shot = Shot { depth: Some(2), ..Shot::new(Method::Path, SIDE as u32, if deep() { 4096 } else { 64 }) };
        let mut picture = render(&room, shot);
        // Film area becomes solid angle by cos³, the area's mean of the patch's irradiance by 5 × 5 points.
        let half = (0.5 * view).tan();
        let border = |i: usize| i / SIDE == 0 || i / SIDE == SIDE - 1 || i % SIDE == 0 || i % SIDE == SIDE - 1;
        for (i, (mean, variance)) in picture.mean.iter_mut().zip(&mut picture.variance).enumerate() {
            let at = |k: usize| half * ((2 * k + 1) as f64 / SIDE as f64 - 1.0);
            let (u, v) = (at(i / 3 % SIDE), at(i / 3 / SIDE));
            let weight = 4.0 * half * half * (1.0 + u * u + v * v).powf(-1.5);
            assert!(!border(i / 3) || *mean <= 0.0, "the whole patch is in view");
            *mean *= weight;
            *variance *= weight * weight;
        }
        let steps = [-0.8, -0.4, 0.0, 0.4, 0.8].map(|t| t * HALF);
        let mean = steps.iter().flat_map(|dx| steps.map(|dz| Slab::irradiance((x + dx).hypot(dz)))).sum::<f64>() / 25.0;
        let expected = mean * (2.0 * HALF).powi(2);
        // The points' rule and the weights' change within a pixel are off by the square of a tenth of the patch over x.
        expect(&picture, about(expected, 1e-4 + ROUNDING), 0.02, &format!("slab, x {x}"));
    }
}

/// A mirror ball scatters parallel rays evenly in all directions: seen by parallel rays it shows the mean of what
/// surrounds it.
#[test]
fn a_mirror_ball_scatters_parallel_rays_in_every_direction_alike() {
    let (reflectance, side) = (0.9f32, 32);
    let texel = |i: u32| {
        let (azimuth, polar) = (TAU * (f64::from(i % 32) + 0.5) / 32.0, PI * (f64::from(i / 32) + 0.5) / 16.0);
        [(2.0 + polar.sin() * azimuth.cos() + 0.7 * polar.cos()) as f32; 3]
    };
    let map = Arc::new(RadianceMap::new(32, 16, (0..32 * 16).map(texel).collect()));
    let light = EnvironmentMap::new(Arc::clone(&map), 1.0, 0.0).expect("light");
    let radiance = |w: DVec3| f64::from(light.along(w.as_vec3()).0.mean());
    let backward = DVec3::new(0.3, 0.5, 0.8).normalize();
    // The polyhedron's own sum over its facets, and the claim for the sphere.
    let ball = Ball::new(5, 1.0);
    let (mut area, mut sum) = (0.0, 0.0);
    for t in &ball.triangles {
        let [a, b, c] = t.map(|i| ball.positions[i as usize].as_dvec3());
        let scaled = (b - a).cross(c - a) * 0.5;
        let (facing, n) = (scaled.dot(backward).max(0.0), scaled.normalize());
        area += facing;
        sum += facing * radiance(2.0 * n.dot(backward) * n - backward);
    }
    let everywhere = (0..400 * 200)
        .map(|i| (TAU * (f64::from(i % 400) + 0.5) / 400.0, 1.0 - (f64::from(i / 400) + 0.5) / 100.0))
        .map(|(phi, y)| radiance(DVec3::new((1.0 - y * y).sqrt() * phi.cos(), y, (1.0 - y * y).sqrt() * phi.sin())))
        .sum::<f64>()
        / f64::from(400 * 200);
    assert!((sum / area / everywhere - 1.0).abs() < 2e-3, "{} {everywhere}", sum / area); // facets are 3 degrees wide
    let share = area / 4.0;
    let expected = share * f64::from(reflectance) * everywhere + (1.0 - share) * radiance(-backward);
    let mut room = Description {
        environment: Some(EnvironmentDescription::Map { map, scale: 1.0, rotation: 0.0 }),
        ..Description::default()
    };
    ball.add(&mut room, DVec3::ZERO, metal(reflectance, 0.0));
    let projection = Projection::Orthographic { xmag: 1.0, ymag: 1.0 };
    room.cameras.push(CameraDescription { projection, ..camera(backward * 3.0, DVec3::ZERO) });
    let picture = render(&scene(room), Shot::new(Method::Path, side, 64));
    expect(&picture, about(expected, 2e-3), 0.01, "mirror ball"); // see above
}

/// Straight through coloured glass: colour^(thickness / attenuation distance), without reflection at index 1, and with
/// two faces of ((n − 1) / (n + 1))² at index 1.5, whatever unit the file is in.
#[test]
fn coloured_glass_absorbs_by_its_thickness() {
    for (index, scale) in [(1.0, 1.0), (1.5, 1.0), (1.5, 100.0)] {
        let colour = [0.9f32, 0.5, 0.2];
        let volume = Some(Volume::absorbing(0.25 * scale, Spectrum(colour)));
        let mut room = Description::default();
        let size = scale as f32;
        add_square(&mut room, Vec3::Z * -size, Vec3::X * size, Vec3::Y * size, matte(0.0, 1.0));
        add_box(
            &mut room,
            Vec3::ZERO,
            Vec3::new(0.8, 0.8, 0.2) * size,
            with_model(glass(0.0), |m| {
                m.ior = index;
                m.volume = volume;
            }),
        );
        let projection = Projection::Orthographic { xmag: 0.5 * scale, ymag: 0.5 * scale };
        room.cameras.push(CameraDescription { projection, ..camera(DVec3::Z * scale, DVec3::ZERO) });
        let shot = Shot { depth: Some(2), ..Shot::new(Method::Path, 16, if deep() { 4096 } else { 64 }) };
        let picture = render(&scene(room), shot);
        let faces = 1.0 - ((f64::from(index) - 1.0) / (f64::from(index) + 1.0)).powi(2);
        for (lane, colour) in colour.into_iter().enumerate() {
            let every = |values: &[f64]| values.iter().skip(lane).step_by(3).flat_map(|&v| [v; 3]).collect();
            let one = Picture { mean: every(&picture.mean), variance: every(&picture.variance), ..picture };
            let expected = faces * faces * f64::from(colour).powf(0.4 / 0.25);
            // Three lanes that are copies: a third of the variance is missing.
            let one = Picture { variance: one.variance.iter().map(|v| 3.0 * v).collect(), ..one };
            // A ray in glass begins beyond the face by the face's error: lengths are rounded, and the exponent
            // multiplies that.
            let slack = ROUNDING * (1.0 - expected.ln());
            expect(&one, about(expected, slack), 0.03, &format!("lane {lane}, index {index}, scale {scale}"));
        }
    }
}
