//! Whole renders at the edges of arithmetic: distances of 1e11 between the smallest and the largest thing, triangles a
//! million times as long as they are wide.

use crate::lamps::{FAR, add_sun};
use crate::picture::{Shot, about, agree, expect, render, render_guarded, scene_under};
use etendue::accel::Backend;
use etendue::integrator::Method;
use etendue::scene::description::Description;
use etendue_testing::deep;
use etendue_testing::studio::{Ball, add, add_room, add_square, camera, matte, metal, narrow};
use glam::{DVec3, Vec3};

/// Roundings of throughputs and film of one sample, a few dozen.
const ROUNDING: f64 = 64.0 * f32::EPSILON as f64;

/// A gem a thousandth wide on a table a metre wide, under a sun in the given distance.
fn gem_under_a_sun(distance: f64) -> Description {
    const WIDTH: f32 = 1e-3;
    let mut scene = Description::default();
    add_square(&mut scene, Vec3::ZERO, Vec3::X * 0.5, Vec3::NEG_Z * 0.5, matte(0.6, 0.0));
    Ball::new(2, WIDTH).add(&mut scene, DVec3::new(0.2, f64::from(WIDTH), -0.1), metal(0.8, 0.6));
    Ball::new(1, WIDTH).add(&mut scene, DVec3::new(0.203, f64::from(WIDTH), -0.1), matte(0.4, 0.0));
    add_sun(&mut scene, DVec3::new(0.5, 1.0, 0.7), distance, 64, 4e4);
    let target = DVec3::new(0.2015, 0.5e-3, -0.1);
    scene.cameras.push(narrow(camera(target + DVec3::new(0.0, 0.01, 0.02), target), 0.4));
    scene
}

/// Two suns of one width in the sky, one of them near: the same picture to 1e-3 / 1e3.
#[test]
fn a_gem_of_a_thousandth_keeps_its_shape_under_a_sun_at_1e8() {
    let shot = Shot::new(Method::Path, 64, if deep() { 1024 } else { 64 });
    for &backend in Backend::AVAILABLE {
        let near = render(&scene_under(backend, gem_under_a_sun(1e3)), shot);
        let far = render(&scene_under(backend, gem_under_a_sun(FAR)), Shot { seed: 2, ..shot });
        agree(&near, &far, 8).unwrap_or_else(|e| panic!("{backend:?}: {e}"));
        // Planted: the sun has moved by a fifth of its height, as shadows that lost their shape would.
        let mut moved = gem_under_a_sun(1e3);
        moved.instances[3].transform.translation.y *= 1.2;
        let moved = render(&scene_under(backend, moved), shot);
        assert!(agree(&moved, &far, 8).is_err(), "{backend:?}");
    }
}

/// A furnace with a wall of strips 2e-6 wide and 2 long: radiance stays 1, no pixel is dark.
#[test]
fn slivers_in_a_furnace_are_as_bright_as_the_rest() {
    const STRIPS: u16 = 2000;
    const WIDTH: f32 = 2e-6;
    for &backend in Backend::AVAILABLE {
        let mut room = Description::default();
        add_room(&mut room, &matte(0.5, 0.5));
        // in place of the wall z = −1: slivers in its middle, and a rest on either side with the same edges
        let (start, end) = (-0.5 * WIDTH * f32::from(STRIPS), 0.5 * WIDTH * f32::from(STRIPS));
        let mut columns = vec![-1.0];
        columns.extend((0..=STRIPS).map(|i| start + (end - start) * f32::from(i) / f32::from(STRIPS)));
        columns.push(1.0);
        let positions = columns.iter().flat_map(|&x| [Vec3::new(x, -1.0, -1.0), Vec3::new(x, 1.0, -1.0)]).collect();
        let strip = |i: u32| [[2 * i, 2 * i + 2, 2 * i + 3], [2 * i, 2 * i + 3, 2 * i + 1]];
        room.instances.remove(4);
        add(&mut room, positions, (0..columns.len() as u32 - 1).flat_map(strip).collect(), matte(0.5, 0.5));
        room.cameras.push(narrow(camera(DVec3::new(0.0, 0.1, 0.9), DVec3::new(0.0, 0.0, -1.0)), 1e-3));
        let spp = if deep() { 4096 } else { 256 };
        let (picture, guards) = render_guarded(&scene_under(backend, room), Shot::new(Method::Path, 32, spp));
        println!("{backend:?}: {guards:?}");
        expect(&picture, about(1.0, ROUNDING), 0.01, &format!("slivers, {backend:?}"));
        let darkest = picture.mean.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(darkest > 0.5, "{backend:?}: a pixel of {darkest}"); // what the wall emits by itself
        let rest = etendue::integrator::Guards { bad_hits: 0, ..guards };
        assert_eq!(rest, etendue::integrator::Guards::default());
    }
}
