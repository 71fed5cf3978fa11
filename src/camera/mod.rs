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

/// Position and axes of a camera in scene space. The view direction is `−backward`.
#[derive(Debug, Clone, Copy)]
pub struct Pose {
    /// Eye point.
    pub position: Vec3,
    /// Unit vector to the right of the image.
    pub right: Vec3,
    /// Unit vector to the top of the image.
    pub up: Vec3,
    /// Unit vector opposite to the view direction.
    pub backward: Vec3,
}

/// Connection of a point to the camera.
#[derive(Debug, Clone, Copy)]
pub struct WiSample {
    /// Raster position, in pixels from the top left corner; not necessarily within the image.
    pub film: [f32; 2],
    /// Unit direction from the point to the camera.
    pub wi: Vec3,
    /// Endpoint of the segment to the camera.
    pub eye: Vec3,
    /// Pixels of film per unit of area at the point, perpendicular to `wi`.
    pub importance: f32,
}

impl Camera {
    /// Connects the point `p` to the camera; `None` behind the camera.
    #[inline]
    pub fn sample_wi(&self, p: Vec3) -> Option<WiSample> {
        match self {
            Camera::Pinhole(camera) => camera.sample_wi(p),
            Camera::Orthographic(camera) => camera.sample_wi(p),
        }
    }

    /// Returns the ray through the raster position (x, y) in pixels from the top left corner, with a unit direction.
    #[inline]
    pub fn ray(&self, film: [f32; 2]) -> Ray {
        match self {
            Camera::Pinhole(camera) => camera.ray(film),
            Camera::Orthographic(camera) => camera.ray(film),
        }
    }

    /// Returns the same view for an image of `to` pixels in place of `from`.
    pub fn resized(&self, from: [u32; 2], to: [u32; 2]) -> Camera {
        let ratio = glam::Vec2::new(from[0] as f32 / to[0] as f32, from[1] as f32 / to[1] as f32);
        match self {
            Camera::Pinhole(camera) => Camera::Pinhole(camera.with_pixels(ratio)),
            Camera::Orthographic(camera) => Camera::Orthographic(camera.with_pixels(ratio)),
        }
    }
}
