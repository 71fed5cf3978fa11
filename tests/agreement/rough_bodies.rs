//! Rough surfaces in a white furnace: a convex body between black walls of radiance 1 scatters every path once, so that
//! it shows its directional albedo, which quadrature computes.

use crate::picture::{Shot, about, expect, render, scene};
use etendue::bsdf::Ggx;
use etendue::bsdf::albedo::{ERROR, moments};
use etendue::integrator::Method;
use etendue::scene::description::{CameraDescription, Description, Material, Projection};
use etendue_testing::deep;
use etendue_testing::studio::{Ball, add_room, camera, matte, metal, with_model};
use glam::DVec3;

/// Roundings of throughputs and film of one sample.
const ROUNDING: f64 = 64.0 * f32::EPSILON as f64;
/// Half the side of the view and the radius of the ball.
const HALF: f64 = 0.5;

/// A camera of parallel rays along −z over a square of half side [`HALF`].
fn parallel() -> CameraDescription {
    let projection = Projection::Orthographic { xmag: HALF, ymag: HALF };
    CameraDescription { projection, ..camera(DVec3::Z * 0.9, DVec3::ZERO) }
}

/// The view's mean: what faces the camera shows `albedo(cos)`, the rest the walls.
fn shown(ball: &Ball, albedo: impl Fn(f64) -> f64) -> f64 {
    let mut mean = 1.0;
    for t in &ball.triangles {
        let [a, b, c] = t.map(|i| ball.positions[i as usize].as_dvec3());
        let facing = (b - a).cross(c - a);
        if facing.z > 0.0 {
            let share = 0.5 * facing.z / (2.0 * HALF).powi(2);
            mean += share * (albedo(facing.z / facing.length()) - 1.0);
        }
    }
    mean
}

fn furnace(material: Material) -> Description {
    let mut room = Description::default();
    add_room(&mut room, &matte(0.0, 1.0));
    Ball::new(3, HALF as f32).add(&mut room, DVec3::ZERO, material);
    room.cameras.push(parallel());
    room
}

#[test]
fn a_rough_metal_ball_shows_its_albedo() {
    let spp = if deep() { 4096 } else { 256 };
    for roughness in [0.1f32, 0.3, 0.6, 1.0] {
        let ggx = Ggx::new(roughness * roughness);
        let expected = shown(&Ball::new(3, HALF as f32), |cos| 0.9 * moments(ggx, cos, [10, 20]).white);
        // The quadrature's own error at these few points, against 24 × 48 of them.
        let fine = shown(&Ball::new(1, HALF as f32), |cos| 0.9 * moments(ggx, cos, [24, 48]).white);
        let coarse = shown(&Ball::new(1, HALF as f32), |cos| 0.9 * moments(ggx, cos, [10, 20]).white);
        let slack = ROUNDING + 4.0 * (fine / coarse - 1.0).abs();
        let picture = render(&scene(furnace(metal(0.9, roughness))), Shot::new(Method::Path, 16, spp));
        expect(&picture, about(expected, slack), 0.02, &format!("metal of roughness {roughness}"));
    }
}

/// White plastic loses nothing but what its table is off.
#[test]
fn a_white_plastic_ball_cannot_be_seen() {
    let spp = if deep() { 4096 } else { 256 };
    for roughness in [0.0f32, 0.2, 0.5, 1.0] {
        let plastic = with_model(matte(1.0, 0.0), |m| {
            m.specular = 1.0;
            m.roughness = roughness;
        });
        let picture = render(&scene(furnace(plastic)), Shot::new(Method::Path, 16, spp));
        expect(&picture, about(1.0, ROUNDING + ERROR), 0.02, &format!("plastic of roughness {roughness}"));
    }
}
