//! Invalid and nearly invalid rays.

use super::HardCase;
use super::numbers::Numbers;
use super::shapes::{sphere, world};
use crate::geometry::Ray;
use glam::Vec3;

/// Replacements for a component.
const NOT_FINITE: [f32; 3] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];

pub(super) fn cases() -> Vec<HardCase> {
    let ball = || world([sphere(3, 1.0, Vec3::ZERO)]);
    vec![
        HardCase::open("not-finite", ball(), |_, n| not_finite(n)),
        HardCase::open("no-direction", ball(), |_, n| {
            let zero = Vec3::new(n.any(&[0.0, -0.0]), n.any(&[0.0, -0.0]), n.any(&[0.0, -0.0]));
            Ray::new(n.in_cube(1.5), zero)
        }),
        HardCase::open("no-length", ball(), |_, n| {
            let ends = [n.unit(), n.unit()];
            let (less, more) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            Ray { t_min: more, t_max: less, ..Ray::new(n.in_cube(1.5), n.direction()) }
        }),
    ]
}

/// A ray with one to six components that are not finite.
fn not_finite(numbers: &mut Numbers) -> Ray {
    let mut ray = Ray::new(numbers.in_cube(1.5), numbers.direction());
    for _ in 0..=numbers.below(6) {
        let (axis, odd) = (numbers.below(3), numbers.any(&NOT_FINITE));
        if numbers.below(2) == 0 { ray.origin[axis] = odd } else { ray.direction[axis] = odd }
    }
    ray
}
