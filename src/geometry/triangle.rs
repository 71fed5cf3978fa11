//! Ray–triangle intersection, recomputed in f64 from the triangle itself: the result does not depend on the backend
//! that reported the hit.

use crate::geometry::Ray;
use etendue_lanes::{self as lanes, Double, Float};
use glam::{Affine3A, DVec3, Vec3};

/// Half an ulp of 1 in f32.
const HALF_ULP: f32 = f32::EPSILON * 0.5;

/// A world-space triangle.
#[derive(Debug, Clone, Copy)]
pub struct Triangle {
    /// The vertices, counter-clockwise seen from the front.
    pub vertices: [Vec3; 3],
    /// Bound of the coordinate error due to an instance transform, including the backend's arithmetic.
    placement_error: f32,
}

/// Intersection of a ray with a triangle.
#[derive(Debug, Clone, Copy)]
pub struct TriangleHit {
    /// Barycentric weights of the second and third vertex.
    pub barycentric: [f32; 2],
    /// Ray parameter.
    pub t: f32,
    /// Geometric normal of the winding, with a length of twice the area.
    pub normal: DVec3,
    /// Whether the hit lies in the triangle within the error of a backend's f32 arithmetic.
    pub consistent: bool,
}

impl Triangle {
    /// Returns a triangle from world-space vertices.
    #[inline]
    pub fn new(a: Vec3, b: Vec3, c: Vec3) -> Self {
        Triangle { vertices: [a, b, c], placement_error: 0.0 }
    }

    /// Returns a triangle of an instance.
    #[inline]
    pub fn placed(m: &Affine3A, a: Vec3, b: Vec3, c: Vec3) -> Self {
        let vertices = [a, b, c].map(|p| m.transform_point3(p));
        Triangle { vertices, placement_error: placement_error(m, a.abs().max(b.abs()).max(c.abs())) }
    }

    /// Returns the geometric normal, with a length of twice the area.
    #[inline]
    pub fn scaled_normal(&self) -> DVec3 {
        let [a, b, c] = self.vertices.map(Vec3::as_dvec3);
        (b - a).cross(c - a)
    }

    /// Projects `p` to the plane of the triangle; returns `p` itself if the triangle has no area.
    pub fn project(&self, p: DVec3) -> DVec3 {
        let n = self.scaled_normal().normalize_or_zero();
        p - n * n.dot(p - self.vertices[0].as_dvec3())
    }

    /// Returns the area.
    pub fn area(&self) -> f64 {
        self.scaled_normal().length() * 0.5
    }

    /// Returns the intersection with `ray`, which a backend reported to hit this triangle. Barycentrics are clamped, so
    /// that the point always lies on the triangle. `None` only for a triangle without area or a ray in its plane.
    #[inline]
    pub fn meet(&self, ray: &Ray) -> Option<TriangleHit> {
        let [a, b, c] = self.vertices.map(Vec3::as_dvec3);
        let meeting =
            Meeting::new([a.into(), b.into(), c.into()], ray.origin.as_dvec3().into(), ray.direction.as_dvec3().into());
        let Meeting { u, v, t, normal, inverse, .. } = meeting;
        if !inverse.is_finite() {
            return None;
        }
        let consistent = meeting.outside_by() <= 0.0 || {
            let [s, e1, e2] = meeting.offsets.map(DVec3::from);
            let bound = self.backend_slack(s, e1, e2) * ray.direction.as_dvec3().length() * inverse.abs();
            meeting.outside_by() <= bound
        };
        let [u, v] = clamped([u, v]);
        Some(TriangleHit { barycentric: [u as f32, v as f32], t: t as f32, normal: normal.into(), consistent })
    }

    /// Error bound of a backend's edge functions, without the factors |d| and 1 / det: 8 roundings of products of
    /// vertex offsets, plus the placement error of the two offsets of a product and of the ray.
    #[inline]
    pub(super) fn backend_slack(&self, s: DVec3, e1: DVec3, e2: DVec3) -> f64 {
        let reach2 = s.length_squared().max((s - e1).length_squared()).max((s - e2).length_squared());
        8.0 * f64::from(HALF_ULP) * reach2 + 3.0 * f64::from(self.placement_error) * reach2.sqrt()
    }

    /// Returns the point with the given barycentrics, and the offset of spawned rays along the normal that prevents
    /// self-intersection in the f32 arithmetic of any backend.
    ///
    /// In half-ulps: the point is rounded, a backend subtracts it from the vertices, and the offset rounds again (3 of
    /// the largest coordinate). The sum below rounds 3 times and a backend forms products of differences (8), each
    /// relative to the distance to the farthest vertex, which is at most the sum of the edges.
    #[inline]
    pub fn point(&self, barycentric: [f32; 2]) -> (Vec3, f32) {
        let [a, b, c] = self.vertices;
        let p = point_at([a.into(), b.into(), c.into()], barycentric).into();
        (p, self.error_at(p))
    }

    /// Returns the barycentric weights of the second and third vertex of the point `p` of the triangle, without bounds;
    /// not finite if the triangle has no area.
    #[inline]
    pub fn barycentric(&self, p: Vec3) -> [f64; 2] {
        let [a, b, c] = self.vertices.map(Vec3::as_dvec3);
        let (n, to) = (self.scaled_normal(), p.as_dvec3() - a);
        let n = n / n.length_squared();
        [to.cross(c - a).dot(n), (b - a).cross(to).dot(n)]
    }

    /// Returns the offset of [`Triangle::point`] for its point `p`.
    #[inline]
    pub fn error_at(&self, p: Vec3) -> f32 {
        let [a, b, c] = self.vertices;
        rounding_at([a.into(), b.into(), c.into()], p.into()) + self.placement_error
    }

    /// Returns the maximum of [`Triangle::error_at`] over the triangle.
    pub fn most_error(&self) -> f32 {
        let [a, b, c] = self.vertices;
        self.error_at(a.abs().max(b.abs()).max(c.abs()))
    }

    /// Returns whether the triangles share a vertex, by position.
    pub fn shares_vertex(&self, other: &Triangle) -> bool {
        self.vertices.iter().any(|a| other.vertices.contains(a))
    }
}

/// Intersections of rays with the planes of triangles, one of each a lane.
#[derive(Debug, Clone, Copy)]
pub struct Meeting<D> {
    /// Barycentric weight of the second vertex.
    pub u: D,
    /// Barycentric weight of the third vertex.
    pub v: D,
    /// Ray parameter.
    pub t: D,
    /// Geometric normal of the winding, with a length of twice the area.
    pub normal: lanes::Vec3<D>,
    /// 1 / det: not finite for a triangle without area or a ray in its plane.
    pub inverse: D,
    /// From the first vertex to the origin of the ray and to the other vertices.
    offsets: [lanes::Vec3<D>; 3],
}

impl<D: Double> Meeting<D> {
    /// Returns the intersections of rays with the triangles of these vertices.
    #[inline(always)]
    pub fn new([a, b, c]: [lanes::Vec3<D>; 3], origin: lanes::Vec3<D>, direction: lanes::Vec3<D>) -> Self {
        let (e1, e2, s) = (b - a, c - a, origin - a);
        let normal = e1.cross(e2);
        let inverse = D::splat(1.0) / -direction.dot(normal);
        let r = s.cross(direction);
        let (u, v, t) = (e2.dot(r) * inverse, -e1.dot(r) * inverse, s.dot(normal) * inverse);
        Meeting { u, v, t, normal, inverse, offsets: [s, e1, e2] }
    }

    /// Returns the barycentric distance outside the triangle; not positive inside.
    #[inline(always)]
    pub fn outside_by(&self) -> D {
        (-self.u).max(-self.v).max(self.u + self.v - D::splat(1.0))
    }
}

/// Moves barycentric weights into the triangle.
#[inline(always)]
pub fn clamped<D: Double>([u, v]: [D; 2]) -> [D; 2] {
    let (zero, one) = (D::splat(0.0), D::splat(1.0));
    let u = u.max(zero).min(one);
    [u, v.max(zero).min(one - u)]
}

/// Returns the points of triangles with these vertices at `barycentric`.
#[inline(always)]
pub fn point_at<F: Float>([a, b, c]: [lanes::Vec3<F>; 3], [u, v]: [F; 2]) -> lanes::Vec3<F> {
    a + ((b - a) * u + (c - a) * v)
}

/// Returns the offset of [`Triangle::point`] for the points `p` of triangles in world space.
#[inline(always)]
pub fn rounding_at<F: Float>([a, b, c]: [lanes::Vec3<F>; 3], p: lanes::Vec3<F>) -> F {
    let reach = ((b - a).abs() + (c - a).abs()).max_element();
    F::splat(HALF_ULP) * (F::splat(4.0) * p.abs().max_element() + F::splat(12.0) * reach)
}

/// Error bound of placement by `m` for a coordinate of a point whose own coordinates are at most `most`. The transform
/// rounds each coordinate three times relative to the terms of its sum: once for the point, and once for the ray in the
/// backend's object space, whose error is scaled by the condition of the transform.
#[inline]
pub fn placement_error(m: &Affine3A, most: Vec3) -> f32 {
    let columns = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis].map(|axis| axis.abs().element_sum());
    16.0 * HALF_ULP * (most.dot(Vec3::from(columns)) + m.translation.abs().max_element())
}

/// Returns whether `m` can place an object: it is finite and invertible in f32. Beyond a scale of 7e12 the determinant
/// overflows. The inverse would then be zero, and every ray would miss.
pub fn is_placement(m: &Affine3A) -> bool {
    m.is_finite() && m.matrix3.determinant().is_finite() && m.inverse().is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn placements_without_inverse_in_f32_are_refused() {
        let scaled = |scale: f32| is_placement(&Affine3A::from_scale(Vec3::splat(scale)));
        assert!(scaled(1e12) && scaled(-1e-12) && scaled(1.0));
        assert!(!scaled(1e15) && !scaled(1e-15) && !scaled(0.0) && !scaled(f32::NAN) && !scaled(f32::INFINITY));
        assert!(!is_placement(&Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.0))));
    }

    #[test]
    fn a_hit_is_where_the_ray_meets_the_plane() {
        let triangle = Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y);
        let ray = Ray::new(Vec3::new(0.25, 0.5, 2.0), Vec3::new(0.0, 0.0, -4.0));
        let hit = triangle.meet(&ray).expect("not parallel");
        assert_eq!((hit.barycentric, hit.t, hit.consistent), ([0.25, 0.5], 0.5, true));
    }

    #[test]
    fn false_hit_is_flagged_and_its_point_stays_on_the_triangle() {
        let triangle = Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y);
        let hit = triangle.meet(&Ray::new(Vec3::new(2.0, -1.0, 1.0), -Vec3::Z)).expect("not parallel");
        assert!(!hit.consistent);
        assert_eq!(hit.barycentric, [1.0, 0.0]);
    }

    #[test]
    fn a_ray_in_the_plane_or_a_triangle_without_area_has_no_hit() {
        let triangle = Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y);
        assert!(triangle.meet(&Ray::new(Vec3::NEG_X, Vec3::X)).is_none());
        assert!(Triangle::new(Vec3::X, Vec3::X, Vec3::X).meet(&Ray::new(Vec3::Z, -Vec3::Z)).is_none());
    }
}
