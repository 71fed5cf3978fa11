//! The only place where a ray's origin is moved off the surface it leaves.

use crate::defects::{Defect, planted};
use crate::geometry::Ray;
use crate::numeric::BELOW_ONE;
use glam::Vec3;

/// What a backend's arithmetic may be off by at the far end of a segment, in units of its longest coordinate: a triangle test
/// moves vertices to the ray's origin and shears them (6 half ulps of the distance in each coordinate), divides and scales
/// heights (6 more).
const FAR_END: f32 = 12.0 * 0.5 * f32::EPSILON;

/// `p` moved along the normal `ng` to the side of `toward` by `error`, which covers the rounding of the sum too.
#[inline]
fn offset(p: Vec3, error: f32, ng: Vec3, toward: Vec3) -> Vec3 {
    // |ng|₁ ≥ 1 scales the bound from coordinates to the normal's direction [PBRT4 §6.8.6].
    let distance = error * ng.abs().element_sum();
    let shift = if toward.dot(ng) < 0.0 { ng * -distance } else { ng * distance };
    p + shift
}

/// A ray from the surface point `p` (known within `error`, geometric normal `ng`) in `direction`.
#[inline]
pub fn spawn_ray(p: Vec3, error: f32, ng: Vec3, direction: Vec3) -> Ray {
    Ray::new(offset(p, error, ng, direction), direction)
}

/// The segment from a surface point to the end point `to`, itself known within `to_error` on a surface of normal `to_ng`
/// (error 0 for a point in space). Parameters run from 0 to 1; neither end's own surface lies inside.
#[inline]
pub fn spawn_segment(p: Vec3, error: f32, ng: Vec3, to: Vec3, to_error: f32, to_ng: Vec3) -> Ray {
    let toward = to - p;
    let origin = offset(p, error, ng, toward);
    let far = FAR_END * toward.abs().max_element();
    let end =
        if to_error > 0.0 && !planted(Defect::SegmentMeetsItsEnd) { offset(to, to_error + far, to_ng, -toward) } else { to };
    let mut ray = Ray::new(origin, end - origin);
    ray.t_max = BELOW_ONE;
    ray
}
