//! Rays and hits.

use super::Bodies;
use glam::Vec3;

/// What a ray carries from vertex to vertex besides its geometry. Every edge of a path has one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayState {
    /// Time in the shutter interval, 0 to 1.
    pub time: f32,
    /// Bodies that contain the place.
    pub bodies: Bodies,
}

impl RayState {
    /// Time 0, outside all bodies.
    pub const INITIAL: RayState = RayState { time: 0.0, bodies: Bodies::NONE };

    /// Returns the same state in `bodies`.
    #[inline]
    pub fn within(self, bodies: Bodies) -> Self {
        RayState { bodies, ..self }
    }
}

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
    /// What the ray carries besides its geometry, at its origin.
    pub state: RayState,
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
            state: RayState::INITIAL,
            left: Hit::NONE,
            end: Hit::NONE,
        }
    }

    /// Returns the same ray with `state`.
    #[inline]
    pub fn carrying(self, state: RayState) -> Self {
        Ray { state, ..self }
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
