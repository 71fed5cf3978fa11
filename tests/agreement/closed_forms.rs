//! Scenes whose radiance has a closed form.

use crate::picture::{LEVEL, Picture, Shot, agree, limit, render, scene};
use etendue::integrator::Method;
use etendue::sampling::SamplerKind;
use etendue::scene::Scene;
use etendue::scene::description::{AlphaMode, Description, Material};
use etendue_testing::studio::{self, add_room, add_square, camera, matte, point_light};
use glam::{DVec3, Vec3, Vec4};

const METHODS: [Method; 3] = [Method::PathNaive, Method::PathNee, Method::Path];

/// Without next-event estimation alone: in a corner of emitting walls its variance, ∫ (cos cos / d²)², is infinite, and
/// then no standard error means anything.
const OF_FINITE_VARIANCE_IN_CORNERS: [Method; 2] = [Method::PathNaive, Method::Path];

/// A closed room that emits `emission` and reflects `reflectance` everywhere: radiance is emission / (1 − reflectance).
fn furnace(reflectance: f32, emission: f32) -> Scene {
    let mut room = Description::default();
    add_room(&mut room, &matte(reflectance, emission));
    room.cameras.push(camera(DVec3::new(0.3, -0.2, 0.5), DVec3::new(-1.0, 0.4, 0.1)));
    scene(room)
}

/// The image mean against `expected`, at [`LEVEL`].
fn expect_mean(picture: &Picture, expected: f64, what: &str) {
    let mean = picture.overall();
    let z = (mean.mean - expected) / mean.variance.sqrt();
    assert!(z.abs() <= limit(1), "{what}: {} instead of {expected}, z {z:.2} (level {LEVEL})", mean.mean);
    // The test has power: it would see an error of one part in a hundred.
    assert!(expected * 0.01 / mean.variance.sqrt() > limit(1), "{what}: too noisy, {}", mean.variance.sqrt());
}

#[test]
fn a_closed_room_of_one_material_is_uniformly_bright() {
    let room = furnace(0.5, 0.5);
    for method in OF_FINITE_VARIANCE_IN_CORNERS {
        for sampler in [SamplerKind::Independent, SamplerKind::Sobol] {
            let picture = render(&room, Shot { sampler, ..Shot::new(method, 16, 128) });
            expect_mean(&picture, 1.0, &format!("{method:?} {sampler:?}"));
        }
    }
}

/// A quarter of the paths of a room that reflects 99 % is longer than the events after which roulette goes by depth,
/// and they carry a twelfth of its light.
#[test]
fn russian_roulette_is_unbiased() {
    let picture = render(&furnace(0.99, 0.01), Shot::new(Method::Path, 16, 64));
    let mean = picture.overall();
    let error = mean.variance.sqrt();
    assert!((mean.mean - 1.0).abs() <= limit(1) * error, "{} ± {error}", mean.mean);
    assert!(0.04 > limit(1) * error, "4 % less would not be seen: {error}");
}

#[test]
fn depth_counts_scattering_events() {
    // Emission plus n reflections of it: 0.5 (1 + 1/2 + … + 2⁻ⁿ).
    let room = furnace(0.5, 0.5);
    for (depth, expected) in [(0, 0.5), (1, 0.75), (2, 0.875), (3, 0.9375)] {
        for method in OF_FINITE_VARIANCE_IN_CORNERS {
            let picture = render(&room, Shot { depth: Some(depth), ..Shot::new(method, 16, 64) });
            if depth == 0 {
                assert!(picture.mean.iter().all(|&m| (m - 0.5).abs() < 1e-6), "{method:?}"); // film quantum
            } else {
                expect_mean(&picture, expected, &format!("{method:?} depth {depth}"));
            }
        }
    }
}

/// A small patch under a unit square light in distance 1: irradiance 0.752275 L (light-transport.md, section 3.2).
#[test]
fn a_square_light_gives_the_irradiance_of_lamberts_formula() {
    let mut room = Description::default();
    add_square(&mut room, Vec3::ZERO, Vec3::X * 0.01, Vec3::NEG_Z * 0.01, matte(0.8, 0.0));
    add_square(&mut room, Vec3::Y, Vec3::X * 0.5, Vec3::Z * 0.5, matte(0.0, 2.0));
    room.cameras.push(camera(DVec3::new(0.02, 0.01, 0.0), DVec3::ZERO));
    let mut close = room.cameras[0].clone();
    close.projection = etendue::scene::description::Projection::Perspective { yfov: 0.05, aspect: None };
    room.cameras[0] = close;
    let room = scene(room);
    let expected = 0.8 / std::f64::consts::PI * 0.752_275 * 2.0;
    for method in METHODS {
        expect_mean(&render(&room, Shot::new(method, 16, 1024)), expected, &format!("{method:?}"));
    }
}

/// Point light of intensity I at height h above a plane: radiance ρ I cos³ / (π h²) by the angle at the foot.
#[test]
fn a_point_light_falls_off_with_the_square_of_the_distance() {
    let mut room = Description::default();
    add_square(&mut room, Vec3::ZERO, Vec3::X * 5.0, Vec3::NEG_Z * 5.0, matte(0.5, 0.0));
    room.lights.push(point_light(DVec3::new(0.0, 2.0, 0.0), 3.0));
    room.cameras.push(camera(DVec3::new(2.0, 1.0, 0.0), DVec3::new(1.5, 0.0, 0.0)));
    let mut narrow = room.cameras[0].clone();
    narrow.projection = etendue::scene::description::Projection::Perspective { yfov: 1e-3, aspect: None }; // one point
    room.cameras[0] = narrow;
    let room = scene(room);
    let cos = 2.0 / 2.5;
    let expected = 0.5 * 3.0 * cos * cos * cos / (std::f64::consts::PI * 4.0);
    for method in [Method::PathNee, Method::Path] {
        let picture = render(&room, Shot::new(method, 16, 4));
        // No randomness but the position in a pixel 1e-3 rad / 16 wide; the mean's error is second order in it, and
        // positions and products are f32.
        assert!((picture.overall().mean / expected - 1.0).abs() < 1e-5, "{method:?} {}", picture.overall().mean); // see above
    }
}

/// A lossless glass body in a furnace of radiance B shows B: reflected and refracted shares add up, η² cancels on the
/// way out.
#[test]
fn glass_is_invisible_in_a_white_furnace() {
    let mut room = Description::default();
    add_room(&mut room, &matte(0.5, 0.5));
    let mut glass = Description::default();
    add_room(&mut glass, &studio::glass(0.0));
    for (i, instance) in glass.instances.iter_mut().enumerate() {
        instance.transform = glam::DAffine3::from_scale(DVec3::splat(0.4));
        instance.mesh = room.meshes.len() + i;
    }
    for mesh in glass.meshes.drain(..) {
        let mut mesh = mesh;
        mesh.primitives[0].material += 6;
        // The room's walls face inward; a body's surface faces outward.
        mesh.primitives[0].triangles.iter_mut().for_each(|t| t.swap(1, 2));
        room.meshes.push(mesh);
    }
    room.instances.append(&mut glass.instances);
    room.materials.append(&mut glass.materials);
    room.cameras.push(camera(DVec3::new(0.1, 0.2, 0.95), DVec3::new(0.0, 0.0, 0.0)));
    let room = scene(room);
    expect_mean(&render(&room, Shot::new(Method::Path, 16, 64)), 1.0, "path");
}

/// Light through holes: a lamp whose alpha leaves half of it and a half-transparent screen before it. Three methods
/// that find the lamp in different ways see one picture.
#[test]
fn alpha_blending_agrees_between_methods() {
    for mode in [AlphaMode::Blend, AlphaMode::Mask { cutoff: 0.5 }] {
        let mut room = Description::default();
        add_square(&mut room, Vec3::ZERO, Vec3::X * 2.0, Vec3::NEG_Z * 2.0, matte(0.7, 0.0));
        let lamp = Material { alpha_mode: mode, ..matte(0.3, 4.0) };
        add_square(&mut room, Vec3::Y, Vec3::X * 0.5, Vec3::Z * 0.5, lamp);
        let colors = [0.0, 1.0, 1.0, 0.0].map(|alpha| Vec4::new(1.0, 1.0, 1.0, alpha)); // alpha runs along x
        room.meshes[1].primitives[0].colors = Some(colors.to_vec());
        let screen = Material { alpha: 0.4, alpha_mode: AlphaMode::Blend, ..matte(0.8, 0.0) };
        add_square(&mut room, Vec3::new(0.3, 0.5, 0.0), Vec3::X * 0.4, Vec3::NEG_Z * 0.6, screen);
        room.cameras.push(camera(DVec3::new(0.5, 0.8, 2.5), DVec3::new(0.0, 0.3, 0.0)));
        let room = scene(room);
        assert!(room.features().blends);
        let [naive, nee, path] =
            METHODS.map(|m| render(&room, Shot::new(m, 32, if m == Method::PathNaive { 512 } else { 64 })));
        agree(&path, &nee, 4).unwrap_or_else(|e| panic!("{mode:?}, path and path-nee: {e}"));
        agree(&path, &naive, 4).unwrap_or_else(|e| panic!("{mode:?}, path and path-naive: {e}"));
    }
}

/// The tests above convict a renderer that is wrong by two per cent.
#[test]
fn a_planted_error_of_two_per_cent_is_convicted() {
    let room = furnace(0.5, 0.5);
    let [a, b] = [1, 2].map(|seed| render(&room, Shot { seed, ..Shot::new(Method::Path, 32, 64) }));
    assert!(agree(&a, &b, 4).is_ok());
    assert!(agree(&a, &b.times(1.02), 4).is_err());
}
