//! Many lights, one of which is selected for each receiver: closed forms, one light cut into many, and sizes of the
//! scene. Of more than a few lights the light tree selects; power and chance alone are its rivals.

use crate::bidirectional::{How, runs, times};
use crate::invariance::still_life;
use crate::lamps::{ROUNDING, ground, reflected};
use crate::picture::{LEVEL, Picture, Shot, about, expect, render, scene_choosing};
use etendue::integrator::Method;
use etendue::light::LightChoice;
use etendue::sampling::SamplerKind;
use etendue::scene::Scene;
use etendue::scene::description::{Description, Material, PunctualLight};
use etendue::spectrum::Spectrum;
use etendue::stats::{Estimate, Moments, t_test, welch_test};
use etendue_testing::levels::sidak_level;
use etendue_testing::methods::ChainOptions;
use etendue_testing::random::Random;
use etendue_testing::studio::{add, camera, matte, point_light};
use glam::{DAffine3, DVec3, Vec3};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};
use std::f64::consts::TAU;

const CHOICES: [LightChoice; 3] = [LightChoice::Tree, LightChoice::Power, LightChoice::Uniform];

/// The patch of [`ground`] is 1e-3 wide: its mean irradiance is that of its centre but for its square.
pub(crate) const PATCH: f64 = 1e-6;

/// `count` points of intensity 1 on a circle of `radius` at `height`.
pub(crate) fn ring(count: u32, radius: f64, height: f64) -> Vec<PunctualLight> {
    let at = |i: u32| {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(count)).sin_cos();
        point_light(DVec3::new(radius * cos, height, radius * sin), 1.0)
    };
    (0..count).map(at).collect()
}

/// N I h / (R² + h²)^3/2 below the centre of the ring.
#[test]
fn a_ring_of_points_has_its_irradiance_below_the_centre() {
    let (count, radius, height) = (60, 0.7, 0.4);
    let irradiance = f64::from(count) * height / (radius * radius + height * height).powf(1.5);
    for choice in CHOICES {
        let mut scene = ground(2.0);
        scene.lights = ring(count, radius, height);
        let scene = scene_choosing(choice, scene);
        for method in [Method::Path, Method::PathNee] {
            let picture = render(&scene, Shot::new(method, 16, 64));
            let range = about(reflected(irradiance), PATCH + ROUNDING);
            expect(&picture, range, 0.01, &format!("ring, {choice:?}, {method:?}"));
        }
    }
}

/// Solid angle of the square of half side `half` in the ground around the origin, seen from `p` above it.
fn solid_angle(p: DVec3, half: f64) -> f64 {
    let corner = |x: f64, z: f64| (x * z / (p.y * (x * x + z * z + p.y * p.y).sqrt())).atan();
    let [left, right, far, near] = [-half - p.x, half - p.x, -half - p.z, half - p.z];
    corner(right, near) - corner(left, near) - corner(right, far) + corner(left, far)
}

/// A square gets I Ω from a point. The camera looks straight down, so that its pixels show equal parts of the square.
#[test]
fn every_method_finds_the_flux_of_a_ring_of_points() {
    let height = 1.0;
    let mut scene = ground(2.0);
    scene.lights = ring(64, 0.6, 0.8);
    scene.cameras = vec![camera(DVec3::Y * height, DVec3::ZERO)];
    let half = height * 30f64.to_radians().tan();
    let flux: f64 = scene.lights.iter().map(|light| solid_angle(light.transform.translation, half)).sum();
    let expected = reflected(flux / (4.0 * half * half));
    let scene = scene_choosing(LightChoice::Auto, scene);
    assert!(scene.info().light_tree_bytes > 0);
    let methods =
        [Method::Path, Method::PathNee, Method::Light, Method::Bdpt, Method::Pssmlt, Method::Mmlt, Method::Mlt];
    let level = sidak_level(LEVEL, methods.len() as u64);
    for method in methods {
        let chains = ChainOptions { depths: Some(2), ..ChainOptions::all() };
        // Few photons arrive in the square.
        let spp = if method == Method::Light { 256 } else { 32 };
        let found = runs(&scene, &How { chains, ..How::new(method, 8, spp) }).overall();
        println!("{method:?}: {} ± {:.1e} of {expected}", found.value, found.standard_error);
        assert!(t_test(&found, expected).p_value > level, "{method:?}: {found:?} instead of {expected}");
        assert!(t_test(&times(found, 1.1), expected).p_value < level, "{method:?}: 10 % more is not convicted");
    }
}

/// Centres of the n² equal parts of the unit square at height 1.
fn grid(n: u32) -> impl Iterator<Item = DVec3> {
    let place = move |i: u32| (f64::from(i) + 0.5) / f64::from(n) - 0.5;
    (0..n * n).map(move |i| DVec3::new(place(i % n), 1.0, place(i / n)))
}

/// Irradiance at the origin of a grid of lights with cosine^`power` emission and the total intensity 1.
fn below_grid(n: u32, power: i32) -> f64 {
    let each = |p: DVec3| p.y.powi(1 + power) / p.length().powi(3 + power);
    grid(n).map(each).sum::<f64>() / f64::from(n * n)
}

/// Irradiance under the unit square at height 1, of radiance 1: four times that of a quarter, with the foot below its
/// corner, √(x / (1 + x)) atan √(x / (1 + x)) for the square x of its side.
pub(crate) fn below_square() -> f64 {
    let ratio = (0.25f64 / 1.25).sqrt();
    4.0 * ratio * ratio.atan()
}

/// The midpoint rule is wrong by c / n² + O(1 / n⁴).
#[test]
fn grids_of_lights_tend_to_the_square() {
    assert!((below_square() - 0.752_275).abs() < 1e-6); // digits of light-transport.md, section 3.2
    let whole = solid_angle(DVec3::Y, 0.5); // the square seen from the foot
    for (power, limit) in [(1, below_square()), (0, whole)] {
        for n in [8, 16, 32] {
            let [coarse, fine] = [n, 2 * n].map(|n| below_grid(n, power) - limit);
            // The next term is smaller by 1 / n², with a factor below 4 for these smooth integrands.
            assert!((coarse / fine - 4.0).abs() < 16.0 / f64::from(n * n), "{power} {n}: {coarse} {fine}");
        }
    }
}

/// A one-sided emitter of `radiance`.
fn lamp(radiance: f32) -> Material {
    Material { double_sided: false, ..matte(0.0, radiance) }
}

/// Squares of the side `side` around `centres`, fronts down, all of one mesh.
fn add_specks(scene: &mut Description, centres: impl Iterator<Item = DVec3>, side: f32, material: Material) {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for centre in centres {
        let (first, half) = (positions.len() as u32, 0.5 * side);
        let corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
        positions.extend(corners.map(|[x, z]| centre.as_vec3() + Vec3::new(x, 0.0, z)));
        triangles.extend([[0, 1, 2], [0, 2, 3]].map(|corners: [u32; 3]| corners.map(|c| first + c)));
    }
    add(scene, positions, triangles, material);
}

/// The sum over the grid itself is the answer, whatever selects.
#[test]
fn grids_of_points_and_of_specks_give_the_sum_of_their_irradiances() {
    /// Irradiance of a speck deviates from that of a point by the square of its size.
    const SIDE: f32 = 1e-3;
    const N: u32 = 12;
    for choice in CHOICES {
        let [mut points, mut specks] = [ground(2.0), ground(2.0)];
        points.lights = grid(N).map(|p| point_light(p, 2.0 / (N * N) as f32)).collect();
        add_specks(&mut specks, grid(N), SIDE, lamp(2.0 / (N * N) as f32 / (SIDE * SIDE)));
        for (name, description, power) in [("points", points, 0), ("specks", specks, 1)] {
            let scene = scene_choosing(choice, description);
            let range = about(reflected(2.0 * below_grid(N, power)), 3.0 * PATCH + ROUNDING);
            for method in [Method::Path, Method::PathNee] {
                let picture = render(&scene, Shot::new(method, 16, 64));
                expect(&picture, range, 0.01, &format!("{name}, {choice:?}, {method:?}"));
            }
        }
    }
}

/// [`still_life`] whose lamp does not shine, with points of those intensities at one place.
fn with_points(intensities: &[f32]) -> Description {
    let mut scene = still_life(DAffine3::IDENTITY);
    scene.materials.iter_mut().for_each(|m| m.emission = Spectrum::ZERO);
    scene.lights = intensities.iter().map(|&i| point_light(DVec3::new(0.3, 1.7, 0.8), i)).collect();
    scene
}

/// Coincident points are one of their sum: every sample has the same value, so that every moment is the same.
#[test]
fn coincident_points_are_one_light() {
    const COUNT: usize = 100;
    // Probabilities of a table are differences of f32 numbers up to 1.
    let bound = COUNT as f64 * f64::from(f32::EPSILON) + ROUNDING;
    let one = scene_choosing(LightChoice::Auto, with_points(&[COUNT as f32]));
    for choice in CHOICES {
        let many = scene_choosing(choice, with_points(&[1.0; COUNT]));
        for method in [Method::Path, Method::Bdpt] {
            let [one, many] = [&one, &many].map(|scene| render(scene, Shot::new(method, 16, 16)));
            let level = one.overall().mean;
            for (a, b) in one.mean.iter().zip(&many.mean) {
                // The film rounds to 2⁻²⁰ of the mean or finer.
                assert!((a - b).abs() <= bound * a + level * 2f64.powi(-20), "{choice:?}, {method:?}: {a} and {b}");
            }
        }
    }
}

/// A triangle above [`ground`], cut into 4^`levels` equal ones.
fn under_a_triangle(levels: u32) -> Description {
    let mut scene = ground(2.0);
    // So small that it is sampled by area from everywhere, as its parts are.
    let corners = [[-0.5, -0.4], [0.8, -0.2], [0.1, 0.9]].map(|[x, z]| Vec3::new(0.25 * x, 0.5, 0.25 * z));
    let mut triangles = vec![corners];
    for _ in 0..levels {
        let parts = |&[a, b, c]: &[Vec3; 3]| {
            let [ab, bc, ca] = [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.iter().flat_map(parts).collect();
    }
    let numbers = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    add(&mut scene, triangles.concat(), numbers, lamp(3.0));
    scene
}

/// Means of one sample in each of 64 pixels, by light samples alone, of many seeds.
fn single_samples(scene: &Scene) -> (Estimate, f64) {
    let shot = Shot { sampler: SamplerKind::Independent, ..Shot::new(Method::PathNee, 8, 4) };
    let means = (0..400).map(|seed| render(scene, Shot { seed, ..shot }).overall().mean);
    let moments: Moments = means.collect();
    (moments.estimate().expect("seeds"), moments.variance().expect("seeds"))
}

/// Equal parts that are selected equally often are sampled as the whole is: mean and variance are its own. Selection
/// by what they contribute may only lower the variance. Means of 256 samples are nearly normal, as the F test wants.
#[test]
fn a_triangle_and_its_parts_have_the_same_mean_and_no_more_variance() {
    let (whole, whole_variance) = single_samples(&scene_choosing(LightChoice::Power, under_a_triangle(0)));
    let level = sidak_level(LEVEL, 6);
    let dof = whole.dof;
    let most = FisherSnedecor::new(dof, dof).expect("degrees").inverse_cdf(1.0 - 0.5 * level);
    for choice in CHOICES {
        let (parts, variance) = single_samples(&scene_choosing(choice, under_a_triangle(3)));
        let ratio = variance / whole_variance;
        println!("{choice:?}: {parts:?} of {whole:?}, variance {ratio:.3} of the whole's, at most {most:.3}");
        assert!(welch_test(&parts, &whole).p_value > level, "{choice:?}: {parts:?} of {whole:?}");
        assert!(welch_test(&times(parts, 1.02), &whole).p_value < level, "{choice:?}: 2 % are not convicted");
        assert!(ratio < most, "{choice:?}: {ratio}");
        assert!(choice == LightChoice::Tree || ratio > most.recip(), "{choice:?}: {ratio}");
    }
}

/// [`still_life`] under points and triangles that shine one way, moved and scaled by `by`. Irradiance stays.
fn scaled_many_lights(scale: f64) -> Description {
    let mut scene = still_life(DAffine3::IDENTITY);
    let mut random = Random::new(3);
    let mut place = || Vec3::from(random.cube::<3>()) * Vec3::new(3.0, 1.5, 3.0) + Vec3::new(-1.5, 0.2, -1.5);
    let corners: Vec<Vec3> = (0..200).flat_map(|_| [place(); 3]).collect();
    let mut random = Random::new(4);
    let mut shift = || (Vec3::from(random.cube::<3>()) - 0.5) * 0.05;
    let positions = corners.into_iter().map(|p| p + shift()).collect();
    add(&mut scene, positions, (0..200).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(), lamp(50.0));
    scene.lights = ring(20, 1.0, 1.2);
    let by = DAffine3::from_scale(DVec3::splat(scale));
    scene.instances.iter_mut().for_each(|i| i.transform = by * i.transform);
    scene.cameras.iter_mut().for_each(|c| c.transform = by * c.transform);
    scene.lights.iter_mut().for_each(|light| {
        light.transform = by * light.transform;
        light.intensity *= (0.2 * scale * scale) as f32;
    });
    scene
}

/// The same paths, and so the same pixels and the same error: only rounding differs, and few pixels see a hit or a
/// selection change by it.
#[test]
fn many_lights_of_another_size_render_alike() {
    let [here, small, large] = [1.0, 1e-6, 1e6].map(|scale| {
        let scene = scene_choosing(LightChoice::Auto, scaled_many_lights(scale));
        assert!(scene.info().light_tree_bytes > 0);
        render(&scene, Shot::new(Method::Path, 32, 16))
    });
    for there in [small, large] {
        let differ = |(a, b): &(&f64, &f64)| (*a - *b).abs() > 1e-3 * a.abs().max(1e-3); // as in invariance.rs
        let pixels = here.mean.iter().zip(&there.mean).filter(differ).count();
        assert!(pixels <= here.mean.len() / 1000, "{pixels} of {} differ", here.mean.len());
        let error = |picture: &Picture| picture.overall().variance;
        assert!((error(&there) / error(&here) - 1.0).abs() < 0.01, "the errors differ"); // a thousandth of the pixels
    }
    assert!(here.overall().mean > 0.0);
}
