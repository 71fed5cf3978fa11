//! The thin lens camera: a pinhole camera whose rays begin anywhere on a lens and meet in the plane of focus
//! [PBRT4 §5.2.3].

use super::{CameraPoint, LensPoint, Pinhole, WiSample};
use crate::geometry::{Bodies, Bounds, Ray};
use crate::sampling::warp;
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// Opening of a lens: a disk, or a regular polygon of the same area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ApertureShape {
    radius: f32,
    /// Number of sides of the polygon, at least 3; 0 for a disk.
    blades: u32,
    /// Angle of a corner of the polygon, counter-clockwise from the right as seen from behind the camera, in radians.
    rotation: f32,
}

impl ApertureShape {
    /// Creates an opening with the area of a disk of `radius` > 0, a polygon if `blades` is at least 3. `rotation` is
    /// the angle in radians by which the polygon is turned counter-clockwise from a corner on the right.
    pub fn new(radius: f32, blades: u32, rotation: f32) -> Self {
        ApertureShape { radius, blades: if blades < 3 { 0 } else { blades }, rotation }
    }

    /// Returns the area.
    fn area(&self) -> f64 {
        std::f64::consts::PI * f64::from(self.radius).powi(2)
    }

    /// Returns the distance of its farthest points from the centre.
    fn reach(&self) -> f32 {
        if self.blades == 0 {
            return self.radius;
        }
        // A polygon of n corners on the unit circle has the area n sin(2π/n) / 2.
        let step = TAU / self.blades as f32;
        self.radius * (TAU / (self.blades as f32 * step.sin())).sqrt()
    }

    /// Maps two uniform random numbers to a point, uniformly over the area.
    fn sample(&self, u: [f32; 2]) -> Vec2 {
        if self.blades == 0 {
            return warp::concentric_disk(u) * self.radius;
        }
        let blades = self.blades as f32;
        let side = (u[0] * blades).floor().min(blades - 1.0);
        let corner = |i: f32| Vec2::from_angle(self.rotation + TAU * i / blades) * self.reach();
        // Uniform over the triangle of the centre and two corners: the distance from the centre goes with a root.
        let along = (u[0] * blades - side).max(0.0).sqrt();
        corner(side).lerp(corner(side + 1.0), u[1]) * along
    }
}

/// Perspective projection through a lens without thickness.
#[derive(Debug, Clone)]
pub struct ThinLens {
    /// The camera at the centre of the lens.
    pinhole: Pinhole,
    aperture: ApertureShape,
    /// Inverse distance along the axis from the lens to the plane of focus.
    inverse_focus: f32,
}

impl ThinLens {
    /// Creates a camera with the rays of `pinhole` through the centre of its lens, focused on the plane at distance
    /// `focus` along the axis.
    pub fn new(pinhole: Pinhole, aperture: ApertureShape, focus: f32) -> Self {
        ThinLens { pinhole, aperture, inverse_focus: focus.recip() }
    }

    /// Returns the same view with pixels `ratio` times as large.
    pub(super) fn with_pixels(&self, ratio: Vec2) -> Self {
        ThinLens { pinhole: self.pinhole.with_pixels(ratio), ..*self }
    }

    /// See [`super::CameraSample::medium`].
    #[inline]
    pub(super) fn medium(&self) -> Option<Bodies> {
        self.pinhole.medium()
    }

    /// See [`super::Camera::within`].
    pub(super) fn within(self, medium: Option<Bodies>) -> Self {
        ThinLens { pinhole: self.pinhole.within(medium), ..self }
    }

    /// See [`super::Camera::bounds`].
    pub(super) fn bounds(&self) -> Bounds {
        let (centre, reach) = (self.pinhole.bounds().center(), self.aperture.reach());
        Bounds { min: centre - reach, max: centre + reach }
    }

    /// See [`super::Camera::sample_lens`].
    #[inline]
    pub(super) fn sample_lens(&self, u: [f32; 2]) -> LensPoint {
        LensPoint(self.aperture.sample(u))
    }

    /// See [`super::Camera::lens_pdf`].
    #[inline]
    pub(super) fn lens_pdf(&self) -> f64 {
        self.aperture.area().recip()
    }

    /// Returns the difference of slope, per unit of depth, of the rays from the centre of the lens and from `lens` to
    /// the same point of the plane of focus.
    #[inline]
    fn shift(&self, lens: LensPoint) -> Vec2 {
        lens.0 * self.inverse_focus
    }

    /// See [`super::Camera::sample_wi`].
    #[inline]
    pub(super) fn sample_wi(&self, p: Vec3, lens: LensPoint) -> Option<WiSample> {
        let eye = CameraPoint { p: self.pinhole.beside(lens.0), lens };
        self.pinhole.connect(p, eye, self.shift(lens))
    }

    /// See [`super::Camera::sample_ray`].
    #[inline]
    pub(super) fn ray(&self, film: [f32; 2], lens: LensPoint) -> Ray {
        Ray::new(self.pinhole.beside(lens.0), self.pinhole.direction(film, self.shift(lens)))
    }
}
