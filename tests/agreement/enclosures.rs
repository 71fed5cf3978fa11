//! Closed rooms: what leaves a wall comes back, so that radiance is known exactly.

use crate::picture::{Shot, about, expect, render, scene, scene_under};
use etendue::accel::Backend;
use etendue::integrator::Method;
use etendue::scene::description::{Description, Material};
use etendue_testing::deep;
use etendue_testing::studio::{Ball, add_room, add_square, camera, glass, matte, metal, narrow, point_light};
use glam::{DVec3, Vec3};

/// Roundings of throughputs and film of one sample, a few dozen.
const ROUNDING: f64 = 64.0 * f32::EPSILON as f64;

/// A look around from beside the middle.
fn inside(mut room: Description) -> Description {
    room.cameras.push(camera(DVec3::new(0.05, -0.02, 0.03), DVec3::new(0.3, 0.2, -1.0)));
    room
}

fn ball(levels: u32, material: Material) -> Description {
    let mut room = Description::default();
    Ball::new(levels, 1.0).add(&mut room, DVec3::ZERO, material);
    inside(room)
}

/// Le / (1 − ρ) whatever the shape is, so that the tessellation is no error. Deep: to 1e-4.
#[test]
fn a_sphere_that_emits_is_uniformly_bright() {
    let (side, spp, planted) = if deep() { (64, 8192, 1e-4) } else { (32, 256, 0.01) };
    let backends = if deep() { &Backend::AVAILABLE[..1] } else { Backend::AVAILABLE };
    for &backend in backends {
        let room = scene_under(backend, ball(3, matte(0.5, 0.5)));
        let picture = render(&room, Shot::new(Method::Path, side, spp));
        expect(&picture, about(1.0, ROUNDING), planted, &format!("emitting sphere, {backend:?}"));
    }
}

/// ρ I / (π R² (1 − ρ)), with R² = A / 4π for the polyhedron's area A: in a closed diffuse room the mean over the walls
/// of radiance is 4 ρ I / (A (1 − ρ)) exactly. At a point whose plane has the distance h, in the distance r, irradiance
/// is I h / r³ with h ≤ r ≤ 1: everywhere within h⁻³ of the mean, direct and reflected. Deep: to 1e-4 of the sphere's
/// value.
#[test]
fn a_sphere_around_a_point_light_is_uniformly_bright() {
    let (levels, side, spp) = if deep() { (8, 64, 4096) } else { (5, 32, 64) };
    let intensity = std::f32::consts::PI;
    let walls = Ball::new(levels, 1.0);
    let expected = 4.0 * 0.5 * f64::from(intensity) / (walls.area() * 0.5);
    let tessellation = walls.inner_radius().powi(-3) - 1.0;
    for method in [Method::Path, Method::PathNee] {
        let mut room = ball(levels, matte(0.5, 0.0));
        room.lights.push(point_light(DVec3::ZERO, intensity));
        let picture = render(&scene(room), Shot::new(method, side, spp));
        let what = format!("{method:?} in a polyhedron within {tessellation:.1e} of its sphere");
        expect(&picture, about(expected, tessellation + ROUNDING), 2.0 * tessellation + 1e-3, &what);
        if deep() {
            assert!((picture.overall().mean - 1.0).abs() < 1e-4, "{what}: {}", picture.overall().mean); // the figure
        }
    }
}

/// Two infinite planes, which four perfect mirrors make of a floor and a ceiling: B₁ = (E₁ + ρ₁ E₂) / (1 − ρ₁ ρ₂).
#[test]
fn parallel_planes_exchange_light() {
    let (spp, planted) = if deep() { (8192, 2e-3) } else { (256, 0.02) };
    let mut room = Description::default();
    add_room(&mut room, &metal(1.0, 0.0));
    // the room's third and fourth walls are those of the second axis, bottom and top
    (room.materials[2], room.materials[3]) = (matte(0.7, 1.0), matte(0.2, 3.0));
    let eye = DVec3::new(0.1, 0.0, 0.2);
    room.cameras.push(narrow(camera(eye, DVec3::new(0.15, -1.0, 0.1)), 0.3));
    let room = scene(room);
    let expected = (1.0 + 0.7 * 3.0) / (1.0 - 0.7 * 0.2);
    for method in [Method::Path, Method::PathNee] {
        let picture = render(&room, Shot::new(method, 32, spp));
        expect(&picture, about(expected, ROUNDING), planted, &format!("parallel planes, {method:?}"));
    }
}

/// Walls of any reflectance ρ that emit 1 − ρ, and a mirror and a glass ball that emit nothing: radiance is 1
/// everywhere (Kirchhoff).
#[test]
fn room_in_thermal_equilibrium_is_uniform() {
    for &backend in Backend::AVAILABLE {
        let mut room = Description::default();
        add_room(&mut room, &matte(0.5, 0.5));
        for (wall, reflectance) in room.materials.iter_mut().zip([0.0, 0.1, 0.3, 0.5, 0.7, 0.9]) {
            *wall = matte(reflectance, 1.0 - reflectance);
        }
        Ball::new(3, 0.3).add(&mut room, DVec3::new(0.3, 0.4, -0.5), metal(1.0, 0.0));
        Ball::new(3, 0.3).add(&mut room, DVec3::new(-0.4, -0.3, -0.5), glass(0.0));
        let room = scene_under(backend, inside(room));
        let picture = render(&room, Shot::new(Method::Path, 32, if deep() { 4096 } else { 256 }));
        expect(&picture, about(1.0, ROUNDING), if deep() { 2e-3 } else { 0.02 }, &format!("equilibrium, {backend:?}"));
    }
}

/// Radiance over the square of the index is what stays: a camera inside glass of index 1.5 in a room of radiance 1 sees
/// 1.5². From near the middle of a ball no ray is totally reflected; rough faces lose α² at such angles.
#[test]
fn a_camera_inside_glass_sees_radiance_times_the_square_of_the_index() {
    let spp = if deep() { 4096 } else { 256 };
    for &backend in Backend::AVAILABLE {
        for roughness in [0.0, 0.01f32] {
            let mut room = Description::default();
            add_room(&mut room, &matte(0.5, 0.5));
            Ball::new(3, 0.5).add(&mut room, DVec3::ZERO, glass(roughness));
            let room = scene_under(backend, inside(room));
            let picture = render(&room, Shot::new(Method::Path, 32, spp));
            let alpha = f64::from(roughness * roughness);
            expect(
                &picture,
                about(2.25, alpha * alpha + ROUNDING),
                0.02,
                &format!("inside glass, {backend:?}, α {alpha:.0e}"),
            );
        }
    }
}

/// Light through the middle of a corridor between two mirrors that meets them `COUNT` times before the lamp at its end.
#[test]
fn reflectances_of_mirrors_in_series_multiply() {
    const COUNT: i32 = 8;
    for &backend in Backend::AVAILABLE {
        for roughness in [0.0, 0.01f32] {
            let mut row = Description::default();
            let half = 0.5 * COUNT as f32;
            for (y, normal) in [(0.0, 1.0f32), (1.0, -1.0)] {
                let centre = Vec3::new(half, y, 0.0);
                add_square(&mut row, centre, Vec3::X * half, Vec3::Z * (-3.0 * normal), metal(0.9, roughness));
            }
            add_square(
                &mut row,
                Vec3::new(2.0 * half + 1.0, 0.5, 0.0),
                Vec3::Z * 40.0,
                Vec3::Y * 40.0,
                matte(0.0, 2.0),
            );
            let eye = DVec3::new(0.0, 0.5, 0.0);
            row.cameras.push(narrow(camera(eye, eye + DVec3::new(1.0, 1.0, 0.0)), 1e-3));
            let picture =
                render(&scene_under(backend, row), Shot::new(Method::Path, 16, if deep() { 4096 } else { 256 }));
            let expected = 2.0 * 0.9f64.powi(COUNT);
            // Whoever deviates by 1/20 of the half distance to an edge may miss a mirror: α²/t² of the facets' slopes.
            let alpha = f64::from(roughness * roughness);
            let tails = f64::from(COUNT) * (alpha / 0.02).powi(2);
            expect(
                &picture,
                about(expected, tails + ROUNDING),
                2e-3,
                &format!("{COUNT} mirrors, {backend:?}, α {alpha:.0e}"),
            );
        }
    }
}
