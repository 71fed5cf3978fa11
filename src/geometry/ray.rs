//! A ray and what a backend says it hit.

use super::Bodies;
use glam::Vec3;

/// Points `origin + t direction` with `t_min` ≤ t ≤ `t_max`. The direction need not have unit length.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    /// Where the ray starts.
    pub origin: Vec3,
    /// Its direction; t is measured in units of its length.
    pub direction: Vec3,
    /// First parameter that counts.
    pub t_min: f32,
    /// Last parameter that counts.
    pub t_max: f32,
    /// Time in the shutter interval, 0 to 1.
    pub time: f32,
    /// The bodies that it starts in.
    pub bodies: Bodies,
    /// The touching surface that it leaves, from a point that was not moved off it; [`Hit::NONE`] if it leaves none.
    pub left: Hit,
    /// The touching surface on which it ends, at a point that was not moved off it; [`Hit::NONE`] if it ends on none.
    pub end: Hit,
}

impl Ray {
    /// A ray from `origin` without end, outside all bodies, at time 0.
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

    /// Whether one of its ends lies on a surface that touches another: only a scene can answer for such a ray.
    #[inline]
    pub fn touches(&self) -> bool {
        self.left != Hit::NONE || self.end != Hit::NONE
    }

    /// The point at parameter `t`.
    #[inline]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}

/// Which primitive a ray hit. Where on it is not the backend's word: [`super::Triangle::meet`] recomputes it.
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
