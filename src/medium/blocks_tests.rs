use super::*;
use crate::medium::Grid;
use crate::medium::reach::Reach;
use etendue_testing::random::Random;
use glam::{DAffine3, DVec3, Vec3};
use std::sync::Arc;

/// Cells that are no multiple of a block on any axis, and one with a whole number of blocks of interpolation cells.
const SIZES: [[usize; 3]; 4] = [[37, 20, 51], [7, 15, 23], [1, 8, 9], [1, 1, 1]];

/// Two of three values are 0, or half of the box is empty, so that there are empty blocks.
fn sparse([a, b, c]: [usize; 3], random: &mut Random) -> Vec<f32> {
    let value = |x: usize, random: &mut Random| if 2 * x > a { 0.0 } else { (random.f32() - 0.66).max(0.0) };
    (0..a * b * c).map(|i| value(i % a, random)).collect()
}

/// Values that differ by a fifth.
fn nearly_even([a, b, c]: [usize; 3], random: &mut Random) -> Vec<f32> {
    (0..a * b * c).map(|_| 0.8 + 0.2 * random.f32()).collect()
}

/// The interpolation in f64 by its definition.
fn by_definition(cells: [usize; 3], values: &[f32], s: Vec3A) -> f64 {
    let mut sum = 0.0;
    for k in 0..8usize {
        let (mut weight, mut index, mut stride) = (1.0, 0, 1);
        for axis in 0..3 {
            // Centre i is at i + 1 in interpolation cells.
            let x = (f64::from(s[axis]) - 1.0).clamp(0.0, (cells[axis] - 1) as f64);
            let (low, upper) = (x.floor(), k >> axis & 1 == 1);
            weight *= if upper { x - low } else { 1.0 - (x - low) };
            index += (low as usize + usize::from(upper)).min(cells[axis] - 1) * stride;
            stride *= cells[axis];
        }
        sum += weight * f64::from(values[index]);
    }
    sum
}

/// A position in the box; half of the coordinates are at a plane between blocks or a rounding beside it.
fn position(cells: [usize; 3], random: &mut Random) -> Vec3A {
    Vec3A::from_array(cells.map(|n| {
        let s = 0.5 + random.f32() * n as f32;
        let plane = (s / EDGE as f32).round() * EDGE as f32;
        let near = [plane, plane.next_down(), plane.next_up(), s, s, s][(random.f32() * 6.0) as usize];
        near.clamp(0.5, n as f32 + 0.5)
    }))
}

#[test]
fn lookups_are_interpolations_between_the_bounds_of_their_blocks() {
    let mut random = Random::new(21);
    for (cells, even) in SIZES.into_iter().flat_map(|cells| [(cells, false), (cells, true)]) {
        let values = if even { nearly_even(cells, &mut random) } else { sparse(cells, &mut random) };
        let blocks = Blocks::new(cells, &values);
        assert_eq!(blocks.most(), values.iter().copied().fold(0.0, f32::max));
        for _ in 0..250_000 {
            let s = position(cells, &mut random);
            let expected = by_definition(cells, &values, s);
            let (at, number) = blocks.around(s);
            let (bounds, low) = (blocks.bounds(number), at * EDGE as f32);
            let found = f64::from(blocks.lookup(number, bounds, s - low));
            // Seven interpolations, and the rounding of the position times the slope.
            let rounding = 16.0 * f64::from(f32::EPSILON) * f64::from(blocks.most());
            assert!((found - expected).abs() <= rounding, "{found}, expected {expected} at {s}");
            assert!((f64::from(bounds.least)..=f64::from(bounds.most)).contains(&found));
            // The bounds hold without the clamp to them, but for the last bit of f64.
            let slack = 4.0 * f64::EPSILON * f64::from(blocks.most());
            let (least, most) = (f64::from(bounds.least) - slack, f64::from(bounds.most) + slack);
            assert!((least..=most).contains(&expected), "{expected} at {s}, not in {least} to {most}");
        }
    }
}

/// A ray between two random points of a box somewhat larger than that of the grid.
fn ray(to_scene: &DAffine3, random: &mut Random) -> (Vec3, Vec3, f32) {
    let mut point = || to_scene.transform_point3(DVec3::from([(); 3].map(|()| random.f64() * 1.4 - 0.2)));
    let [a, b] = [point(), point()];
    (a.as_vec3(), (b - a).normalize().as_vec3(), (b - a).length() as f32)
}

fn placement() -> DAffine3 {
    DAffine3::from_rotation_x(0.7) * DAffine3::from_rotation_z(1.9) * DAffine3::from_scale(DVec3::new(2.0, 0.5, 1.3))
}

#[test]
fn skipping_empty_blocks_changes_no_bit() {
    let mut random = Random::new(22);
    for cells in SIZES {
        let values = sparse(cells, &mut random);
        let skipping = Blocks::new(cells, &values);
        let storing = Blocks::build(cells, &values, |_| true);
        if cells[0] > 30 {
            assert!(skipping.bytes() < storing.bytes(), "nothing is skipped");
        }
        let [skipping, storing] = [skipping, storing].map(|blocks| Grid::new(Arc::new(blocks), &placement()));
        for _ in 0..2000 {
            let (origin, w, length) = ray(&placement(), &mut random);
            let whole = skipping.depth(origin, w, length);
            assert_eq!(whole.to_bits(), storing.depth(origin, w, length).to_bits());
            let depth = 1.1 * whole * random.f32();
            assert_eq!(skipping.fly(origin, w, length, depth), storing.fly(origin, w, length, depth));
        }
    }
}

#[test]
fn blocks_of_one_value_have_their_integral() {
    let mut random = Random::new(23);
    let cells = [30, 17, 25];
    let values: Vec<f32> = (0..30 * 17 * 25).map(|i| if i % 30 > 15 { 3.0 } else { 0.5 }).collect();
    let storing = Grid::new(Arc::new(Blocks::build(cells, &values, |_| true)), &placement());
    let closed = Grid::new(Arc::new(Blocks::new(cells, &values)), &placement());
    for _ in 0..2000 {
        let (origin, w, length) = ray(&placement(), &mut random);
        let (found, expected) = (closed.depth(origin, w, length), storing.depth(origin, w, length));
        // At most 75 planes are crossed, each with a few roundings of a part and of the sum.
        let error = 75.0 * f32::EPSILON * expected.max(3.0 * length * 0.01);
        assert!((found - expected).abs() <= error, "{found}, expected {expected}");
        let depth = expected * random.f32();
        if let [Reach::Ends(t, a), Reach::Ends(u, b)] = [&closed, &storing].map(|g| g.fly(origin, w, length, depth)) {
            // The density is at least 0.5, and its slope at most 2.5 in a cell of 1/34 at least.
            let error = (error + 1e-5 * length) / 0.5;
            assert!((t - u).abs() <= error && (a - b).abs() <= 2.5 * 34.0 * 2.0 * error, "{t} {a}, expected {u} {b}");
        }
    }
}

/// Positions are computed near the box, so origins may be far from it.
#[test]
fn a_far_origin_costs_no_accuracy() {
    let grid = Grid::new(Arc::new(Blocks::new([64; 3], &[2.0; 64 * 64 * 64])), &DAffine3::IDENTITY);
    for distance in [1e2, 1e4, 1e6] {
        let origin = Vec3::new(-distance, 0.3, 0.6);
        assert!((grid.depth(origin, Vec3::X, f32::INFINITY) - 2.0).abs() < 1e-6);
    }
}
