//! Cameras: rays from positions on the film. One kind a file; to add one, write it and give it a variant in [`Camera`].

mod orthographic;
mod pinhole;

pub use orthographic::Orthographic;
pub use pinhole::Pinhole;

use crate::geometry::Ray;
use glam::Vec3;

/// A camera for an image of given size.
#[derive(Debug, Clone)]
pub enum Camera {
    /// All rays through one point.
    Pinhole(Pinhole),
    /// Parallel rays.
    Orthographic(Orthographic),
}

/// Position and axes of a camera in scene space: it looks along `−backward`.
#[derive(Debug, Clone, Copy)]
pub struct Pose {
    /// The eye.
    pub position: Vec3,
    /// Unit vector to the right of the image.
    pub right: Vec3,
    /// Unit vector to the top of the image.
    pub up: Vec3,
    /// Unit vector against the view.
    pub backward: Vec3,
}

/// How a camera sees a point.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    /// Where on the film, in pixels from the top left corner; not necessarily within the image.
    pub film: [f32; 2],
    /// Unit direction from the point to the camera.
    pub toward: Vec3,
    /// Where the segment ends that must be free.
    pub eye: Vec3,
    /// Pixels of film per unit of area at the point, perpendicular to `toward`.
    pub magnification: f32,
}

impl Camera {
    /// Where and how large the point `p` is seen; `None` behind the camera.
    #[inline]
    pub fn seen(&self, p: Vec3) -> Option<Seen> {
        match self {
            Camera::Pinhole(camera) => camera.seen(p),
            Camera::Orthographic(camera) => camera.seen(p),
        }
    }

    /// The ray through the film position (x, y) in pixels from the top left corner, with a unit direction.
    #[inline]
    pub fn ray(&self, film: [f32; 2]) -> Ray {
        match self {
            Camera::Pinhole(camera) => camera.ray(film),
            Camera::Orthographic(camera) => camera.ray(film),
        }
    }

    /// The same view on an image of `to` pixels in place of `from`.
    pub fn resized(&self, from: [u32; 2], to: [u32; 2]) -> Camera {
        let ratio = glam::Vec2::new(from[0] as f32 / to[0] as f32, from[1] as f32 / to[1] as f32);
        match self {
            Camera::Pinhole(camera) => Camera::Pinhole(camera.with_pixels(ratio)),
            Camera::Orthographic(camera) => Camera::Orthographic(camera.with_pixels(ratio)),
        }
    }
}
