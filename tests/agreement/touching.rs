//! Surfaces that touch: each is met once, in order, whatever the gap, the scale, the place and the backend.

use crate::picture::{Shot, limit, render, scene_under};
use etendue::accel::Backend;
use etendue::geometry::Ray;
use etendue::integrator::Method;
use etendue::scene::Scene;
use etendue::scene::description::{AlphaMode, Description, EnvironmentDescription, Instance, Material};
use etendue::spectrum::Spectrum;
use etendue_testing::deep;
use etendue_testing::random::Random;
use etendue_testing::studio::{add, add_box, add_square, camera, glass, matte, narrow, with_model};
use glam::{DAffine3, DQuat, DVec3, Vec3};

const RAYS: usize = 16;

fn placements() -> u64 {
    if deep() { 1000 } else { 200 }
}

fn blended() -> Material {
    Material { alpha: 0.5, alpha_mode: AlphaMode::Blend, ..matte(0.5, 0.0) }
}

fn number(random: &mut Random, from: f64, to: f64) -> f64 {
    from + (to - from) * random.f64()
}

/// Scales 1e-3 to 1e3, offsets to 1e4, half of them turned.
fn somewhere(random: &mut Random) -> (DAffine3, f64) {
    let scale = 10f64.powf(number(random, -3.0, 3.0));
    let far = 10f64.powf(number(random, -2.0, 4.0));
    let offset = DVec3::new(random.f64(), random.f64(), random.f64()) * far;
    let turn = if random.f64() < 0.5 {
        DQuat::IDENTITY
    } else {
        DQuat::from_scaled_axis(DVec3::new(random.f64(), random.f64(), random.f64()) * 3.0)
    };
    (
        DAffine3::from_scale_rotation_translation(DVec3::splat(scale), turn, offset),
        // At most so large that all rays meet both.
        (f64::from(f32::EPSILON) * (far / scale).max(1.0)).min(0.005),
    )
}

/// A table in the plane y = 0 and a glass cube on it `gap` above, everything placed by `place`; `twice` makes the cube
/// an instance.
fn on_a_table(place: DAffine3, gap: f64, twice: bool) -> Description {
    let mut scene = Description::default();
    add_square(&mut scene, Vec3::ZERO, Vec3::X, Vec3::NEG_Z, matte(0.5, 0.0));
    add_box(&mut scene, Vec3::Y * 0.25, Vec3::splat(0.25), glass(0.0));
    scene.instances[0].transform = place;
    scene.instances[1].transform = place * DAffine3::from_translation(DVec3::Y * gap);
    if twice {
        let transform = place * DAffine3::from_translation(DVec3::new(3.0, 0.0, 0.0));
        scene.instances.push(Instance { name: "another".into(), mesh: 1, transform });
    }
    scene
}

/// The instances that a line meets one after the other; it goes straight on through all of them.
fn met(scene: &Scene, mut ray: Ray) -> Vec<u32> {
    let mut found = Vec::new();
    while let Some(point) = scene.intersect(&ray) {
        found.push(scene.ids(&point)[0]);
        assert!(found.len() < 20, "{found:?}");
        ray = point.spawn(ray.direction);
    }
    found
}

#[test]
fn glass_on_a_table_never_hides_it() {
    for &backend in Backend::AVAILABLE {
        let mut wrong = 0;
        for index in 0..placements() {
            let mut random = Random::new(7000 + index);
            let (place, ulp) = somewhere(&mut random);
            let gap = [0.0, 0.0, 1.0, 2.0, 4.0, -1.0, -2.0][index as usize % 7] * ulp;
            let scene = scene_under(backend, on_a_table(place, gap, index % 3 == 0));
            let missed = |_: &usize| {
                let [x, z] = [0, 0].map(|_| number(&mut random, -0.2, 0.2));
                let slant =
                    DVec3::new(number(&mut random, -0.3, 0.3), -1.0, number(&mut random, -0.3, 0.3)).normalize();
                let eye = place.transform_point3(DVec3::new(x, 0.0, z) - slant);
                let origin = scene.rebase().point(eye).as_vec3();
                let found = met(&scene, Ray::new(origin, place.transform_vector3(slant).normalize().as_vec3()));
                found.iter().filter(|&&id| id == 0).count() != 1 || found.iter().filter(|&&id| id == 1).count() != 2
            };
            wrong += u32::from((0..RAYS).filter(missed).count() > 0);
        }
        assert_eq!(wrong, 0, "{backend:?}: of {} placements", placements());
    }
}

/// Three blended layers in the plane of an opaque wall: each once, the later in the file the nearer as seen from the
/// front.
#[test]
fn layers_that_coincide_count_once_each_in_the_order_of_the_file() {
    for &backend in Backend::AVAILABLE {
        let mut stack = Description::default();
        for half in [4.0, 1.0, 2.0, 3.0] {
            let material = if stack.meshes.is_empty() { matte(0.5, 0.0) } else { blended() };
            add_square(&mut stack, Vec3::Z, Vec3::X * half, Vec3::Y * half, material);
        }
        let scene = scene_under(backend, stack);
        let place = |p: DVec3| scene.rebase().point(p).as_vec3();
        let mut random = Random::new(7);
        for _ in 0..1000 {
            let [x, y] = [0, 0].map(|_| number(&mut random, -0.4, 0.4));
            let d = DVec3::new(number(&mut random, -0.3, 0.3), number(&mut random, -0.3, 0.3), -1.0);
            let at = DVec3::new(x, y, 1.0);
            assert_eq!(met(&scene, Ray::new(place(at - d), d.as_vec3())), [3, 2, 1, 0], "{backend:?}");
            assert_eq!(met(&scene, Ray::new(place(at + d), -d.as_vec3())), [0, 1, 2, 3], "{backend:?}");
        }
    }
}

/// A blended square over a wall in white surroundings: (1 − α)² ρ of the wall and α ρ of its own.
#[test]
fn a_decal_shows_the_wall_behind_it_whatever_the_gap() {
    let methods = [Method::PathNee, Method::Path, Method::Light, Method::Bdpt];
    for (gap, backend) in
        [0.0, 1e-7, 1e-6, 2e-6].into_iter().flat_map(|gap| Backend::AVAILABLE.iter().map(move |&b| (gap, b)))
    {
        let mut decal =
            Description { environment: Some(EnvironmentDescription::Uniform(Spectrum::ONE)), ..Description::default() };
        let colored = |material: Material, rgb| with_model(material, |m| m.base_color = Spectrum::from_rgb(rgb));
        add_square(&mut decal, Vec3::ZERO, Vec3::X, Vec3::Y, colored(matte(0.0, 0.0), [0.5, 0.0, 0.0]));
        let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(x, y)| Vec3::new(x, y, gap));
        add(&mut decal, corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]], colored(blended(), [0.0, 0.0, 0.5]));
        decal.cameras.push(narrow(camera(DVec3::Z * 3.0, DVec3::ZERO), 0.2));
        let scene = scene_under(backend, decal);
        for method in methods {
            let picture = render(&scene, Shot::new(method, 8, 256));
            let n = picture.mean.len() as f64 / 3.0;
            for (lane, right) in [0.125, 0.0, 0.25].into_iter().enumerate() {
                let of = |v: &[f64]| v.iter().skip(lane).step_by(3).sum::<f64>();
                let (mean, error) = (of(&picture.mean) / n, of(&picture.variance).sqrt() / n);
                let slack = limit(3 * methods.len() * 8) * error + 1e-6; // the film's rounding
                assert!(
                    (mean - right).abs() <= slack,
                    "{backend:?} {method:?} {gap}: lane {lane} is {mean}, not {right} ± {slack}"
                );
            }
        }
    }
}
