//! Lamps of known irradiance on a small matte patch: spheres, specks, the sun.

use crate::picture::{Shot, about, expect, render, scene_under};
use etendue::accel::Backend;
use etendue::integrator::Method;
use etendue::scene::description::Description;
use etendue_testing::deep;
use etendue_testing::studio::{Ball, add, add_square, camera, matte, narrow};
use glam::{DVec3, Vec3};
use std::f64::consts::{FRAC_1_PI, PI, TAU};

const REFLECTANCE: f32 = 0.5;

/// Roundings of positions and products of a sample.
pub(crate) const ROUNDING: f64 = 64.0 * f32::EPSILON as f64;

/// A plane of half side `half` through the origin, facing up, and a camera that looks at so small a part around the
/// origin that irradiance is constant there to second order in 1e-3.
pub(crate) fn ground(half: f32) -> Description {
    let mut scene = Description::default();
    add_square(&mut scene, Vec3::ZERO, Vec3::X * half, Vec3::NEG_Z * half, matte(REFLECTANCE, 0.0));
    scene.cameras.push(narrow(camera(DVec3::new(0.2, 0.4, 0.1), DVec3::ZERO), 1e-3));
    scene
}

/// Radiance of the ground under `irradiance`.
pub(crate) fn reflected(irradiance: f64) -> f64 {
    f64::from(REFLECTANCE) * FRAC_1_PI * irradiance
}

/// The range by a lamp between an inscribed and a circumscribed one.
fn between(irradiances: [f64; 2]) -> [f64; 2] {
    let [low, high] = irradiances.map(reflected);
    [low * (1.0 - ROUNDING), high * (1.0 + ROUNDING)]
}

/// π L (R / d)² cos for a ball above the horizon; a polyhedron lies between its inner and its outer sphere, and more
/// lamp is more light.
#[test]
fn a_sphere_gives_the_irradiance_of_its_disk() {
    let (levels, spp) = if deep() { (7, 8192) } else { (5, 256) };
    let (radius, centre) = (0.3, DVec3::new(0.5, 1.0, -0.3));
    let (d2, cos) = (centre.length_squared(), centre.y / centre.length());
    for &backend in Backend::AVAILABLE {
        for method in [Method::Path, Method::PathNee] {
            let mut scene = ground(2.0);
            let lamp = Ball::new(levels, radius);
            let range = between([lamp.inner_radius(), f64::from(radius)].map(|r| PI * 5.0 * r * r / d2 * cos));
            lamp.add(&mut scene, centre, matte(0.0, 5.0));
            let picture = render(&scene_under(backend, scene), Shot::new(method, 16, spp));
            expect(
                &picture,
                range,
                if deep() { 5e-3 } else { 0.05 },
                &format!("sphere light, {method:?}, {backend:?}"),
            );
        }
    }
}

/// A speck of 1e-6 of the scene is a point: L A cos cos / d². Wrong by its size squared, 1e-12.
#[test]
fn a_speck_of_a_millionth_is_a_point_light() {
    const HALF: f64 = 1e-6;
    let (x, y) = (0.6, 0.8);
    for &backend in Backend::AVAILABLE {
        for method in [Method::Path, Method::PathNee] {
            let mut scene = ground(1.0);
            let half = HALF as f32;
            add_square(&mut scene, Vec3::ZERO, Vec3::X * half, Vec3::Z * half, matte(0.0, 1e12));
            scene.instances[1].transform = glam::DAffine3::from_translation(DVec3::new(x, y, 0.0));
            let irradiance = f64::from(1e12f32) * (2.0 * HALF).powi(2) * y * y; // d is 1, both cosines are y
            let picture = render(&scene_under(backend, scene), Shot::new(method, 8, 16));
            // The patch's own extent, 1e-3 wide, moves its mean by as much squared.
            expect(
                &picture,
                about(reflected(irradiance), 1e-6 + ROUNDING),
                1e-4,
                &format!("speck, {method:?}, {backend:?}"),
            );
        }
    }
}

/// Distance of the sun in units of the things that it shines on.
pub(crate) const FAR: f64 = 1e8;

/// A disk of `sides` corners that looks 0.53 degrees wide at `distance` along `toward`, and faces the origin.
pub(crate) fn add_sun(scene: &mut Description, toward: DVec3, distance: f64, sides: u32, radiance: f32) {
    let n = toward.normalize();
    let s = n.any_orthonormal_vector();
    let t = n.cross(s);
    let radius = distance * HALF_ANGLE_DEGREES.to_radians().tan();
    let corner = |i: u32| {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(sides)).sin_cos();
        ((s * cos + t * sin) * radius).as_vec3()
    };
    let mut positions = vec![Vec3::ZERO];
    positions.extend((0..sides).map(corner));
    let triangles = (0..sides).map(|i| [0, 1 + (i + 1) % sides, 1 + i]).collect();
    add(scene, positions, triangles, matte(0.0, radiance));
    scene.instances.last_mut().expect("just added").transform = glam::DAffine3::from_translation(n * distance);
}

/// Half of the sun's width in the sky.
const HALF_ANGLE_DEGREES: f64 = 0.265;

/// π L sin² cos: the irradiance of a cone of directions above the horizon. The polygon lies between its inner and its
/// outer circle, whose tangents' ratio is the cosine of half a side's angle.
#[test]
fn a_sun_at_1e8_gives_the_irradiance_of_its_cone() {
    const SIDES: u32 = 256;
    let toward = DVec3::new(0.5, 1.0, -0.7);
    let cos = toward.y / toward.length();
    let tan = HALF_ANGLE_DEGREES.to_radians().tan();
    let sine2 = |tan: f64| tan * tan / (1.0 + tan * tan);
    let range = between([(PI / f64::from(SIDES)).cos(), 1.0].map(|c| PI * 4e4 * sine2(tan * c) * cos));
    for &backend in Backend::AVAILABLE {
        for method in [Method::Path, Method::PathNee] {
            let mut scene = ground(5.0);
            add_sun(&mut scene, toward, FAR, SIDES, 4e4);
            let picture = render(&scene_under(backend, scene), Shot::new(method, 16, 64));
            expect(&picture, range, 2e-3, &format!("sun, {method:?}, {backend:?}"));
        }
    }
}
