//! Closed bodies with rays from inside: aimed at seams, built of slivers, at all scales and far from the origin.

use super::numbers::Numbers;
use super::shapes::{Faces, sphere, world};
use super::{HardCase, aimed, on_edge, some_triangle};
use crate::geometry::{Geometry, Ray, spawn_ray};
use glam::Vec3;

/// Number of sides of the tube; each is 1e6 times as long as wide.
const SIDES: u32 = 8192;
/// Radius of the tube, whose length is 1.
const BORE: f32 = 1e-3;
/// Scale at which all coordinates are subnormal, with at most 17 bits.
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
            // The range of f32 with room for squares.
            Ray { direction: ray.direction * n.magnitude(1e-10, 1e10), ..ray }
        }),
    ]
}

/// A sphere at many scales and offsets.
pub(super) fn scales() -> Vec<HardCase> {
    let at = |name, radius: f32, offset: f32| {
        // Inside despite rounding of the vertices: at 1e6 they move by 0.05, and rays start within 0.6 of the centre.
        let center = Vec3::new(1.0, -0.5, 0.75) * offset;
        HardCase::closed(name, world([sphere(3, radius, center)]), mixed(center, radius))
    };
    vec![
        at("scale-1e-40", SUBNORMAL, 0.0),
        // Named by scale or offset.
        at("scale-1e-12", 1e-12, 0.0),
        at("scale-1e8", 1e8, 0.0),
        at("offset-1e4", 1.0, 1e4),
        at("offset-1e5", 1.0, 1e5),
        at("offset-1e6", 1.0, 1e6),
    ]
}

/// Rays from inside a sphere: every second one at random, the others at edges.
fn mixed(center: Vec3, radius: f32) -> impl Fn(&Geometry, &mut Numbers) -> Ray + Send + Sync + 'static {
    move |geometry, numbers| {
        let origin = center + numbers.in_ball(0.6 * radius);
        if numbers.below(2) == 0 {
            return Ray::new(origin, numbers.direction());
        }
        // Divided by the radius, since very short directions, for which 1 / |d| overflows, are invalid.
        Ray::new(origin, (on_edge(geometry, 0, numbers) - origin) / radius)
    }
}

/// A ray spawned inward from the surface.
fn spawned_inward(geometry: &Geometry, numbers: &mut Numbers) -> Ray {
    let triangle = geometry.triangle(some_triangle(geometry, 0, numbers));
    let (p, error) = triangle.point(numbers.barycentric());
    let ng = triangle.scaled_normal().normalize().as_vec3();
    let d = numbers.direction();
    spawn_ray(p, error, ng, if d.dot(ng) < 0.0 { d } else { -d })
}

/// Triangles without area: two for each triangle of a sphere, and some collinear ones inside it.
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

/// A point of the unit circle by square roots only: four quarters of a chord, projected outward.
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

/// Hundreds of bodies at one place: half of them equal, the others each about half an ulp larger than the last.
fn overlapping() -> Geometry {
    let grown = |i: u32| 1.0 + f32::EPSILON * i.saturating_sub(200) as f32;
    world((0..400).map(|i| sphere(1, grown(i), Vec3::ZERO)))
}
