//! Rays and hits.

use super::Bodies;
use glam::Vec3;

/// The points `origin + t direction` with `t_min` ≤ t ≤ `t_max`. The direction need not have unit length.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    /// Origin.
    pub origin: Vec3,
    /// Direction; t is in units of its length.
    pub direction: Vec3,
    /// Least parameter.
    pub t_min: f32,
    /// Greatest parameter.
    pub t_max: f32,
    /// Time in the shutter interval, 0 to 1.
    pub time: f32,
    /// Bodies that contain the origin.
    pub bodies: Bodies,
    /// Touching surface that the ray leaves without an offset, or [`Hit::NONE`].
    pub left: Hit,
    /// Touching surface on which the ray ends without an offset, or [`Hit::NONE`].
    pub end: Hit,
}

impl Ray {
    /// Returns an infinite ray from `origin`, outside all bodies, at time 0.
    #[inline]
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Ray {
            origin,
            direction,
            t_min: 0.0,
            t_max: f32::INFINITY,
            time: 0.0,
            bodies: Bodies::NONE,
            left: Hit::NONE,
            end: Hit::NONE,
        }
    }

    /// Returns whether an end lies on a surface that touches another. Only the scene can trace such a ray.
    #[inline]
    pub fn touches(&self) -> bool {
        self.left != Hit::NONE || self.end != Hit::NONE
    }

    /// Returns the point at parameter `t`.
    #[inline]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}

/// The primitive hit by a ray. The hit point is not taken from the backend: [`super::Triangle::meet`] recomputes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Hit {
    /// Index into [`super::Geometry::objects`].
    pub object: u32,
    /// Index of the triangle in the object's mesh.
    pub primitive: u32,
}

impl Hit {
    /// No primitive.
    pub const NONE: Hit = Hit { object: u32::MAX, primitive: u32::MAX };
}
