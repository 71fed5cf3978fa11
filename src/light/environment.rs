//! Light from outside the scene, one kind a file. Rays that leave the scene evaluate it, and light sampling uses the
//! same density. Integrators may hide it from the camera.

use super::{BoundingSphere, ConstantEnvironment, EnvironmentMap, LeRandom, LeSample, LightSample};
use crate::sampling::{Pdf, SolidAngle};
use crate::spectrum::Spectrum;
use glam::Vec3;

/// Environment light.
#[derive(Debug)]
pub enum Environment {
    /// Uniform radiance.
    Uniform(ConstantEnvironment),
    /// Radiance map; boxed, since scenes with millions of lights share the enum.
    Map(Box<EnvironmentMap>),
}

impl Environment {
    /// Samples a direction; `None` where rounding led to a direction without light.
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> Option<LightSample> {
        match self {
            Environment::Uniform(sky) => Some(sky.sample(u)),
            Environment::Map(map) => map.sample(u),
        }
    }

    /// Returns the radiance along a ray that leaves the scene in the unit direction `w`, and the density of `w` under
    /// [`Environment::sample`].
    #[inline]
    pub fn along(&self, w: Vec3) -> (Spectrum, Pdf<SolidAngle>) {
        match self {
            Environment::Uniform(sky) => (sky.radiance, sky.pdf()),
            Environment::Map(map) => map.along(w),
        }
    }

    /// See [`super::Light::sample_le`].
    pub(super) fn sample_le(&self, ball: &BoundingSphere, u: &LeRandom) -> Option<LeSample> {
        let sample = self.sample(u.direction)?;
        Some(ball.lit(sample.wi, sample.radiance / sample.density.value(), u.position))
    }

    /// Returns the power into a sphere of `radius`, mean over lanes. For a map, rows are interpolated linearly in
    /// height, as in its density.
    pub fn power(&self, radius: f32) -> f64 {
        match self {
            Environment::Uniform(sky) => sky.power(radius),
            Environment::Map(map) => map.power(radius),
        }
    }

    /// Returns the largest radiance over all directions, mean over lanes.
    pub(super) fn largest_radiance(&self) -> f64 {
        match self {
            Environment::Uniform(sky) => f64::from(sky.radiance.mean()),
            Environment::Map(map) => map.largest_radiance(),
        }
    }

    /// Returns the memory held, in bytes.
    pub fn bytes(&self) -> usize {
        match self {
            Environment::Uniform(_) => 0,
            Environment::Map(map) => map.bytes(),
        }
    }
}
