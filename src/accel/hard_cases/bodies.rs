//! Closed bodies whose rays begin inside: aimed at seams, sewn of slivers, at every scale and far from the origin.

use super::numbers::Numbers;
use super::shapes::{Faces, sphere, world};
use super::{HardCase, aimed, on_edge, some_triangle};
use crate::geometry::{Geometry, Ray, spawn_ray};
use glam::Vec3;

/// Sides of the tube: they are 1e6 times as long as wide.
const SIDES: u32 = 8192;
/// Its radius; it is 1 long.
const BORE: f32 = 1e-3;
/// Coordinates that are all subnormal, of 17 bits and less.
const SUBNORMAL: f32 = 1e-40;

pub(super) fn cases() -> Vec<HardCase> {
    let ball = || world([sphere(4, 1.0, Vec3::ZERO)]);
    vec![
        HardCase::closed("sphere-random", ball(), |_, n| Ray::new(n.in_ball(0.9), n.direction())),
        HardCase::closed("sphere-edges", ball(), |geometry, n| aimed(n.in_ball(0.9), on_edge(geometry, 0, n))),
        HardCase::closed("sphere-vertices", ball(), |geometry, n| {
            let corners = geometry.triangle(some_triangle(geometry, 0, n)).vertices;
            aimed(n.in_ball(0.9), corners[0])
        }),
        HardCase::closed("sphere-spawned", ball(), spawned_inward),
        HardCase::closed("degenerate", world([sphere(3, 1.0, Vec3::ZERO), without_area()]), mixed(Vec3::ZERO, 1.0)),
        HardCase::closed("sliver-tube", world([tube()]), |_, n| {
            let along = Vec3::Z * (0.45 * n.signed());
            Ray::new(n.in_ball(0.5 * BORE) + along, n.direction())
        }),
        HardCase::closed("deep-overlap", overlapping(), mixed(Vec3::ZERO, 1.0)),
        HardCase::closed("unnormalised", ball(), |geometry, n| {
            let ray = mixed(Vec3::ZERO, 1.0)(geometry, n);
            // What f32 holds with room for squares.
            Ray { direction: ray.direction * n.magnitude(1e-10, 1e10), ..ray }
        }),
    ]
}

/// One sphere in many sizes and places.
pub(super) fn scales() -> Vec<HardCase> {
    let at = |name, radius: f32, offset: f32| {
        // Inside whatever rounding does to vertices: at 1e6 they are moved by 0.05, and rays begin within 0.6 of the centre.
        let center = Vec3::new(1.0, -0.5, 0.75) * offset;
        HardCase::closed(name, world([sphere(3, radius, center)]), mixed(center, radius))
    };
    vec![
        at("scale-1e-40", SUBNORMAL, 0.0),
        // Named by what they are.
        at("scale-1e-12", 1e-12, 0.0),
        at("scale-1e8", 1e8, 0.0),
        at("offset-1e4", 1.0, 1e4),
        at("offset-1e5", 1.0, 1e5),
        at("offset-1e6", 1.0, 1e6),
    ]
}

/// From inside of a sphere: one ray in two at random, the others at edges.
fn mixed(center: Vec3, radius: f32) -> impl Fn(&Geometry, &mut Numbers) -> Ray + Send + Sync + 'static {
    move |geometry, numbers| {
        let origin = center + numbers.in_ball(0.6 * radius);
        if numbers.below(2) == 0 {
            return Ray::new(origin, numbers.direction());
        }
        // Divided, since directions so short that 1 / |d| overflows are no directions.
        Ray::new(origin, (on_edge(geometry, 0, numbers) - origin) / radius)
    }
}

/// A ray spawned from the inside of the surface.
fn spawned_inward(geometry: &Geometry, numbers: &mut Numbers) -> Ray {
    let triangle = geometry.triangle(some_triangle(geometry, 0, numbers));
    let (p, error) = triangle.point(numbers.barycentric());
    let ng = triangle.scaled_normal().normalize().as_vec3();
    let d = numbers.direction();
    spawn_ray(p, error, ng, if d.dot(ng) < 0.0 { d } else { -d })
}

/// Triangles without area: two for each of a sphere, and some inside of it on a line.
fn without_area() -> Faces {
    let (mut positions, triangles) = sphere(3, 1.0, Vec3::ZERO);
    let mut needles: Vec<[u32; 3]> = triangles.iter().flat_map(|&[a, b, c]| [[a, a, b], [c, c, c]]).collect();
    let first = positions.len() as u32;
    positions.extend([Vec3::ZERO, Vec3::X * 0.25, Vec3::X * 0.5]);
    needles.extend([[first, first + 1, first + 2]; 100]);
    (positions, needles)
}

/// A closed tube along z.
fn tube() -> Faces {
    let mut positions = vec![Vec3::Z * -0.5, Vec3::Z * 0.5];
    for side in 0..SIDES {
        let (y, x) = octant(side);
        positions.extend([Vec3::new(BORE * x, BORE * y, -0.5), Vec3::new(BORE * x, BORE * y, 0.5)]);
    }
    let faces = (0..SIDES).flat_map(|side| {
        let [a, b] = [side, (side + 1) % SIDES].map(|side| 2 + 2 * side);
        [[a, b, b + 1], [a, b + 1, a + 1], [0, b, a], [1, a + 1, b + 1]]
    });
    (positions, faces.collect())
}

/// A point of the unit circle by square roots alone: four quarters of a chord, pushed out.
fn octant(side: u32) -> (f32, f32) {
    let quarter = SIDES / 4;
    let share = (side % quarter) as f32 / quarter as f32;
    let (x, y) = (1.0 - share, share);
    let length = (x * x + y * y).sqrt();
    let (x, y) = (x / length, y / length);
    match side / quarter {
        0 => (y, x),
        1 => (x, -y),
        2 => (-y, -x),
        _ => (-x, y),
    }
}

/// Hundreds of bodies in one place: half of them the same, half an ulp or so larger each than the last.
fn overlapping() -> Geometry {
    let grown = |i: u32| 1.0 + f32::EPSILON * i.saturating_sub(200) as f32;
    world((0..400).map(|i| sphere(1, grown(i), Vec3::ZERO)))
}
