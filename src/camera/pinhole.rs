//! The pinhole camera.

use super::{CameraPoint, LensPoint, Pose, WiSample};
use crate::geometry::{Bodies, Bounds, Ray};
use etendue_lanes::{self as lanes, Float};
use glam::{Vec2, Vec3};

/// Perspective projection through a point.
#[derive(Debug, Clone)]
pub struct Pinhole {
    pose: Pose,
    /// Maps raster position to view plane at distance 1: x → scale.x x + corner.x to the right, y likewise upward.
    scale: Vec2,
    corner: Vec2,
    /// See [`super::CameraSample::medium`].
    medium: Option<Bodies>,
}

impl Pinhole {
    /// Creates a camera with vertical field of view `yfov` (radians) for square pixels on a `width` × `height` image.
    pub fn new(pose: Pose, yfov: f64, width: u32, height: u32) -> Self {
        let top = (yfov * 0.5).tan();
        let pixel = 2.0 * top / f64::from(height);
        let scale = Vec2::new(pixel as f32, -pixel as f32);
        let corner = Vec2::new((-0.5 * pixel * f64::from(width)) as f32, top as f32);
        Pinhole { pose, scale, corner, medium: None }
    }

    /// Returns the same view with pixels `ratio` times as large.
    pub(super) fn with_pixels(&self, ratio: Vec2) -> Self {
        Pinhole { scale: self.scale * ratio, ..self.clone() }
    }

    /// See [`super::CameraSample::medium`].
    #[inline]
    pub(super) fn medium(&self) -> Option<Bodies> {
        self.medium
    }

    /// See [`super::Camera::within`].
    pub(super) fn within(self, medium: Option<Bodies>) -> Self {
        Pinhole { medium, ..self }
    }

    /// See [`super::Camera::bounds`].
    pub(super) fn bounds(&self) -> Bounds {
        Bounds::around([self.pose.position])
    }

    /// See [`super::Camera::sample_wi`].
    #[inline]
    pub(super) fn sample_wi(&self, p: Vec3) -> Option<WiSample> {
        self.connect(p, CameraPoint { p: self.pose.position, lens: LensPoint::CENTRE }, Vec2::ZERO)
    }

    /// See [`super::Camera::sample_ray`].
    #[inline]
    pub(super) fn ray(&self, film: [f32; 2]) -> Ray {
        Ray::new(self.pose.position, self.direction(film, Vec2::ZERO))
    }

    /// Does [`Pinhole::ray`] in every lane; returns origins and directions.
    #[inline(always)]
    pub(super) fn rays<F: Float>(&self, [x, y]: [F; 2]) -> [lanes::Vec3<F>; 2] {
        let Pose { position, right, up, backward } = self.pose;
        let vector = |v: Vec3| lanes::Vec3::splat(v.to_array());
        let x = x * F::splat(self.scale.x) + F::splat(self.corner.x);
        let y = y * F::splat(self.scale.y) + F::splat(self.corner.y);
        let direction = vector(right) * x + vector(up) * y - vector(backward);
        [vector(position), direction.normalize()]
    }

    /// Returns the point that lies `offset` to the right and upward of the camera.
    #[inline]
    pub(super) fn beside(&self, offset: Vec2) -> Vec3 {
        let Pose { position, right, up, .. } = self.pose;
        position + right * offset.x + up * offset.y
    }

    /// Connects `p` to the point `eye` in the camera's plane; `None` behind the camera. The slopes of rays from `eye`
    /// are by `shift` less than those of the pinhole's rays through the same raster position.
    #[inline]
    pub(super) fn connect(&self, p: Vec3, eye: CameraPoint, shift: Vec2) -> Option<WiSample> {
        let Pose { right, up, backward, .. } = self.pose;
        let to = eye.p - p;
        let (depth, distance) = (to.dot(backward), to.length());
        // A direction of cosine c covers 1 / (pixel area c³) pixels per steradian [Veach97 §8.3.2].
        let importance = distance / ((self.scale.x * self.scale.y).abs() * depth.powi(3));
        let on_plane = Vec2::new(-to.dot(right), -to.dot(up)) / depth + shift;
        let film = (on_plane - self.corner) / self.scale;
        let seen = WiSample { film: film.to_array(), wi: to / distance, eye, importance };
        (depth > 0.0 && importance.is_finite()).then_some(seen)
    }

    /// Returns the unit direction of a raster position, with a slope reduced by `shift`: see [`Pinhole::connect`].
    #[inline]
    pub(super) fn direction(&self, film: [f32; 2], shift: Vec2) -> Vec3 {
        let v = Vec2::from(film) * self.scale + self.corner - shift;
        let Pose { right, up, backward, .. } = self.pose;
        let direction: Vec3 = right * v.x + up * v.y - backward;
        direction.normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_and_centre_of_the_image_look_where_the_field_of_view_says() {
        let pose = Pose { position: Vec3::ONE, right: Vec3::X, up: Vec3::Y, backward: Vec3::Z };
        let camera = Pinhole::new(pose, std::f64::consts::FRAC_PI_2, 200, 100);
        let along = |film, want: Vec3| {
            let got = camera.ray(film).direction;
            // Three roundings of the view-plane position and the normalisation.
            assert!((got - want.normalize()).length() < 4.0 * f32::EPSILON, "{film:?}: {got}");
        };
        along([100.0, 50.0], Vec3::new(0.0, 0.0, -1.0));
        along([0.0, 0.0], Vec3::new(-2.0, 1.0, -1.0));
        along([200.0, 100.0], Vec3::new(2.0, -1.0, -1.0));
    }
}
