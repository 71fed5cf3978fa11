//! Rays of light as they leave their lights, for walks that begin there.
//!
//! Positions are uniform over a light's area and directions follow the cosine, so that rays carry the same but for textures and the
//! falloff of spots. Light from infinity enters through a disk as wide as the scene, which touches it on the side that the light
//! comes from.

use super::{End, Light};
use crate::geometry::{Frame, Ray};
use crate::sampling::warp;
use crate::spectrum::Spectrum;
use glam::Vec3;
use std::f32::consts::PI;

/// A ball around everything that light may fall on.
#[derive(Debug, Clone, Copy)]
pub struct Ball {
    /// Its centre.
    pub centre: Vec3,
    /// Its radius.
    pub radius: f32,
}

/// What chooses a ray; each number uniform.
#[derive(Debug, Clone, Copy)]
pub struct EmissionNumbers {
    /// Front or back.
    pub side: f32,
    /// Where it leaves.
    pub position: [f32; 2],
    /// Where to.
    pub direction: [f32; 2],
}

/// A ray of light.
#[derive(Debug, Clone, Copy)]
pub struct Emitted {
    /// What it leaves.
    pub end: End,
    /// The ray, with a unit direction.
    pub ray: Ray,
    /// Watts that it stands for: radiance times cosine over the density of position and direction.
    pub power: Spectrum,
}

/// With which densities a light emits a ray, one after the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EmissionDensity {
    /// Of where it leaves, per area, or of the direction of light from infinity, per solid angle; 1 where there is no choice.
    pub end: f64,
    /// Of the direction, per solid angle, or of the place where light from infinity enters, per area perpendicular to it.
    pub ray: f64,
}

impl Light {
    /// The densities with which [`Light::emit`] makes a ray in the unit direction `w`, from wherever on the light.
    pub fn emission_density(&self, ball: &Ball, w: Vec3) -> EmissionDensity {
        let end = match self {
            Light::Point(_) | Light::Spot(_) | Light::Directional(_) => 1.0,
            Light::Area(light) => light.area_pdf(),
            Light::Environment(light) => f64::from(light.along(-w).1.value()),
        };
        EmissionDensity { end, ray: self.ray_density(ball, w) }
    }

    /// [`EmissionDensity::ray`] alone, for which an environment is not looked up.
    #[inline]
    pub fn ray_density(&self, ball: &Ball, w: Vec3) -> f64 {
        match self {
            Light::Point(_) => f64::from(warp::uniform_sphere_pdf().value()),
            Light::Spot(light) => light.emission_pdf(w),
            Light::Area(light) => light.emission_pdf(w),
            Light::Directional(_) | Light::Environment(_) => ball.disk_pdf(),
        }
    }

    /// A ray of this light into `ball`; `None` where it is dark.
    #[inline]
    pub fn emit(&self, ball: &Ball, u: &EmissionNumbers) -> Option<Emitted> {
        let emitted = match self {
            Light::Point(light) => Some(light.emit(u.direction)),
            Light::Spot(light) => light.emit(u.direction),
            Light::Directional(light) => Some(light.emit(ball, u.position)),
            Light::Area(light) => light.emit(u),
            Light::Environment(light) => light.emit(ball, u),
        };
        emitted.filter(|emitted| !emitted.power.is_black())
    }
}

impl Ball {
    /// Density per area of the disk through which light from infinity enters.
    pub(super) fn disk_pdf(&self) -> f64 {
        (std::f64::consts::PI * f64::from(self.radius).powi(2)).recip()
    }

    /// Light of `irradiance` on a surface perpendicular to it, from infinity along the unit vector `toward`.
    pub(super) fn lit(&self, toward: Vec3, irradiance: Spectrum, position: [f32; 2]) -> Emitted {
        let frame = Frame::around(toward);
        let disk = warp::concentric_disk(position);
        let origin = self.centre + (frame.s * disk.x + frame.t * disk.y + toward) * self.radius;
        let power = irradiance * (PI * self.radius * self.radius);
        Emitted { end: End::Infinity, ray: Ray::new(origin, -toward), power }
    }
}
