//! Instances: scaled, mirrored, sheared, stretched; and small objects on large ones.

use super::numbers::Numbers;
use super::shapes::{Faces, instances, plane, sphere, world};
use super::{HardCase, aimed, on_edge};
use crate::geometry::{Geometry, Ray};
use glam::{Affine3A, Mat3, Vec3};

/// Instances per case.
const COUNT: u64 = 40;
/// Half-width of the ground.
const GROUND: f32 = 1e6;
/// Radius of the spheres on the ground.
const SPECK: f32 = 1e-3;
/// Range of instance scales.
const SCALES: [f32; 2] = [1e-3, 1e3];

pub(super) fn cases() -> Vec<HardCase> {
    let scaled = |n: &mut Numbers| {
        Affine3A::from_mat3_translation(Mat3::IDENTITY * n.magnitude(SCALES[0], SCALES[1]), n.in_cube(50.0))
    };
    let bent = |n: &mut Numbers| Affine3A::from_mat3_translation(bent(n), n.in_cube(2.0));
    let stretched = |n: &mut Numbers| {
        let stretch = Vec3::new(n.magnitude(0.01, 100.0), n.magnitude(0.01, 100.0), n.magnitude(0.01, 100.0));
        Affine3A::from_mat3_translation(self::bent(n) * Mat3::from_diagonal(stretch), n.in_cube(2.0))
    };
    vec![
        HardCase::closed("instances-scaled", placed("scaled", scaled), from_inside),
        HardCase::closed("instances-bent", placed("bent", bent), from_inside),
        HardCase::closed("instances-stretched", placed("stretched", stretched), from_inside),
        HardCase::open("instances-outside", placed("bent", bent), |_, n| aimed(n.in_cube(8.0), n.in_cube(3.0))),
        HardCase::open("speck-on-ground", world([ground(), sphere(3, SPECK, Vec3::Z * SPECK)]), |_, n| {
            let origin = n.in_cube(10.0 * SPECK).abs() * n.any(&[1.0, 100.0]);
            let near = n.in_cube(2.0 * SPECK);
            let half = far_away(n);
            let far = n.in_cube(half) * Vec3::new(1.0, 1.0, 0.0);
            aimed(origin, if n.below(2) == 0 { near } else { far })
        }),
    ]
}

/// Distance from which the ground is viewed: from a few spheres' radii to its border.
fn far_away(numbers: &mut Numbers) -> f32 {
    numbers.magnitude(10.0 * SPECK, GROUND)
}

fn ground() -> Faces {
    plane(1, GROUND, 0.0)
}

/// Spheres of radius 1, placed.
fn placed(name: &str, place: impl Fn(&mut Numbers) -> Affine3A) -> Geometry {
    instances(sphere(2, 1.0, Vec3::ZERO), (0..COUNT).map(|i| place(&mut Numbers::new(name, i))).collect())
}

/// A linear map that rotates, shears and, in half of the cases, mirrors; its determinant is at least 0.1.
fn bent(numbers: &mut Numbers) -> Mat3 {
    loop {
        let m = Mat3::from_cols(numbers.in_cube(1.0), numbers.in_cube(1.0), numbers.in_cube(1.0));
        if m.determinant().abs() > 0.1 {
            return m;
        }
    }
}

/// A ray from well inside an instance, in a random direction or toward one of its edges.
fn from_inside(geometry: &Geometry, numbers: &mut Numbers) -> Ray {
    let object = numbers.below(geometry.objects.len());
    let placement = geometry.objects[object].placement.unwrap_or_default();
    let origin = placement.transform_point3(numbers.in_ball(0.5));
    let target = if numbers.below(2) == 0 {
        placement.transform_point3(numbers.direction())
    } else {
        on_edge(geometry, object as u32, numbers)
    };
    aimed(origin, target)
}
