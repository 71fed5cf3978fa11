//! The orthographic camera.

use super::{CameraPoint, LensPoint, Pose, WiSample};
use crate::geometry::Ray;
use glam::{Vec2, Vec3};

/// Parallel projection along the view direction.
#[derive(Debug, Clone)]
pub struct Orthographic {
    pose: Pose,
    scale: Vec2,
    corner: Vec2,
}

impl Orthographic {
    /// Creates a camera that covers `ymag` scene units above and below its axis, for square pixels on a
    /// `width` × `height` image.
    pub fn new(pose: Pose, ymag: f64, width: u32, height: u32) -> Self {
        let pixel = 2.0 * ymag / f64::from(height);
        let scale = Vec2::new(pixel as f32, -pixel as f32);
        let corner = Vec2::new((-0.5 * pixel * f64::from(width)) as f32, ymag as f32);
        Orthographic { pose, scale, corner }
    }

    /// Returns the same view with pixels `ratio` times as large.
    pub(super) fn with_pixels(&self, ratio: Vec2) -> Self {
        Orthographic { scale: self.scale * ratio, ..self.clone() }
    }

    /// See [`super::Camera::sample_wi`].
    #[inline]
    pub fn sample_wi(&self, p: Vec3) -> Option<WiSample> {
        let Pose { position, right, up, backward } = self.pose;
        let to = position - p;
        let depth = to.dot(backward);
        let film = (Vec2::new(-to.dot(right), -to.dot(up)) - self.corner) / self.scale;
        let importance = (self.scale.x * self.scale.y).abs().recip();
        let eye = CameraPoint { p: p + backward * depth, lens: LensPoint::CENTRE };
        let seen = WiSample { film: film.to_array(), wi: backward, eye, importance };
        (depth > 0.0 && importance.is_finite()).then_some(seen)
    }

    /// See [`super::Camera::ray`].
    #[inline]
    pub fn ray(&self, film: [f32; 2]) -> Ray {
        let v = Vec2::from(film) * self.scale + self.corner;
        let Pose { position, right, up, backward } = self.pose;
        Ray::new(position + right * v.x + up * v.y, -backward)
    }
}
