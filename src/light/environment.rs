//! Light from outside the scene, one kind a file. Rays that leave the scene find it, light sampling finds it by the same
//! density, and it may be hidden from the camera (the integrators' business).

use super::{Ball, EmissionNumbers, Emitted, LatLong, LightSample, Sky};
use crate::sampling::{Pdf, SolidAngle};
use crate::spectrum::Spectrum;
use glam::Vec3;

/// What surrounds the scene.
#[derive(Debug)]
pub enum Environment {
    /// The same radiance from every direction.
    Uniform(Sky),
    /// A picture of all directions; boxed, since lights by the million share the enum.
    Map(Box<LatLong>),
}

impl Environment {
    /// A direction toward it; `None` where rounding led to a direction without light.
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> Option<LightSample> {
        match self {
            Environment::Uniform(sky) => Some(sky.sample(u)),
            Environment::Map(map) => map.sample(u),
        }
    }

    /// The radiance that a ray finds which leaves the scene in the unit direction `w`, and the density with which
    /// [`Environment::sample`] would have made `w`.
    #[inline]
    pub fn along(&self, w: Vec3) -> (Spectrum, Pdf<SolidAngle>) {
        match self {
            Environment::Uniform(sky) => (sky.radiance, sky.pdf()),
            Environment::Map(map) => map.along(w),
        }
    }

    /// See [`super::Light::emit`].
    pub(super) fn emit(&self, ball: &Ball, u: &EmissionNumbers) -> Option<Emitted> {
        let sample = self.sample(u.direction)?;
        Some(ball.lit(sample.wi, sample.radiance / sample.density.value(), u.position))
    }

    /// What enters a sphere of `radius`, mean over the lanes; a map's rows being taken as linear in the height, as its density is.
    pub fn power(&self, radius: f32) -> f64 {
        match self {
            Environment::Uniform(sky) => sky.power(radius),
            Environment::Map(map) => map.power(radius),
        }
    }

    /// The largest radiance from any direction, mean over the lanes.
    pub(super) fn largest_radiance(&self) -> f64 {
        match self {
            Environment::Uniform(sky) => f64::from(sky.radiance.mean()),
            Environment::Map(map) => map.largest_radiance(),
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        match self {
            Environment::Uniform(_) => 0,
            Environment::Map(map) => map.bytes(),
        }
    }
}
