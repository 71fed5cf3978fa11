//! Uniform environment radiance.

use super::{EmitterPoint, LightSample};
use crate::sampling::warp;
use crate::sampling::{Density, Pdf, SolidAngle};
use crate::spectrum::Spectrum;
use std::f64::consts::PI;

/// Environment of constant radiance.
#[derive(Debug, Clone, Copy)]
pub struct ConstantEnvironment {
    /// Radiance.
    pub radiance: Spectrum,
}

impl ConstantEnvironment {
    /// Samples a direction uniformly.
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> LightSample {
        let wi = warp::uniform_sphere(u);
        LightSample { wi, radiance: self.radiance, density: Density::Smooth(self.pdf()), end: EmitterPoint::Distant }
    }

    /// Returns the constant density over directions.
    #[inline]
    pub fn pdf(&self) -> Pdf<SolidAngle> {
        Pdf::new(std::f32::consts::FRAC_1_PI * 0.25)
    }

    /// Returns the power into a sphere of `radius`: π L through each element of its surface.
    pub fn power(&self, radius: f32) -> f64 {
        4.0 * (PI * f64::from(radius)).powi(2) * f64::from(self.radiance.mean())
    }
}
