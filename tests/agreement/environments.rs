//! Scenes under environment maps: closed forms, and three methods that find the light in different ways.

use crate::picture::{Picture, Shot, agree, limit, render, scene};
use etendue::integrator::Method;
use etendue::scene::Scene;
use etendue::scene::description::{Description, EnvironmentDescription, Projection};
use etendue::spectrum::Spectrum;
use etendue::texture::RadianceMap;
use etendue_testing::studio::{add, add_square, camera, matte};
use glam::{DVec3, Vec3};
use std::sync::Arc;

const METHODS: [Method; 3] = [Method::PathNaive, Method::PathNee, Method::Path];

fn map(width: u32, height: u32, rotation: f64, texel: impl Fn(u32, u32) -> [f32; 3]) -> EnvironmentDescription {
    let texels = (0..width * height).map(|i| texel(i % width, i / width)).collect();
    EnvironmentDescription::Map { map: Arc::new(RadianceMap::new(width, height, texels)), scale: 0.5, rotation }
}

/// A square floor seen from above, with a wall on it for shadows and interreflection.
fn courtyard(environment: EnvironmentDescription) -> Scene {
    let mut yard = Description { environment: Some(environment), ..Description::default() };
    add_square(&mut yard, Vec3::ZERO, Vec3::X, Vec3::NEG_Z, matte(0.6, 0.0));
    let corners = vec![Vec3::new(-0.5, 0.0, -0.4), Vec3::new(0.5, 0.0, -0.4), Vec3::new(0.0, 0.9, -0.2)];
    add(&mut yard, corners, vec![[0, 1, 2]], matte(0.8, 0.0));
    yard.cameras.push(camera(DVec3::new(0.0, 1.2, 0.9), DVec3::new(0.0, 0.1, 0.0)));
    scene(yard)
}

/// The mean of a picture against `expected`.
fn has_mean(picture: &Picture, expected: f64, what: &str) {
    let overall = picture.overall();
    let z = (overall.mean - expected) / overall.variance.sqrt();
    assert!(z.abs() < limit(1), "{what}: {} instead of {expected}, z {z:.2}", overall.mean);
    assert!(expected * 0.01 / overall.variance.sqrt() > limit(1), "{what}: too noisy");
}

/// A Lambertian plane under constant radiance L shows ρ L, whether L is a map or a number; here L is 2 times the scale.
#[test]
fn a_plane_under_a_constant_map_shows_its_reflectance() {
    for environment in [map(8, 4, 33.0, |_, _| [2.0; 3]), EnvironmentDescription::Uniform(Spectrum::ONE)] {
        let name = format!("{environment:?}");
        let mut yard = Description { environment: Some(environment), ..Description::default() };
        add_square(&mut yard, Vec3::ZERO, Vec3::X, Vec3::NEG_Z, matte(0.6, 0.0));
        yard.cameras.push(camera(DVec3::new(0.0, 0.5, 0.3), DVec3::ZERO));
        let yard = scene(yard);
        for method in METHODS {
            has_mean(&render(&yard, Shot::new(method, 16, 256)), 0.6, &format!("{method:?} {name}"));
        }
    }
}

/// A narrow view of the middle of a texel shows that texel, turned as it was asked for.
#[test]
fn the_camera_sees_the_map() {
    const VIEW: f64 = 1e-4;
    let texel = |x: u32, y: u32| [x as f32, y as f32, 4.0];
    for rotation in [0.0, 90.0, -30.0f64] {
        let mut yard = Description { environment: Some(map(8, 4, rotation, texel)), ..Description::default() };
        add_square(&mut yard, Vec3::NEG_Y, Vec3::X, Vec3::NEG_Z, matte(0.6, 0.0));
        // Texel (2, 1): azimuth 2π (1/2 − 2.5/8) and as far from the zenith, counter-clockwise.
        let (azimuth, polar) = ((67.5 + rotation).to_radians(), 67.5f64.to_radians());
        let shown = DVec3::new(polar.sin() * azimuth.cos(), polar.cos(), -polar.sin() * azimuth.sin());
        let mut narrow = camera(DVec3::ZERO, shown);
        narrow.projection = Projection::Perspective { yfov: VIEW, aspect: None };
        yard.cameras.push(narrow);
        let picture = render(&scene(yard), Shot { depth: Some(0), ..Shot::new(Method::Path, 8, 4) });
        for (i, &seen) in picture.mean.iter().enumerate() {
            let expected = 0.5 * [2.0, 1.0, 4.0][i % 3];
            // Neighbours differ by at most 1, over an eighth of a turn, and half the diagonal is less than the view.
            assert!((seen - expected).abs() < VIEW, "{rotation}: {seen}, not {expected}");
        }
    }
}

#[test]
fn all_methods_see_one_picture_under_a_map() {
    let sun = |x, y| if (x, y) == (5, 1) { [40.0, 30.0, 20.0] } else { [0.3, 0.4, 0.5] };
    let yard = courtyard(map(16, 8, 50.0, sun));
    let [naive, nee, path] =
        METHODS.map(|m| render(&yard, Shot::new(m, 32, if m == Method::PathNaive { 1024 } else { 64 })));
    agree(&path, &nee, 4).unwrap_or_else(|e| panic!("path and path-nee: {e}"));
    agree(&path, &naive, 4).unwrap_or_else(|e| panic!("path and path-naive: {e}"));
}

/// The environment shares the choice with other lights.
#[test]
fn a_map_and_a_lamp_are_both_found() {
    let mut yard =
        Description { environment: Some(map(4, 2, 0.0, |x, _| [x as f32 * 0.2; 3])), ..Description::default() };
    add_square(&mut yard, Vec3::ZERO, Vec3::X, Vec3::NEG_Z, matte(0.6, 0.0));
    add_square(&mut yard, Vec3::Y * 0.6, Vec3::X * 0.2, Vec3::Z * 0.2, matte(0.0, 5.0));
    yard.cameras.push(camera(DVec3::new(0.0, 0.5, 1.2), DVec3::ZERO));
    let yard = scene(yard);
    let [naive, nee, path] =
        METHODS.map(|m| render(&yard, Shot::new(m, 32, if m == Method::PathNaive { 512 } else { 64 })));
    agree(&path, &nee, 4).unwrap_or_else(|e| panic!("path and path-nee: {e}"));
    agree(&path, &naive, 4).unwrap_or_else(|e| panic!("path and path-naive: {e}"));
}
