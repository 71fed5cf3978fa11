//! Exact order of surfaces that touch: rays and segments are intersected in f64 with the f32 triangles themselves, so
//! that a gap of one ulp is resolved and all backends agree.
//!
//! Surfaces that coincide within f64 rounding have an order too, which is the same from both sides. Each is treated as
//! set back from its front side by an infinitesimal amount that decreases with its position in the file. Of two that
//! face the same way, the later in the file is in front. Two that face each other, as a glass and the table under it,
//! do not intersect. A line never intersects the surfaces that it starts or ends on. Surfaces that coincide with these
//! lie on one side of them.

use crate::geometry::{Bounds, Geometry, Hit, Ray, Triangle};
use glam::DVec3;

/// Error bound of the height over a plane, in half-ulps of the largest coordinate: a difference, a dot product of three
/// terms, and the cross product of the normal, each doubled for the projection of an end of the line.
const ROUNDINGS: f64 = 64.0;

/// Relative widening of boxes by the largest coordinate. It exceeds the bound by which [`Line::cross`] widens
/// triangles, 8 half-ulps of f32 of the distance to the farthest vertex.
const BOX_PAD: f64 = 32.0 * 0.5 * f32::EPSILON as f64;

/// A ray or segment in f64.
#[derive(Debug, Clone, Copy)]
pub struct Line {
    origin: DVec3,
    direction: DVec3,
    /// Direction that determines sides: that of the ray, whose length may be zero between coincident surfaces.
    heading: DVec3,
    t_min: f64,
    t_max: f64,
    left: Option<Side>,
    end: Option<Side>,
}

/// Surface at an end of a line.
#[derive(Debug, Clone, Copy)]
struct Side {
    hit: Hit,
    triangle: Triangle,
    order: i128,
}

/// Intersection of a line with a triangle.
#[derive(Debug, Clone, Copy)]
pub struct Crossing {
    /// The triangle.
    pub hit: Hit,
    /// Parameter along the line.
    pub t: f64,
    /// |cos| of the angle to the normal, times the length of the direction.
    pub slope: f64,
    order: i128,
    /// Least barycentric coordinate; negative outside the triangle.
    margin: f64,
    noise: f64,
}

impl Line {
    /// Returns the line of `ray`. Ends on a touching surface are projected to its plane.
    pub fn new(geometry: &Geometry, ray: &Ray) -> Self {
        let (origin, heading) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let side = |hit: Hit| (hit != Hit::NONE).then(|| Side::new(geometry, hit, heading));
        let (left, end) = (side(ray.left), side(ray.end));
        let from = left.map_or(origin, |side| side.triangle.project(origin));
        let (t_min, t_max) = (f64::from(ray.t_min), f64::from(ray.t_max));
        let line = Line { origin: from, direction: heading, heading, t_min, t_max, left, end };
        let Some(last) = end else { return line };
        let to = last.triangle.project(origin + heading * t_max);
        Line { direction: to - from, t_max: 1.0, ..line }
    }

    /// Returns the intersection with `hit` between the ends of the line. The triangle is widened by the error bound of
    /// a backend, so that no ray leaks between two triangles that are tested by different routines.
    #[inline]
    pub fn cross(&self, geometry: &Geometry, hit: Hit, triangle: &Triangle) -> Option<Crossing> {
        let is_end = |side: &Option<Side>| side.is_some_and(|side| side.hit == hit);
        if is_end(&self.left) || is_end(&self.end) {
            return None;
        }
        let crossing = self.meet(geometry, hit, triangle)?;
        (crossing.margin >= -self.slack(triangle, &crossing) && self.holds(&crossing, triangle)).then_some(crossing)
    }

    /// Returns whether the line may intersect a triangle in the box before the parameter `reach`.
    #[inline]
    pub fn enters(&self, bounds: &Bounds, reach: f64) -> bool {
        let extent = bounds.min.abs().max(bounds.max.abs()).max_element();
        let pad = BOX_PAD * (f64::from(extent) + self.origin.abs().max_element());
        let inverse = self.direction.recip();
        let [low, high] =
            [bounds.min.as_dvec3() - pad, bounds.max.as_dvec3() + pad].map(|p| (p - self.origin) * inverse);
        let (near, far) = (low.min(high), low.max(high));
        let enter = near.max_element().max(if self.left.is_some() { -f64::INFINITY } else { self.t_min });
        let leave = far.min_element().min(if self.end.is_some() { f64::INFINITY } else { self.t_max.min(reach) });
        // A coordinate of 0 / 0 lies on a face of the box and is accepted.
        enter <= leave || enter.is_nan() || leave.is_nan()
    }

    /// Returns the intersection with the plane of `triangle`, which may be outside the triangle or beyond the ends of
    /// the line.
    pub fn meet(&self, geometry: &Geometry, hit: Hit, triangle: &Triangle) -> Option<Crossing> {
        let [a, b, c] = triangle.vertices.map(|v| v.as_dvec3());
        let (e1, e2, s) = (b - a, c - a, self.origin - a);
        let normal = e1.cross(e2);
        let area = normal.length();
        let slope = self.direction.dot(normal) / area;
        let noise = ROUNDINGS * 0.5 * f64::EPSILON * (s.length() + e1.length() + e2.length() + a.length());
        let (height, height_at_end) = (s.dot(normal) / area, (s + self.direction).dot(normal) / area);
        let t = if self.left.is_some() && height.abs() <= noise {
            0.0
        } else if self.end.is_some() && height_at_end.abs() <= noise {
            1.0
        } else {
            -height / slope
        };
        let at = s + self.direction * t;
        let (u, v) = (at.cross(e2).dot(normal) / (area * area), e1.cross(at).dot(normal) / (area * area));
        let margin = u.min(v).min(1.0 - u - v);
        let order = order(geometry, hit, self.heading.dot(normal));
        (t.is_finite() && margin.is_finite()).then_some(Crossing { hit, t, slope: slope.abs(), order, margin, noise })
    }

    /// Barycentric distance outside a triangle at which a backend may still report it. It grows at grazing angles. It
    /// does not apply to surfaces that coincide with an end, since no backend is queried for these.
    fn slack(&self, triangle: &Triangle, crossing: &Crossing) -> f64 {
        let [a, b, c] = triangle.vertices.map(|v| v.as_dvec3());
        let (e1, e2) = (b - a, c - a);
        let coincides = self.left.is_some() && crossing.is_at(0.0) || self.end.is_some() && crossing.is_at(1.0);
        let cos = if coincides { 1.0 } else { crossing.slope / self.direction.length() };
        triangle.backend_slack(self.origin - a, e1, e2) / (e1.cross(e2).length() * cos)
    }

    /// Returns whether a crossing lies between the ends of the line.
    #[inline]
    fn holds(&self, crossing: &Crossing, triangle: &Triangle) -> bool {
        let after = match &self.left {
            Some(side) if crossing.is_at(0.0) => crossing.order > side.order && crossing.is_apart(side, triangle),
            Some(_) => crossing.t > 0.0,
            None => crossing.t >= self.t_min,
        };
        let before = match &self.end {
            Some(side) if crossing.is_at(1.0) => crossing.order < side.order && crossing.is_apart(side, triangle),
            Some(_) => crossing.t < 1.0,
            None => crossing.t <= self.t_max,
        };
        after && before
    }
}

impl Crossing {
    /// Returns whether this crossing comes before `other` on their common line.
    #[inline]
    pub fn precedes(&self, other: &Crossing) -> bool {
        let coincide = (self.t - other.t).abs() * self.slope.min(other.slope) <= self.noise.max(other.noise);
        if coincide { self.order < other.order } else { self.t < other.t }
    }

    fn is_at(&self, t: f64) -> bool {
        (self.t - t).abs() * self.slope <= self.noise
    }

    /// Returns whether the crossing lies on another layer than `side`. An adjoining triangle of the same mesh is
    /// intersected only from within it.
    fn is_apart(&self, side: &Side, triangle: &Triangle) -> bool {
        self.hit.object != side.hit.object
            || !triangle.shares_vertex(&side.triangle)
            || self.margin > f64::from(f32::EPSILON)
    }
}

impl Side {
    fn new(geometry: &Geometry, hit: Hit, heading: DVec3) -> Self {
        let triangle = geometry.triangle(hit);
        Side { hit, triangle, order: order(geometry, hit, heading.dot(triangle.scaled_normal())) }
    }
}

/// Returns the rank of `hit` among coincident surfaces on a line; `along` is the component of the direction along the
/// winding normal.
#[inline]
fn order(geometry: &Geometry, hit: Hit, along: f64) -> i128 {
    let place = i128::from(hit.object) << 32 | i128::from(hit.primitive);
    let set_back = (1 << 64) - place;
    if along * geometry.winding(hit.object) < 0.0 { set_back } else { -set_back }
}
