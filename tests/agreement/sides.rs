//! Single-sided surfaces: the camera does not see their backs, everything else does.

use crate::picture::{Shot, render, scene};
use etendue::film::{Filter, Layout, Plane};
use etendue::geometry::Ray;
use etendue::integrator::{self, FilmRenderer, IntegratorConfig, Method};
use etendue::scene::Scene;
use etendue::scene::description::{AlphaMode, Description, Instance, Material, Volume};
use etendue_testing::studio::{add_square, camera, matte, point_light, with_model};
use glam::{DAffine3, DVec3, Vec3};

/// Black and single-sided.
fn curtain() -> Material {
    Material { double_sided: false, ..matte(0.0, 0.0) }
}

/// From the camera along −z: a panel at distance 2 whose back is towards it, and a wall at 6 that emits 1.
fn before_a_wall(panel: Material) -> Scene {
    let mut scene = Description::default();
    add_square(&mut scene, Vec3::Z * -2.0, Vec3::Y * 5.0, Vec3::X * 5.0, panel);
    add_square(&mut scene, Vec3::Z * -6.0, Vec3::X * 9.0, Vec3::Y * 9.0, matte(0.0, 1.0));
    scene.cameras.push(camera(DVec3::ZERO, DVec3::NEG_Z));
    self::scene(scene)
}

/// The one value of all pixels without scattering.
fn seen(scene: &Scene, depth: u32) -> f64 {
    let picture = render(scene, Shot { depth: Some(depth), ..Shot::new(Method::Path, 8, 4) });
    let (min, max) = picture.mean.iter().fold((f64::MAX, f64::MIN), |(a, b), &m| (a.min(m), b.max(m)));
    assert!(max - min < 1e-6, "{min} to {max}"); // film quantum
    (min + max) * 0.5
}

#[test]
fn the_camera_sees_through_the_back_of_a_single_sided_surface() {
    let blend = |double_sided| Material { alpha_mode: AlphaMode::Blend, alpha: 0.5, double_sided, ..curtain() };
    for (panel, radiance) in [
        (curtain(), 1.0),
        (Material { double_sided: true, ..curtain() }, 0.0),
        (blend(false), 1.0),
        (Material { alpha: 1.0, ..blend(true) }, 0.0),
        // The back of an emitter is black.
        (Material { double_sided: false, ..matte(0.0, 7.0) }, 0.0),
    ] {
        let what = format!("{panel:?}");
        assert!((seen(&before_a_wall(panel), 0) - radiance).abs() < 1e-6, "{what}"); // film quantum
    }
}

#[test]
fn the_back_of_glass_is_a_surface_of_it() {
    let volume = Some(Volume::CLEAR);
    let glass = with_model(curtain(), |m| {
        m.transmission = 1.0;
        m.volume = volume;
    });
    let at = |panel| {
        let scene = before_a_wall(panel);
        let eye = scene.rebase().point(DVec3::ZERO).as_vec3();
        scene.seen(Ray::new(eye, Vec3::NEG_Z)).map(|p| p.hit.object)
    };
    assert_eq!((at(glass), at(curtain())), (Some(0), Some(1)));
}

#[test]
fn what_the_camera_does_not_see_still_throws_a_shadow() {
    // The light, the camera, the panel with its front down, the floor: only the floor is seen, and the panel shades it.
    let floor = |panel: Option<Material>| {
        let mut scene = Description::default();
        add_square(&mut scene, Vec3::ZERO, Vec3::Z * 9.0, Vec3::X * 9.0, matte(0.5, 0.0));
        if let Some(panel) = panel {
            add_square(&mut scene, Vec3::Y, Vec3::X * 8.0, Vec3::Z * 8.0, panel);
        }
        scene.lights.push(point_light(DVec3::Y * 5.0, 10.0));
        scene.cameras.push(camera(DVec3::Y * 3.0, DVec3::ZERO));
        let picture = render(&self::scene(scene), Shot { depth: Some(1), ..Shot::new(Method::Path, 8, 4) });
        picture.overall().mean
    };
    assert!(floor(None) > 0.01); // a hundredth of what an intensity of 10 gives at a distance of 5
    assert!(floor(Some(curtain())) <= 0.0);
}

#[test]
fn a_mirror_shows_both_sides() {
    let mirror = with_model(matte(1.0, 0.0), |m| {
        m.roughness = 0.0;
        m.metallic = 1.0;
    });
    let behind_the_camera = |panel| {
        let mut scene = Description::default();
        add_square(&mut scene, Vec3::Z * -2.0, Vec3::X * 3.0, Vec3::Y * 3.0, mirror.clone());
        // Its back is towards the mirror; behind it lies what emits.
        add_square(&mut scene, Vec3::Z * 2.0, Vec3::X * 9.0, Vec3::Y * 9.0, panel);
        add_square(&mut scene, Vec3::Z * 4.0, Vec3::Y * 20.0, Vec3::X * 20.0, matte(0.0, 1.0));
        scene.cameras.push(camera(DVec3::ZERO, DVec3::NEG_Z));
        seen(&self::scene(scene), 1)
    };
    assert!(behind_the_camera(curtain()) <= 0.0);
    // Were it not there, the wall would be.
    let hole = Material { alpha_mode: AlphaMode::Blend, alpha: 0.0, ..curtain() };
    assert!((behind_the_camera(hole) - 1.0).abs() < 1e-6); // film quantum
}

/// A placement that mirrors keeps fronts in front, whether the mesh is baked or shared.
#[test]
fn mirrored_placements_keep_their_fronts() {
    for copies in [1, 2] {
        for flip in [1.0, -1.0] {
            let mut description = Description::default();
            add_square(&mut description, Vec3::ZERO, Vec3::Y, Vec3::X, curtain());
            let transform = DAffine3::from_scale(DVec3::new(flip, 1.0, 1.0));
            let at = |z: f64| DAffine3::from_translation(DVec3::Z * z) * transform;
            description.instances = (0..copies)
                .map(|i| Instance { name: format!("{i}"), mesh: 0, transform: at(-2.0 - f64::from(i)) })
                .collect();
            description.cameras.push(camera(DVec3::ZERO, DVec3::NEG_Z));
            let scene = self::scene(description);
            let from = |p: DVec3| scene.rebase().point(p).as_vec3();
            assert!(scene.seen(Ray::new(from(DVec3::new(0.1, 0.2, 1.0)), Vec3::NEG_Z)).is_none(), "{copies} {flip}");
            assert!(scene.seen(Ray::new(from(DVec3::new(0.1, 0.2, -9.0)), Vec3::Z)).is_some(), "{copies} {flip}");
        }
    }
}

#[test]
fn aovs_and_ids_are_those_of_the_visible_surface() {
    let side = 8;
    let layout = Layout::new(side, side, None, &[Plane::Depth, Plane::Alpha]);
    let scene = before_a_wall(curtain());
    let camera = scene.camera(None, side, side).expect("a camera");
    let options = IntegratorConfig { seed: 1, filter: Filter::Box, ..IntegratorConfig::new(Method::Path, &layout) };
    let ids = integrator::ids(&scene, &camera, &layout);
    let mut renderer = FilmRenderer::begin(&scene, camera, &options, &layout);
    renderer.passes(1);
    let film = renderer.film();
    assert!(film.mean(Plane::Alpha).iter().all(|&a| a >= 1.0));
    // The field of view is 60 degrees: its corners are √(1 + 2/3) times as far as its middle, and the panel is at 2.
    let furthest = 6.0 * (1.0f32 + 2.0 / 3.0).sqrt();
    assert!(film.mean(Plane::Depth).iter().all(|&d| (5.99..furthest).contains(&d)), "{:?}", film.mean(Plane::Depth));
    assert!(ids[0].iter().all(|&instance| instance.to_bits() == 1.0f32.to_bits()), "{ids:?}");
}
