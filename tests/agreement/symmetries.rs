//! What must not change a picture, or only as the claim says: turning the scene, its size (not even the noise), the
//! resolution, cropping, splitting lights, cutting triangles.

use crate::invariance::still_life;
use crate::picture::{Picture, Shot, agree, render, scene};
use etendue::film::{Crop, Layout, PassFilm};
use etendue::integrator::{self, IntegratorConfig, Method, PilotEstimate};
use etendue::parallel::Cancel;
use etendue::sampling::SamplerKind;
use etendue::scene::Scene;
use etendue::scene::description::Description;
use etendue_testing::studio::{add_square, matte, point_light};
use glam::{DAffine3, DVec3, Vec3};

fn shot() -> Shot {
    Shot::new(Method::Path, 32, 64)
}

fn here() -> Picture {
    render(&scene(still_life(DAffine3::IDENTITY)), shot())
}

/// The picture of `description` with other random numbers.
fn again(description: Description) -> Picture {
    render(&scene(description), Shot { seed: 2, ..shot() })
}

fn expect_same(a: &Picture, b: &Picture, what: &str) {
    agree(a, b, 4).unwrap_or_else(|e| panic!("{what}: {e}"));
    // Planted: 3 %.
    assert!(agree(a, &b.clone().times(1.03), 4).is_err(), "{what}: 3 % are not convicted");
}

#[test]
fn a_scene_that_is_turned_and_moved_looks_alike() {
    let here = here();
    for (axis, angle) in [(DVec3::new(1.0, 2.0, -0.5), 2.0), (DVec3::X, std::f64::consts::FRAC_PI_2)] {
        let motion = DAffine3::from_translation(DVec3::new(3.0, -7.0, 11.0))
            * DAffine3::from_axis_angle(axis.normalize(), angle);
        expect_same(&here, &again(still_life(motion)), &format!("{angle} about {axis}"));
    }
}

/// The same random numbers take the same decisions at any size, so that errors are the same share of the picture but
/// for the rare path that rounding tips over.
#[test]
fn relative_noise_is_independent_of_scene_scale() {
    let noise = |picture: &Picture| picture.variance.iter().sum::<f64>() / picture.overall().mean.powi(2);
    let unit = noise(&here());
    for scale in [1e-4, 1e4] {
        let other = noise(&render(&scene(still_life(DAffine3::from_scale(DVec3::splat(scale)))), shot()));
        assert!((other / unit - 1.0).abs() < 0.01, "{scale}: {other} {unit}"); // see above: 1 % of the noise
    }
    assert!((noise(&here().times(3.0)) / unit - 1.0 / 9.0).abs() < 0.01, "relative to the mean alone");
}

/// Pixels four at a time are the pixels of half the resolution.
#[test]
fn resolution_does_not_change_what_is_seen() {
    let fine = render(&scene(still_life(DAffine3::IDENTITY)), Shot { seed: 2, ..Shot::new(Method::Path, 64, 16) });
    expect_same(&here(), &fine, "64 × 64 pixels");
}

/// One pass over `crop`.
fn pass(scene: &Scene, crop: Option<Crop>, sampler: SamplerKind) -> PassFilm {
    let layout = Layout::new(32, 24, crop, &[]);
    let options = IntegratorConfig { seed: 5, sampler, ..IntegratorConfig::new(Method::Path, &layout) };
    let camera = scene.camera(None, 32, 24).expect("a camera");
    let mut film = PassFilm::new(&layout);
    integrator::build(scene, camera, &options, &PilotEstimate::default())
        .run_pass(6, &Cancel::new(), &mut film)
        .expect("a pass");
    film
}

/// Bit for bit: a pixel does not depend on its neighbours.
#[test]
fn a_crop_is_a_piece_of_the_picture() {
    let scene = scene(still_life(DAffine3::IDENTITY));
    let crop = Crop { x0: 5, y0: 7, x1: 21, y1: 20 };
    for sampler in [SamplerKind::Independent, SamplerKind::Sobol] {
        let (whole, part) = (pass(&scene, None, sampler), pass(&scene, Some(crop), sampler));
        let part: Vec<u32> = part.values().iter().map(|v| v.to_bits()).collect();
        let whole = whole.values();
        let rows = (crop.y0..crop.y1).flat_map(|y| (crop.x0..crop.x1).map(move |x| (y * 32 + x) as usize));
        let same: Vec<u32> =
            rows.flat_map(|pixel| whole[3 * pixel..3 * pixel + 3].to_vec()).map(f32::to_bits).collect();
        assert_eq!(part, same, "{sampler:?}");
        assert!(same.iter().any(|&bits| bits != 0), "something is seen");
    }
}

/// The lamp in four squares, and in two halves that shine together at one place.
#[test]
fn a_lamp_in_pieces_is_the_lamp() {
    let here = here();
    let mut quarters = still_life(DAffine3::IDENTITY);
    quarters.instances.pop();
    for (x, z) in [(-0.2, -0.2), (0.2, -0.2), (-0.2, 0.2), (0.2, 0.2)] {
        add_square(&mut quarters, Vec3::new(0.2 + x, 2.0, 0.3 + z), Vec3::X * 0.2, Vec3::Z * 0.2, matte(0.0, 5.0));
    }
    expect_same(&here, &again(quarters), "four squares");
}

/// A point light, and lights at its place that share its intensity unevenly.
#[test]
fn point_lights_add_up() {
    let lit = |intensities: &[f32]| {
        let mut scene = still_life(DAffine3::IDENTITY);
        scene.instances.pop();
        scene.lights = intensities.iter().map(|&i| point_light(DVec3::new(0.2, 2.0, 0.3), i)).collect();
        scene
    };
    let one = render(&scene(lit(&[6.0])), shot());
    expect_same(&one, &again(lit(&[1.0, 2.0, 3.0])), "three point lights");
}

/// Every triangle in four.
#[test]
fn cutting_triangles_changes_nothing() {
    let mut cut = still_life(DAffine3::IDENTITY);
    for primitive in cut.meshes.iter_mut().flat_map(|m| &mut m.primitives) {
        let mut middle = |a: u32, b: u32| {
            primitive.positions.push((primitive.positions[a as usize] + primitive.positions[b as usize]) * 0.5);
            primitive.positions.len() as u32 - 1
        };
        let quarters = |&[a, b, c]: &[u32; 3]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        primitive.triangles = primitive.triangles.clone().iter().flat_map(quarters).collect();
    }
    expect_same(&here(), &again(cut), "triangles in four");
}
