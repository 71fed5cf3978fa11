//! Boxes divided into grids: rays parallel or nearly parallel to the axes, exactly at the grid lines.

use super::numbers::Numbers;
use super::shapes::{solid, world};
use super::{HardCase, aimed};
use crate::geometry::{Geometry, Ray};
use glam::Vec3;

/// Squares along an edge of the box; not a power of two.
const CELLS: u32 = 10;
/// A component so small relative to 1 that adding it to a coordinate has no effect in f32.
const NEARLY_NONE: f32 = 1e-7;

pub(super) fn cases() -> Vec<HardCase> {
    let room = || world([solid(CELLS, Vec3::NEG_ONE, Vec3::ONE)]);
    vec![
        HardCase::closed("box-grid-lines", room(), |geometry, n| {
            Ray::new(on_lines(geometry, n), along_axis(n, |_| 0.0))
        }),
        HardCase::closed("box-corners", room(), |geometry, n| aimed(on_lines(geometry, n), some_vertex(geometry, n))),
        HardCase::closed("near-axis", room(), |geometry, n| {
            Ray::new(on_lines(geometry, n), along_axis(n, |n| NEARLY_NONE * n.signed()))
        }),
        HardCase::closed("subnormal-components", room(), |geometry, n| {
            let tiny = |n: &mut Numbers| n.any(&[1.0, -1.0]) * n.magnitude(f32::from_bits(1), f32::MIN_POSITIVE);
            Ray::new(on_lines(geometry, n), along_axis(n, tiny))
        }),
        HardCase::closed("on-surface", room(), |_, n| from_wall(n)),
        HardCase::closed("adjoining-cubes", adjoining(), |geometry, n| {
            let origin = n.in_cube(0.99);
            let object = n.below(geometry.objects.len()) as u32;
            let corner = n.any(geometry.mesh_of(object).positions());
            aimed(origin, if n.below(2) == 0 { corner } else { super::on_edge(geometry, object, n) })
        }),
    ]
}

/// Returns a random vertex of the first object.
fn some_vertex(geometry: &Geometry, numbers: &mut Numbers) -> Vec3 {
    numbers.any(geometry.mesh_of(0).positions())
}

/// Returns a point in the box; each coordinate is either on a grid line or random.
fn on_lines(geometry: &Geometry, numbers: &mut Numbers) -> Vec3 {
    let coordinate = |numbers: &mut Numbers, axis: usize| {
        let line = some_vertex(geometry, numbers)[axis];
        if line.abs() < 1.0 && numbers.below(4) > 0 { line } else { 0.99 * numbers.signed() }
    };
    Vec3::new(coordinate(numbers, 0), coordinate(numbers, 1), coordinate(numbers, 2))
}

/// Returns a direction of ±1 along an axis, with the other two components from `other`.
fn along_axis(numbers: &mut Numbers, other: impl Fn(&mut Numbers) -> f32) -> Vec3 {
    let axis = numbers.below(3);
    let mut direction = Vec3::new(other(numbers), other(numbers), other(numbers));
    direction[axis] = numbers.any(&[1.0, -1.0]);
    direction
}

/// A ray that starts exactly on a wall, away from the edges of the box, and points inward.
fn from_wall(numbers: &mut Numbers) -> Ray {
    let (axis, side) = (numbers.below(3), numbers.any(&[1.0, -1.0]));
    let (mut origin, mut direction) = (numbers.in_cube(0.99), numbers.direction());
    origin[axis] = side;
    direction[axis] = -side * direction[axis].abs().max(NEARLY_NONE);
    Ray::new(origin, direction)
}

/// 27 cubes with common faces, each closed by itself, that fill the cube from −1 to 1.
fn adjoining() -> Geometry {
    let line = |i: u32| i as f32 / 1.5 - 1.0;
    world((0..27).map(|cell: u32| {
        let at = [cell % 3, cell / 3 % 3, cell / 9];
        solid(1, Vec3::from(at.map(line)), Vec3::from(at.map(|i| line(i + 1))))
    }))
}
