//! Changes of a scene that leave the picture as it is: translation, scale, shared meshes, cut triangles.

use crate::picture::{Shot, agree, render, scene};
use etendue::integrator::Method;
use etendue::scene::description::{Description, Instance};
use etendue_testing::studio::{Ball, add, add_square, camera, matte, point_light};
use glam::{DAffine3, DVec3, Vec3};

/// A floor, two boxes' worth of walls and a light, with everything moved and scaled by `by`.
pub(crate) fn still_life(by: DAffine3) -> Description {
    let mut scene = Description::default();
    add_square(&mut scene, Vec3::ZERO, Vec3::X * 2.0, Vec3::NEG_Z * 2.0, matte(0.6, 0.0));
    add_square(&mut scene, Vec3::new(-0.7, 0.5, 0.0), Vec3::Y * 0.5, Vec3::Z * 0.8, matte(0.3, 0.0));
    add_square(&mut scene, Vec3::new(0.5, 0.4, -0.6), Vec3::new(0.4, 0.0, 0.2), Vec3::Y * 0.4, matte(0.8, 0.0));
    add_square(&mut scene, Vec3::new(0.2, 2.0, 0.3), Vec3::X * 0.4, Vec3::Z * 0.4, matte(0.0, 5.0));
    scene.cameras.push(camera(DVec3::new(0.5, 1.5, 3.0), DVec3::new(0.0, 0.3, 0.0)));
    scene.instances.iter_mut().for_each(|i| i.transform = by * i.transform);
    scene.cameras.iter_mut().for_each(|c| c.transform = by * c.transform);
    scene
}

fn shot() -> Shot {
    Shot::new(Method::Path, 32, 16)
}

/// The same random numbers give the same paths: only rounding differs, and few pixels see a hit change by it.
#[test]
fn a_scene_far_away_or_of_another_size_renders_alike() {
    let here = render(&scene(still_life(DAffine3::IDENTITY)), shot());
    for by in [
        DAffine3::from_translation(DVec3::new(1e6, -2e6, 3e6)),
        DAffine3::from_scale(DVec3::splat(1e-4)), // a scale
        DAffine3::from_scale(DVec3::splat(1e4)),
    ] {
        let there = render(&scene(still_life(by)), shot());
        let differ = |(a, b): &(&f64, &f64)| (*a - *b).abs() > 1e-3 * a.abs().max(1e-3); // the figure
        let pixels = here.mean.iter().zip(&there.mean).filter(differ).count();
        assert!(pixels <= here.mean.len() / 1000, "{by:?}: {pixels} of {} differ", here.mean.len());
    }
}

/// Instances of a shared mesh and meshes of their own are the same surfaces.
#[test]
fn instances_and_copies_are_the_same_scene() {
    let copies = || {
        let mut scene = still_life(DAffine3::IDENTITY);
        let turned = DAffine3::from_translation(DVec3::new(-0.2, 0.3, 0.9)) * DAffine3::from_rotation_y(0.7);
        let mut again = still_life(DAffine3::IDENTITY);
        let mut instance = again.instances.swap_remove(1);
        instance.transform = turned * DAffine3::from_scale(DVec3::new(-0.7, 0.5, 0.9));
        scene.instances.push(instance);
        scene
    };
    let shared = scene(copies());
    let mut apart = copies();
    let mesh = apart.instances[4].mesh;
    let source = &apart.meshes[mesh].primitives[0];
    let (positions, triangles, material) = (source.positions.clone(), source.triangles.clone(), source.material);
    let transform = apart.instances[4].transform;
    apart.instances.truncate(4);
    add(&mut apart, positions, triangles, matte(0.0, 0.0));
    apart.materials.pop();
    apart.meshes[4].primitives[0].material = material;
    apart.instances[4].transform = transform;
    let apart = scene(apart);
    assert!(shared.features().instances && !apart.features().instances);
    let (a, b) = (render(&shared, shot()), render(&apart, Shot { seed: 2, ..shot() }));
    agree(&a, &b, 4).unwrap_or_else(|e| panic!("{e}"));
}

/// Smooth bodies squeezed by their nodes: a mesh that two nodes share keeps its normals in its own space, one that
/// stands at one place has them moved with it. A point light shades them without noise but for the pixels' own.
#[test]
fn shared_and_moved_normals_are_the_same() {
    let squeeze = |x: f64| DAffine3::from_translation(DVec3::X * x) * DAffine3::from_scale(DVec3::new(0.3, 1.0, 0.8));
    let bodies = |shared: bool| {
        let mut scene = Description::default();
        for x in [-0.5, 0.5] {
            if !shared || x < 0.0 {
                let ball = Ball::new(3, 1.0);
                let normals = ball.positions.clone();
                add(&mut scene, ball.positions, ball.triangles, matte(0.7, 0.0));
                scene.meshes.last_mut().expect("just added").primitives[0].normals = Some(normals);
            } else {
                let instance = Instance { name: "again".into(), mesh: 0, transform: DAffine3::IDENTITY };
                scene.instances.push(instance);
            }
            scene.instances.last_mut().expect("just added").transform = squeeze(x);
        }
        scene.lights.push(point_light(DVec3::new(1.0, 2.0, 3.0), 5.0));
        scene.cameras.push(camera(DVec3::new(0.0, 0.4, 3.0), DVec3::ZERO));
        self::scene(scene)
    };
    let (shared, moved) = (bodies(true), bodies(false));
    assert!(shared.features().instances && !moved.features().instances);
    let at = |scene, seed| render(scene, Shot { seed, depth: Some(1), ..shot() });
    agree(&at(&shared, 1), &at(&moved, 2), 4).unwrap_or_else(|e| panic!("{e}"));
}
