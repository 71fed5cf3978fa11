//! Cameras: rays from positions on the film. One kind a file; to add one, write it and give it a variant in [`Camera`].

mod orthographic;
mod pinhole;
mod thin_lens;

pub use orthographic::Orthographic;
pub use pinhole::Pinhole;
pub use thin_lens::{ApertureShape, ThinLens};

use crate::geometry::{Bodies, Bounds, Ray};
use etendue_lanes::{self as lanes, Float};
use glam::{Vec2, Vec3};

/// A camera for an image of given size.
#[derive(Debug, Clone)]
pub enum Camera {
    /// All rays through one point.
    Pinhole(Pinhole),
    /// Rays through a lens.
    ThinLens(ThinLens),
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

/// A point of the lens by its offset from the centre, in scene units to the right and upward. A camera without a lens
/// has the centre alone.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LensPoint(Vec2);

impl LensPoint {
    /// The centre of the lens.
    pub const CENTRE: LensPoint = LensPoint(Vec2::ZERO);
}

/// Camera endpoint of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraPoint {
    /// Position.
    pub p: Vec3,
    /// Point of the lens.
    pub lens: LensPoint,
}

/// Connection of a point to the camera.
#[derive(Debug, Clone, Copy)]
pub struct WiSample {
    /// Raster position, in pixels from the top left corner; not necessarily within the image.
    pub film: [f32; 2],
    /// Unit direction from the point to the camera.
    pub wi: Vec3,
    /// Endpoint of the segment to the camera.
    pub eye: CameraPoint,
    /// Importance We over [`Camera::lens_pdf`]: pixels of film per unit of area at the point, perpendicular to `wi`, as
    /// seen from the point of the lens.
    pub importance: f32,
}

/// First edge of a camera subpath.
#[derive(Debug, Clone, Copy)]
pub struct CameraSample {
    /// Raster position, in pixels from the top left corner.
    pub film: [f32; 2],
    /// Point of the lens where the ray begins.
    pub lens: LensPoint,
    /// Ray with a unit direction.
    pub ray: Ray,
    /// Bodies that contain the origin, if they contain the whole camera; `None` if the scene must be asked.
    pub medium: Option<Bodies>,
}

impl Camera {
    /// Connects the point `p` to the point `lens` of the lens; `None` behind the camera.
    #[inline]
    pub fn sample_wi(&self, p: Vec3, lens: LensPoint) -> Option<WiSample> {
        match self {
            Camera::Pinhole(camera) => camera.sample_wi(p),
            Camera::ThinLens(camera) => camera.sample_wi(p, lens),
            Camera::Orthographic(camera) => camera.sample_wi(p),
        }
    }

    /// Samples a point of the lens, uniformly over its area. The random numbers `u` are not asked of cameras without a
    /// lens.
    #[inline]
    pub fn sample_lens(&self, u: impl FnOnce() -> [f32; 2]) -> LensPoint {
        match self {
            Camera::Pinhole(_) | Camera::Orthographic(_) => LensPoint::CENTRE,
            Camera::ThinLens(camera) => camera.sample_lens(u()),
        }
    }

    /// Returns the density per area of [`Camera::sample_lens`]; 1 where there is no choice.
    #[inline]
    pub fn lens_pdf(&self) -> f64 {
        match self {
            Camera::Pinhole(_) | Camera::Orthographic(_) => 1.0,
            Camera::ThinLens(camera) => camera.lens_pdf(),
        }
    }

    /// Returns the first edge of a camera subpath from the point `lens` of the lens through the raster position `film`,
    /// (x, y) in pixels from the top left corner, at `time`.
    #[inline]
    pub fn sample_ray(&self, film: [f32; 2], lens: LensPoint, time: f32) -> CameraSample {
        let (mut ray, medium) = match self {
            Camera::Pinhole(camera) => (camera.ray(film), camera.medium()),
            Camera::ThinLens(camera) => (camera.ray(film, lens), camera.medium()),
            Camera::Orthographic(camera) => (camera.ray(film), None),
        };
        ray.state.time = time;
        CameraSample { film, lens, ray, medium }
    }

    /// Returns origins and directions of the rays through raster positions in lanes, and the bodies that contain the
    /// camera: see [`CameraSample::medium`]. `None` for cameras other than the pinhole.
    #[inline(always)]
    pub fn pinhole_rays<F: Float>(&self, film: [F; 2]) -> Option<([lanes::Vec3<F>; 2], Option<Bodies>)> {
        match self {
            Camera::Pinhole(camera) => Some((camera.rays(film), camera.medium())),
            Camera::ThinLens(_) | Camera::Orthographic(_) => None,
        }
    }

    /// Returns the ray through the centre of the lens and a raster position at time 0.
    #[inline]
    pub fn ray(&self, film: [f32; 2]) -> Ray {
        self.sample_ray(film, LensPoint::CENTRE, 0.0).ray
    }

    /// Returns the box around all points where rays begin, unless it depends on the size of the image.
    pub fn bounds(&self) -> Option<Bounds> {
        match self {
            Camera::Pinhole(camera) => Some(camera.bounds()),
            Camera::ThinLens(camera) => Some(camera.bounds()),
            Camera::Orthographic(_) => None,
        }
    }

    /// Returns the same camera with the bodies that contain all of it, if they are known: see [`CameraSample::medium`].
    #[must_use]
    pub fn within(self, medium: Option<Bodies>) -> Camera {
        match self {
            Camera::Pinhole(camera) => Camera::Pinhole(camera.within(medium)),
            Camera::ThinLens(camera) => Camera::ThinLens(camera.within(medium)),
            Camera::Orthographic(_) => self,
        }
    }

    /// Returns the same view for an image of `to` pixels in place of `from`.
    pub fn resized(&self, from: [u32; 2], to: [u32; 2]) -> Camera {
        let ratio = glam::Vec2::new(from[0] as f32 / to[0] as f32, from[1] as f32 / to[1] as f32);
        match self {
            Camera::Pinhole(camera) => Camera::Pinhole(camera.with_pixels(ratio)),
            Camera::ThinLens(camera) => Camera::ThinLens(camera.with_pixels(ratio)),
            Camera::Orthographic(camera) => Camera::Orthographic(camera.with_pixels(ratio)),
        }
    }
}
