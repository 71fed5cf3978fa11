//! Worlds whose tails luck may hide: small lamps with mirrors and glass, seen by methods that hardly sample what those
//! throw.

use etendue::scene::description::Description;
use etendue::scene::{BuildOptions, Scene};
use etendue_testing::studio::{Ball, add_box, add_room, add_square, camera, glass, matte, metal, narrow, point_light};
use glam::{DVec3, Vec3};

/// A lamp below the ceiling whose half side is `half`, of the power of one with half side ¼ and radiance 8; it faces
/// down.
fn lamp(world: &mut Description, at: Vec3, half: f32, power: f32) {
    let radiance = power * (0.25 / half).powi(2) * 8.0;
    let mut material = matte(0.0, radiance);
    material.double_sided = false;
    add_square(world, at, Vec3::X * half, Vec3::Z * half, material);
}

/// A grey room from −1 to 1 with a camera that looks along −z.
fn room() -> Description {
    let mut world = Description::default();
    add_room(&mut world, &matte(0.6, 0.0));
    world.cameras.push(narrow(camera(DVec3::new(0.0, 0.0, 0.95), DVec3::new(0.0, -0.2, 0.0)), 1.2));
    world
}

fn ball(world: &mut Description, at: [f64; 3], radius: f32, material: etendue::scene::description::Material) {
    Ball::new(3, radius).add(world, DVec3::from(at), material);
}

fn built(world: Description) -> Scene {
    let options = BuildOptions { threads: 1, ..BuildOptions::default() };
    Scene::build(world, &options).expect("a valid world")
}

/// The plain room by a lamp of that power.
pub(crate) fn lit_by(power: f32) -> Scene {
    let mut world = room();
    lamp(&mut world, Vec3::new(0.0, 0.98, 0.0), 0.25, power);
    built(world)
}

/// The worlds by name.
pub(crate) fn world(name: &str) -> Scene {
    let mut w = room();
    match name {
        "plain" => lamp(&mut w, Vec3::new(0.0, 0.98, 0.0), 0.25, 1.0),
        "boxes" => {
            lamp(&mut w, Vec3::new(0.0, 0.98, 0.0), 0.25, 1.0);
            add_box(&mut w, Vec3::new(-0.4, -0.6, -0.3), Vec3::new(0.25, 0.4, 0.25), matte(0.7, 0.0));
            add_box(&mut w, Vec3::new(0.4, -0.75, 0.1), Vec3::splat(0.25), matte(0.3, 0.0));
        }
        "two-lamps" => {
            lamp(&mut w, Vec3::new(-0.5, 0.9, -0.4), 0.1, 0.5);
            lamp(&mut w, Vec3::new(0.5, 0.9, 0.2), 0.1, 0.5);
            add_box(&mut w, Vec3::new(0.3, -0.6, -0.4), Vec3::new(0.25, 0.4, 0.25), matte(0.7, 0.0));
        }
        "two-lamps-uneven" => {
            lamp(&mut w, Vec3::new(-0.5, 0.9, -0.4), 0.1, 1.0);
            lamp(&mut w, Vec3::new(0.6, -0.2, -0.5), 0.05, 0.1);
            add_box(&mut w, Vec3::new(0.3, -0.6, -0.4), Vec3::new(0.25, 0.4, 0.25), matte(0.7, 0.0));
        }
        "point" => {
            w.lights.push(point_light(DVec3::new(0.2, 0.6, 0.1), 1.0));
            add_box(&mut w, Vec3::new(0.3, -0.6, -0.4), Vec3::new(0.25, 0.4, 0.25), matte(0.7, 0.0));
        }
        "mirrors-shaded" => {
            lamp(&mut w, Vec3::new(0.0, 0.75, 0.0), 0.05, 0.5);
            add_square(&mut w, Vec3::new(0.0, 0.6, 0.0), Vec3::X * 0.2, Vec3::Z * 0.2, matte(0.5, 0.0));
            ball(&mut w, [-0.45, -0.6, -0.4], 0.35, metal(0.95, 0.0));
            ball(&mut w, [0.45, -0.65, 0.0], 0.3, metal(0.95, 0.0));
        }
        "glass-mirror" => {
            lamp(&mut w, Vec3::new(0.3, 0.95, 0.0), 0.03, 0.5);
            add_square(&mut w, Vec3::new(-0.97, 0.0, -0.2), Vec3::Y * 0.7, Vec3::Z * 0.7, metal(0.9, 0.0));
            ball(&mut w, [-0.3, -0.6, -0.4], 0.3, glass(0.0));
            ball(&mut w, [0.45, -0.65, 0.0], 0.3, glass(0.0));
        }
        "mirror-ball" => {
            lamp(&mut w, Vec3::new(0.0, 0.98, 0.0), 0.25, 1.0);
            ball(&mut w, [0.3, -0.6, -0.2], 0.35, metal(0.95, 0.0));
        }
        "mirror-ball-small" => {
            lamp(&mut w, Vec3::new(0.0, 0.9, 0.0), 0.02, 0.5);
            ball(&mut w, [0.3, -0.6, -0.2], 0.35, metal(0.95, 0.0));
        }
        "gloss" => {
            lamp(&mut w, Vec3::new(0.0, 0.9, 0.0), 0.04, 0.5);
            ball(&mut w, [0.3, -0.6, -0.2], 0.35, metal(0.95, 0.2));
            ball(&mut w, [-0.4, -0.6, -0.4], 0.3, metal(0.9, 0.3));
        }
        "gloss-wide" => {
            lamp(&mut w, Vec3::new(0.0, 0.98, 0.0), 0.25, 1.0);
            ball(&mut w, [0.3, -0.6, -0.2], 0.35, metal(0.95, 0.4));
            ball(&mut w, [-0.4, -0.6, -0.4], 0.3, metal(0.9, 0.6));
        }
        "behind-glass" => {
            lamp(&mut w, Vec3::new(0.0, 0.9, -0.3), 0.06, 0.5);
            ball(&mut w, [0.0, 0.9, -0.3], 0.0975, glass(0.0));
        }
        "sky-mirror" => {
            w.meshes.truncate(2);
            w.instances.truncate(2);
            w.materials.truncate(2);
            w.environment =
                Some(etendue::scene::description::EnvironmentDescription::Uniform(etendue::spectrum::Spectrum::ONE));
            add_square(&mut w, Vec3::new(0.0, -1.0, 0.0), Vec3::Z, Vec3::X, matte(0.6, 0.0));
            ball(&mut w, [0.3, -0.6, -0.2], 0.35, metal(0.95, 0.0));
        }
        _ => panic!("no world is called {name}"),
    }
    built(w)
}

/// Worlds that hide nothing.
pub(crate) const PLAIN: &[&str] = &["plain", "boxes", "two-lamps", "point"];

/// Worlds that hide something from one method or another, or are noisy.
pub(crate) const HARD: &[&str] = &[
    "two-lamps-uneven",
    "mirrors-shaded",
    "glass-mirror",
    "mirror-ball",
    "mirror-ball-small",
    "gloss",
    "gloss-wide",
    "behind-glass",
    "sky-mirror",
];
