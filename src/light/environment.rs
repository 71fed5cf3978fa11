//! Light from outside the scene, one kind a file. Rays that leave the scene evaluate it, and light sampling uses the
//! same density. Integrators may hide it from the camera.

use super::{BoundingSphere, ConstantEnvironment, EnvironmentMap, EnvironmentSamples, LeRandom, LeSample, LightSample};
use crate::sampling::lanes::uniform_sphere;
use crate::sampling::{Pdf, SolidAngle};
use crate::spectrum::Spectrum;
use etendue_lanes::{Float, Vec3 as LaneVec3};
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

    /// Does [`Environment::sample`] in every lane.
    #[inline(always)]
    pub fn sample_lanes<F: Float>(&self, u: [F; 2]) -> EnvironmentSamples<F> {
        match self {
            Environment::Uniform(sky) => EnvironmentSamples {
                wi: uniform_sphere(u),
                radiance: Spectrum::in_lanes(sky.radiance),
                pdf: F::splat(sky.pdf().value()),
                valid: F::first(F::LANES),
            },
            Environment::Map(map) => map.sample_lanes(u),
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

    /// Does [`Environment::along`] in every lane.
    #[inline(always)]
    pub fn along_lanes<F: Float>(&self, w: LaneVec3<F>) -> (Spectrum<F>, F) {
        match self {
            Environment::Uniform(sky) => (Spectrum::in_lanes(sky.radiance), F::splat(sky.pdf().value())),
            Environment::Map(map) => map.along_lanes(w),
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
