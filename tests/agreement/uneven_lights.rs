//! Lights of very different strength and distance, lights without area, and very many at one place: the picture is
//! right, or one sentence says why there is none.

use crate::extremes::strip;
use crate::lamps::{ROUNDING, ground, reflected};
use crate::many_lights::{PATCH, below_square, ring};
use crate::picture::{Shot, about, expect, render, scene, scene_choosing};
use etendue::error::Kind;
use etendue::integrator::Method;
use etendue::light::LightChoice;
use etendue::scene::description::{Description, Material};
use etendue::scene::{BuildOptions, Scene};
use etendue::spectrum::Spectrum;
use etendue_testing::studio::{add, add_box, add_square, camera, matte, narrow, point_light};
use glam::{DVec3, Vec2, Vec3};
use std::time::{Duration, Instant};

/// Irradiance of `count` points of intensity 1 below the centre of [`ring`] of radius 0.7 at height 0.4.
fn below_ring(count: u32) -> f64 {
    f64::from(count) * 0.4 / 0.65f64.powf(1.5)
}

/// Strong lights that are shut out, and an emitting square cut into 32 weak triangles: `path` finds the square by
/// scattered rays, whatever the chance of its selection.
#[test]
fn weak_light_in_a_compartment_beside_strong_light_is_right() {
    for choice in [LightChoice::Tree, LightChoice::Power] {
        let mut room = ground(2.0);
        add_box(&mut room, Vec3::Y * 0.5, Vec3::new(2.5, 1.0, 2.5), matte(0.0, 0.0));
        for i in 0..16 {
            let place = |i: i32| 0.25 * i as f32 - 0.375;
            add_square(
                &mut room,
                Vec3::new(place(i % 4), 1.0, place(i / 4)),
                Vec3::X * 0.125,
                Vec3::Z * 0.125,
                matte(0.0, 1e-30),
            );
        }
        room.lights = ring(40, 4.0, 3.0);
        room.lights.iter_mut().for_each(|light| light.intensity *= 1e30);
        let room = scene_choosing(choice, room);
        // f32 scales the strength of 1e-30.
        let range = about(reflected(f64::from(1e-30f32) * below_square()), PATCH + ROUNDING);
        expect(&render(&room, Shot::new(Method::Path, 16, 1024)), range, 0.05, &format!("compartment, {choice:?}"));
    }
}

/// The sum is that of the strong ones to f32, and the weak ones do no harm.
#[test]
fn strong_lights_beside_weak_ones_dominate() {
    for choice in [LightChoice::Tree, LightChoice::Power, LightChoice::Uniform] {
        let mut scene = ground(2.0);
        scene.lights = ring(120, 0.7, 0.4);
        (scene.lights.iter_mut().zip(0..))
            .for_each(|(light, i)| light.intensity *= if i % 2 == 0 { 1e30 } else { 1e-30 });
        let picture = render(&scene_choosing(choice, scene), Shot::new(Method::Path, 16, 256));
        let range = about(reflected(f64::from(1e30f32) * below_ring(60)), PATCH + ROUNDING);
        expect(&picture, range, 0.05, &format!("strong beside weak, {choice:?}"));
    }
}

/// A light as far as f32 allows neither hides the others nor is lost.
#[test]
fn a_light_far_away_hides_no_others() {
    for intensity in [1.0, 1e34] {
        let mut scene = ground(2.0);
        scene.lights = ring(60, 0.7, 0.4);
        scene.lights.push(point_light(DVec3::new(0.0, 1e17, 0.0), intensity));
        let picture = render(&scene_choosing(LightChoice::Auto, scene), Shot::new(Method::Path, 16, 256));
        let far = f64::from(intensity) / 1e34;
        expect(&picture, about(reflected(below_ring(60) + far), PATCH + ROUNDING), 0.01, "far light");
    }
}

fn refusal(description: Description) -> String {
    let options = BuildOptions { threads: 1, ..BuildOptions::default() };
    let error = Scene::build(description, &options).err().expect("an error");
    assert_eq!(error.kind, Kind::Scene);
    error.to_string()
}

#[test]
fn lights_out_of_range_are_refused() {
    let with = |change: &dyn Fn(&mut Description)| {
        let mut scene = ground(1.0);
        scene.lights = ring(20, 0.7, 0.4);
        change(&mut scene);
        refusal(scene)
    };
    for strength in [f32::NAN, f32::INFINITY, -1.0, f32::MAX] {
        let said = with(&|scene| scene.materials[0].emission = Spectrum::splat(strength));
        assert_eq!(said, "material 0: the emission is out of range");
        let said = with(&|scene| scene.lights[7].intensity = Spectrum::splat(strength));
        assert_eq!(said, "light 'point' has an intensity out of range");
    }
    for far in [1e30, f64::NAN, f64::INFINITY] {
        let said = with(&|scene| scene.lights[7].transform.translation.x = far);
        assert_eq!(said, "light 'point' is farther than 1e18 times the size of the scene");
    }
    let said = with(&|scene| add_square(scene, Vec3::X * 1e30, Vec3::Y * 1e30, Vec3::Z * 1e30, matte(0.0, 1.0)));
    assert!(said.starts_with("the scene has a radius of "), "{said}");
}

/// Emitting triangles without area, on a line and in a point, are no lights.
#[test]
fn emitters_without_area_are_no_lights() {
    let mut scene = ground(2.0);
    scene.lights = ring(60, 0.7, 0.4);
    let corners = vec![Vec3::ONE, Vec3::ONE * 0.5, Vec3::ONE * 0.75];
    let triangles = (0..30).flat_map(|_| [[0, 1, 2], [0, 0, 0], [0, 1, 1]]).collect();
    add(&mut scene, corners, triangles, matte(0.0, 1e6));
    let scene = scene_choosing(LightChoice::Auto, scene);
    assert_eq!(scene.info().lights, 60);
    for method in [Method::Path, Method::Bdpt] {
        let picture = render(&scene, Shot::new(method, 16, 64));
        expect(&picture, about(reflected(below_ring(60)), PATCH + ROUNDING), 0.01, "without area");
    }
}

/// A hundred thousand triangles under a black texture are no lights.
#[test]
fn emitters_with_a_black_texture_are_no_lights() {
    let mut scene = ground(2.0);
    let material = Material { emission_texture: strip(vec![[0, 0, 0, 255]]), ..matte(0.0, 1e6) };
    add(&mut scene, vec![Vec3::Y, Vec3::Y + Vec3::X, Vec3::Y + Vec3::Z], vec![[0, 1, 2]; 100_000], material);
    scene.meshes[1].primitives[0].uvs[0] = Some(vec![Vec2::ZERO; 3]);
    scene.has_emission = true; // as a file is read, so that no sky stands in
    let scene = scene_choosing(LightChoice::Auto, scene);
    assert_eq!((scene.info().lights, scene.info().light_tree_bytes), (0, 0));
    let picture = render(&scene, Shot::new(Method::Path, 8, 4));
    assert!(picture.mean.iter().all(|&mean| mean == 0.0));
}

/// A million points at one place are a point a million times as strong.
#[test]
fn a_million_coincident_lights_are_one() {
    const COUNT: u32 = 1_000_000;
    let mut many = ground(2.0);
    many.lights = (0..COUNT).map(|_| point_light(DVec3::Y, 1.0)).collect();
    let start = Instant::now();
    let many = scene(many);
    println!("{COUNT} lights: {:.1?}, tree of {} bytes", start.elapsed(), many.info().light_tree_bytes);
    assert!(start.elapsed() < Duration::from_secs(60), "{:?}", start.elapsed()); // seconds; machines are busy
    let picture = render(&many, Shot::new(Method::Path, 8, 4));
    // Every selection has the same probability but for rounding: only the place in the pixel varies.
    expect(&picture, about(reflected(f64::from(COUNT)), PATCH + ROUNDING), 1e-4, "a million lights");
}

/// The camera of [`ground`] looks at a light nearby through no surface.
#[test]
fn a_receiver_at_a_light_gets_finite_light() {
    let mut scene = ground(2.0);
    scene.lights = ring(60, 0.7, 0.4);
    scene.lights.push(point_light(DVec3::ZERO, 1.0));
    scene.cameras = vec![narrow(camera(DVec3::new(0.2, 0.4, 0.1), DVec3::ZERO), 0.5)];
    let picture = render(&scene_choosing(LightChoice::Auto, scene), Shot::new(Method::Path, 16, 64));
    assert!(picture.mean.iter().all(|mean| mean.is_finite()));
}
