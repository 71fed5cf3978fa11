//! Emission sampling: rays that start light subpaths.
//!
//! Positions are uniform over the area of a light, or in proportion to its emission by a table, and directions
//! cosine-distributed, so that rays carry about equal power except for spot falloff. Light from infinity enters through a disk with the scene radius, tangent to
//! the bounding sphere on the side of the light.

use super::{EmitterPoint, Light};
use crate::geometry::{Frame, Ray};
use crate::sampling::warp;
use crate::spectrum::Spectrum;
use glam::Vec3;
use std::f32::consts::PI;

/// Bounding sphere of everything that light can reach.
#[derive(Debug, Clone, Copy)]
pub struct BoundingSphere {
    /// Centre.
    pub centre: Vec3,
    /// Radius.
    pub radius: f32,
}

/// Random numbers of a ray, each uniform.
#[derive(Debug, Clone, Copy)]
pub struct LeRandom {
    /// Selects front or back.
    pub side: f32,
    /// Selects the origin.
    pub position: [f32; 2],
    /// Selects the direction.
    pub direction: [f32; 2],
}

/// A sampled light ray.
#[derive(Debug, Clone, Copy)]
pub struct LeSample {
    /// Emitter endpoint.
    pub end: EmitterPoint,
    /// Ray with a unit direction.
    pub ray: Ray,
    /// Power in watts: radiance times cosine over the density of position and direction.
    pub power: Spectrum,
}

/// Densities of emission sampling, conditional in this order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LePdf {
    /// Density of the origin per area, or of the direction of light from infinity per solid angle; 1 where there is no
    /// choice.
    pub position: f64,
    /// Density of the direction per solid angle, or of the entry point of light from infinity per perpendicular area.
    pub direction: f64,
}

impl Light {
    /// Returns the densities of [`Light::sample_le`] for the endpoint `end` and the unit direction `w`.
    pub fn pdf_le(&self, ball: &BoundingSphere, end: &EmitterPoint, w: Vec3) -> LePdf {
        let position = match (self, end) {
            (Light::Area(light), EmitterPoint::Surface { p, .. }) => f64::from(light.area_pdf(*p).value()),
            (Light::Environment(light), _) => f64::from(light.along(-w).1.value()),
            _ => 1.0,
        };
        LePdf { position, direction: self.ray_density(ball, w) }
    }

    /// Returns [`LePdf::direction`] alone, without a lookup of the environment.
    #[inline]
    pub fn ray_density(&self, ball: &BoundingSphere, w: Vec3) -> f64 {
        match self {
            Light::Point(_) => f64::from(warp::uniform_sphere_pdf().value()),
            Light::Spot(light) => light.emission_pdf(w),
            Light::Area(light) => light.emission_pdf(w),
            Light::Directional(_) | Light::Environment(_) => ball.disk_pdf(),
        }
    }

    /// Samples a ray of this light into `ball`; `None` if it carries no light.
    #[inline]
    pub fn sample_le(&self, ball: &BoundingSphere, u: &LeRandom) -> Option<LeSample> {
        let emitted = match self {
            Light::Point(light) => Some(light.sample_le(u.direction)),
            Light::Spot(light) => light.sample_le(u.direction),
            Light::Directional(light) => Some(light.sample_le(ball, u.position)),
            Light::Area(light) => light.sample_le(u),
            Light::Environment(light) => light.sample_le(ball, u),
        };
        emitted.filter(|emitted| !emitted.power.is_black())
    }
}

impl BoundingSphere {
    /// Returns the density per area on the disk through which light from infinity enters.
    pub(super) fn disk_pdf(&self) -> f64 {
        (std::f64::consts::PI * f64::from(self.radius).powi(2)).recip()
    }

    /// Samples a ray from infinity along the unit vector `toward`, with `irradiance` on a perpendicular surface.
    pub(super) fn lit(&self, toward: Vec3, irradiance: Spectrum, position: [f32; 2]) -> LeSample {
        let frame = Frame::around(toward);
        let disk = warp::concentric_disk(position);
        let origin = self.centre + (frame.s * disk.x + frame.t * disk.y + toward) * self.radius;
        let power = irradiance * (PI * self.radius * self.radius);
        LeSample { end: EmitterPoint::Distant, ray: Ray::new(origin, -toward), power }
    }
}
