//! Surface points for shading.

use super::spawn::touching_segment;
use crate::geometry::{Frame, Geometry, Hit, Ray, RayState, TriangleHit, leave, spawn_segment};
use glam::Vec3;

/// Intersection of a ray with a surface. Normals have unit length and are on the side of the triangle's
/// counter-clockwise winding.
#[derive(Debug, Clone, Copy)]
pub struct SurfacePoint {
    /// Position.
    pub p: Vec3,
    /// Offset of spawned rays along `ng`: see [`super::Triangle::point`].
    pub error: f32,
    /// Geometric normal.
    pub ng: Vec3,
    /// Frame around the shading normal `frame.n`, which is on the same side as `ng`.
    pub frame: Frame,
    /// Barycentric weights of the second and third vertex.
    pub barycentric: [f32; 2],
    /// The primitive.
    pub hit: Hit,
    /// Ray parameter.
    pub t: f32,
    /// Whether another surface touches this one here, so that spawned rays must not be offset.
    pub touching: bool,
    /// Whether the backend's hit agrees with the triangle: see [`super::TriangleHit::consistent`].
    pub consistent: bool,
}

impl SurfacePoint {
    /// Returns the intersection of `ray` with the primitive `hit`; `None` for a triangle without area or a ray in its
    /// plane.
    #[inline(always)] // callers keep the point in registers
    pub fn new(geometry: &Geometry, hit: Hit, ray: &Ray) -> Option<Self> {
        // Read before the triangle is met, so that their cache misses overlap.
        let normals = geometry.corner_normals(hit);
        let triangle = geometry.triangle(hit);
        let meet = triangle.meet(ray)?;
        let (p, error) = triangle.point(meet.barycentric);
        let winding = geometry.winding(hit.object);
        let ng = (meet.normal * (winding / meet.normal.length())).as_vec3();
        let ns = normals.and_then(|normals| geometry.interpolated(hit.object, normals, meet.barycentric));
        let ns = ns.map_or(ng, |ns| facing(ns, ng));
        let TriangleHit { barycentric, t, consistent, .. } = meet;
        Some(SurfacePoint { p, error, ng, frame: Frame::around(ns), barycentric, hit, t, touching: false, consistent })
    }

    /// Returns the shading normal of the primitive `hit` with the geometric normal `ng`, on the same side.
    #[inline]
    pub fn shading_normal(geometry: &Geometry, hit: Hit, barycentric: [f32; 2], ng: Vec3) -> Vec3 {
        geometry.shading_normal(hit, barycentric).map_or(ng, |n| facing(n, ng))
    }

    /// Returns |w·ng| for the unit direction `w`.
    #[inline]
    pub fn cos(&self, w: Vec3) -> f32 {
        w.dot(self.ng).abs()
    }

    /// Returns the primitive if another surface touches it here, else [`Hit::NONE`].
    #[inline]
    pub fn touched(&self) -> Hit {
        if self.touching { self.hit } else { Hit::NONE }
    }

    /// Returns a ray that leaves this point.
    #[inline]
    pub fn spawn(&self, direction: Vec3) -> Ray {
        leave(self.p, self.error, self.ng, self.touched(), direction)
    }

    /// Returns the open segment, in `state`, to a point `to` on a surface of normal `to_ng`, known within `to_error` (0
    /// for a point in space). `touched` is the primitive at `to` if another one touches it, or [`Hit::NONE`].
    #[inline]
    pub fn segment(&self, to: Vec3, to_error: f32, to_ng: Vec3, touched: Hit, state: RayState) -> Ray {
        match (self.touched(), touched) {
            (Hit::NONE, Hit::NONE) => spawn_segment(self.p, self.error, self.ng, to, to_error, to_ng).carrying(state),
            (left, end) => {
                touching_segment(self.p, left, self.error, self.ng, (to, to_error, to_ng), end).carrying(state)
            }
        }
    }
}

/// Flips `n` to the side of `reference`.
#[inline]
fn facing(n: Vec3, reference: Vec3) -> Vec3 {
    if n.dot(reference) < 0.0 { -n } else { n }
}
