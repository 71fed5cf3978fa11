//! Open geometries: random triangles, and triangles that overlap or are nearly coplanar with one another.

use super::numbers::Numbers;
use super::shapes::{Faces, apart, plane, soup, world};
use super::{HardCase, aimed, any_triangle};
use crate::geometry::{Geometry, Ray, spawn_ray};
use glam::{Vec2, Vec3};

/// Triangles of a soup, and the range of their sizes.
const COUNT: u32 = 2000;
const SIZES: [f32; 2] = [1e-3, 0.5];
/// Length over width of a sliver.
const ASPECT: f32 = 1e6;

pub(super) fn cases() -> Vec<HardCase> {
    let all = || world([soup(COUNT, SIZES[0], SIZES[1])]);
    let sheets = world([plane(16, 1.0, 0.0), plane(16, 1.0, 1.0 - f32::EPSILON), plane(16, 1.0, 1.0)]);
    vec![
        HardCase::open("random", all(), |_, n| across(n)),
        HardCase::open("surface-spawned", all(), spawned),
        HardCase::open("segments", all(), |_, n| {
            let ends = [n.unit(), n.unit()];
            Ray { t_min: 0.5 * ends[0] * ends[0], t_max: 1.5 * ends[1], ..across(n) }
        }),
        HardCase::open("from-vertices", all(), |geometry, n| {
            let corners = geometry.triangle(any_triangle(geometry, n)).vertices;
            Ray::new(n.any(&corners), n.direction())
        }),
        HardCase::open("far-origin", all(), |_, n| aimed(n.direction() * n.magnitude(1e2, 1e6), n.in_cube(1.0))),
        HardCase::open("coplanar-overlap", world([overlapping()]), |_, n| aimed(n.in_cube(1.0), flat(n, 1.2))),
        HardCase::open("parallel-sheets", sheets, |_, n| aimed(n.in_cube(1.0) * 3.0, n.in_cube(1.2))),
        HardCase::open("grazing-plane", world([plane(32, 1.0, 0.0)]), |_, n| {
            // Down to a millionth above the plane, the most grazing light of practical relevance.
            let height = n.magnitude(1e-6, 1e-2);
            aimed(flat(n, 1.0) + Vec3::Z * height, flat(n, 1.2))
        }),
        HardCase::open("slivers", world([slivers()]), |geometry, n| {
            let triangle = geometry.triangle(any_triangle(geometry, n));
            aimed(n.in_cube(2.0), triangle.point(n.barycentric()).0)
        }),
    ]
}

/// A ray between two points of a cube around the soup.
fn across(numbers: &mut Numbers) -> Ray {
    aimed(numbers.in_cube(1.5), numbers.in_cube(1.0))
}

/// A ray spawned from a surface, as in rendering.
fn spawned(geometry: &Geometry, numbers: &mut Numbers) -> Ray {
    let triangle = geometry.triangle(any_triangle(geometry, numbers));
    let (p, error) = triangle.point(numbers.barycentric());
    spawn_ray(p, error, triangle.scaled_normal().normalize_or_zero().as_vec3(), numbers.direction())
}

fn flat(numbers: &mut Numbers, half: f32) -> Vec3 {
    Vec2::new(numbers.signed(), numbers.signed()).extend(0.0) * half
}

/// Coplanar triangles that overlap at random.
fn overlapping() -> Faces {
    let mut numbers = Numbers::new("overlapping", 0);
    let positions = (0..3 * 400).map(|_| flat(&mut numbers, 1.0)).collect();
    (positions, apart(400))
}

/// Slivers of length 0.1 to 2.
fn slivers() -> Faces {
    let mut numbers = Numbers::new("slivers", 0);
    let mut positions = Vec::new();
    for _ in 0..COUNT {
        let (from, along) = (numbers.in_cube(1.0), numbers.direction() * numbers.magnitude(0.1, 2.0));
        let width = along.cross(numbers.direction()) / ASPECT;
        positions.extend([from, from + along, from + along * numbers.unit() + width]);
    }
    (positions, apart(COUNT))
}
