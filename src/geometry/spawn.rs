//! Ray origin offsets. No other code moves the origin of a ray off its surface.

use crate::geometry::{Hit, Ray, Triangle};
use crate::numeric::BELOW_ONE;
use etendue_lanes::{self as lanes, Float};
use glam::Vec3;

/// Error bound of a backend at the far end of a segment, relative to its largest coordinate. A triangle test moves
/// vertices to the ray's origin and shears them (6 half-ulps of the distance in each coordinate), then divides and
/// scales heights (6 more).
const FAR_END: f32 = 12.0 * 0.5 * f32::EPSILON;

/// Moves `p` by `error` along the normal `ng` to the side of `toward`; `error` includes the rounding of the sum.
#[inline(always)]
pub fn offset<F: Float>(p: lanes::Vec3<F>, error: F, ng: lanes::Vec3<F>, toward: lanes::Vec3<F>) -> lanes::Vec3<F> {
    // |ng|₁ ≥ 1 converts the bound from coordinates to the direction of the normal [PBRT4 §6.8.6].
    let distance = error * ng.abs().element_sum();
    let behind = toward.dot(ng).below(F::splat(0.0));
    p + ng * F::select(behind, -distance, distance)
}

/// Returns origin and direction of the open segments from the surface points `p` to the surface points `to`: see
/// [`spawn_segment`].
#[inline(always)]
pub fn segment<F: Float>(
    [p, ng]: [lanes::Vec3<F>; 2],
    error: F,
    [to, to_ng]: [lanes::Vec3<F>; 2],
    to_error: F,
) -> [lanes::Vec3<F>; 2] {
    let toward = to - p;
    let origin = offset(p, error, ng, toward);
    let far = F::splat(FAR_END) * toward.abs().max_element();
    let end = offset(to, to_error + far, to_ng, -toward);
    [origin, end - origin]
}

/// [`offset`] at one lane.
#[inline]
fn moved(p: Vec3, error: f32, ng: Vec3, toward: Vec3) -> Vec3 {
    offset(p.into(), error, ng.into(), toward.into()).into()
}

/// Returns a ray from the surface point `p` (error bound `error`, geometric normal `ng`) in `direction`.
#[inline]
pub fn spawn_ray(p: Vec3, error: f32, ng: Vec3, direction: Vec3) -> Ray {
    Ray::new(moved(p, error, ng, direction), direction)
}

/// Returns a ray from a surface point, offset as in [`spawn_ray`]; without an offset if another surface touches
/// `touched` there.
#[inline]
pub fn leave(p: Vec3, error: f32, ng: Vec3, touched: Hit, direction: Vec3) -> Ray {
    if touched == Hit::NONE {
        spawn_ray(p, error, ng, direction)
    } else {
        Ray { left: touched, ..Ray::new(p, direction) }
    }
}

/// Returns the segment from a surface point to the end point `to`, which lies on a surface of normal `to_ng` within
/// `to_error` (0 for a point in space). Parameters run from 0 to 1, exclusive of the surfaces at both ends.
#[inline]
pub fn spawn_segment(p: Vec3, error: f32, ng: Vec3, to: Vec3, to_error: f32, to_ng: Vec3) -> Ray {
    let [origin, direction] = if to_error > 0.0 {
        let [origin, direction] = segment([p.into(), ng.into()], error, [to.into(), to_ng.into()], to_error);
        [origin.into(), direction.into()]
    } else {
        let origin = moved(p, error, ng, to - p);
        [origin, to - origin]
    };
    Ray { t_max: BELOW_ONE, ..Ray::new(origin, direction) }
}

/// Returns the segment between two points, of which at least one lies on a surface that touches another. `left` and
/// `end` name these surfaces; the segment has no offset there. See [`clear_of`].
#[cold]
pub(super) fn touching_segment(p: Vec3, left: Hit, error: f32, ng: Vec3, to: (Vec3, f32, Vec3), end: Hit) -> Ray {
    let (to, to_error, to_ng) = to;
    let toward = to - p;
    let origin = if left == Hit::NONE { moved(p, error, ng, toward) } else { p };
    let far = FAR_END * toward.abs().max_element();
    let to = if end == Hit::NONE && to_error > 0.0 { moved(to, to_error + far, to_ng, -toward) } else { to };
    Ray { t_max: BELOW_ONE, left, end, ..Ray::new(origin, to - origin) }
}

/// Offsets the ends of `ray` that lie on the surfaces `left` and `end`, if there are such, by the usual distance.
pub fn clear_of(ray: &Ray, left: Option<&Triangle>, end: Option<&Triangle>) -> Ray {
    let normal = |triangle: &Triangle| triangle.scaled_normal().normalize_or_zero().as_vec3();
    let origin = left.map_or(ray.origin, |t| moved(ray.origin, t.error_at(ray.origin), normal(t), ray.direction));
    let free = Ray { origin, left: Hit::NONE, end: Hit::NONE, ..*ray };
    let Some(last) = end else { return free };
    let to = ray.at(ray.t_max);
    let error = last.error_at(to) + FAR_END * (to - ray.origin).abs().max_element();
    let to = moved(to, error, normal(last), -ray.direction);
    Ray { direction: to - origin, t_max: BELOW_ONE, ..free }
}
