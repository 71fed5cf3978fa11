//! Reciprocity of the renderer: swap a point light and a pinhole that counts radiance from everywhere, and the response
//! is the same; with one of them in glass, the same but for the square of its index: f(wi, wo) / η²_o is what is
//! symmetric. This sees adjoint factors, η² and light choice together, which tests of each surface alone do not.
//!
//! The pinhole is six cameras of 90 degrees. Paths that leave the pinhole or the light over a mirror would be found
//! from one side only, so everything here is rough. Shading normals are not reciprocal in themselves: there are none.

use crate::picture::{Block, Shot, limit, render, scene};
use etendue::integrator::Method;
use etendue::scene::description::{CameraDescription, Description, Projection};
use etendue_testing::deep;
use etendue_testing::studio::{Ball, add_square, camera, glass, matte, metal, point_light, with_model};
use glam::{DVec3, Vec3};

const SIDE: usize = 32;
/// The middle of the glass ball.
pub(crate) const IN_GLASS: DVec3 = DVec3::new(-0.5, 0.45, 0.3);
pub(crate) const INDEX: f64 = 1.5;

/// An alcove with a ball of metal, one of plastic and one of rough glass.
pub(crate) fn alcove() -> Description {
    let mut scene = Description::default();
    add_square(&mut scene, Vec3::ZERO, Vec3::X * 1.5, Vec3::NEG_Z * 1.5, matte(0.7, 0.0));
    add_square(&mut scene, Vec3::new(0.0, 1.0, -1.2), Vec3::X * 1.5, Vec3::Y, matte(0.5, 0.0));
    add_square(&mut scene, Vec3::new(1.4, 1.0, 0.0), Vec3::Z, Vec3::Y, matte(0.8, 0.0));
    Ball::new(2, 0.3).add(&mut scene, DVec3::new(0.6, 0.35, -0.2), metal(0.9, 0.5));
    let plastic = with_model(matte(0.6, 0.0), |m| {
        m.specular = 1.0;
        m.roughness = 0.4;
    });
    Ball::new(2, 0.25).add(&mut scene, DVec3::new(0.1, 0.3, 0.5), plastic);
    Ball::new(2, 0.35).add(&mut scene, IN_GLASS, glass(0.6));
    scene
}

/// ∫ L dω at `eye` under a point light of intensity 1 at `light`.
fn response(eye: DVec3, light: DVec3, method: Method, spp: u64) -> Block {
    let projection = Projection::Perspective { yfov: std::f64::consts::FRAC_PI_2, aspect: None };
    let mut total = Block { mean: 0.0, variance: 0.0 };
    for (i, axis) in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z].into_iter().enumerate() {
        let mut scene = alcove();
        scene.lights.push(point_light(light, 1.0));
        scene.cameras.push(CameraDescription { projection, ..camera(eye, eye + axis) });
        let picture = render(&self::scene(scene), Shot { seed: i as u64, ..Shot::new(method, SIDE as u32, spp) });
        for pixel in 0..SIDE * SIDE {
            let at = |k: usize| (2 * k + 1) as f64 / SIDE as f64 - 1.0;
            let (u, v) = (at(pixel % SIDE), at(pixel / SIDE));
            // film area becomes solid angle by cos³
            let weight = (2.0 / SIDE as f64).powi(2) * (1.0 + u * u + v * v).powf(-1.5);
            total.mean += weight * picture.mean[3 * pixel];
            total.variance += weight * weight * picture.variance[3 * pixel];
        }
    }
    total
}

fn times(block: Block, factor: f64) -> Block {
    Block { mean: block.mean * factor, variance: block.variance * factor * factor }
}

/// Tests of this file.
const TESTS: usize = 3;

/// `forth` = `factor` × `back`, and not if it is `planted` times as bright. The weights' change within a pixel of 1/16
/// is second order, 1e-3, and nearly the same both ways.
fn expect(forth: Block, back: Block, factor: f64, planted: f64, what: &str) {
    let back = times(back, factor);
    println!(
        "{what}: {} and {}, z {:.2}, error {:.1e}",
        forth.mean,
        back.mean,
        forth.z(back),
        (forth.variance + back.variance).sqrt()
    );
    assert!(forth.z(back).abs() < limit(TESTS), "{what}: z {:.2}", forth.z(back));
    assert!(forth.z(times(back, planted)).abs() > limit(TESTS), "{what}: {planted} is not convicted");
}

#[test]
fn light_and_camera_can_be_swapped() {
    let spp = if deep() { 1024 } else { 16 };
    let places = [DVec3::new(-0.9, 1.3, 0.9), DVec3::new(0.9, 0.9, 0.6)];
    for method in [Method::Path, Method::PathNee] {
        let [forth, back] = [[0, 1], [1, 0]].map(|[a, b]| response(places[a], places[b], method, spp));
        expect(forth, back, 1.0, 1.05, &format!("{method:?} in air"));
    }
    let (air, spp) = (places[1], 4 * spp);
    let [forth, back] = [response(IN_GLASS, air, Method::Path, spp), response(air, IN_GLASS, Method::Path, spp)];
    expect(forth, back, INDEX.powi(2), 1.2, "into glass and out of it");
}
