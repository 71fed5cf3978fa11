//! Uniform radiance from outside the scene.

use super::{End, LightSample};
use crate::sampling::warp;
use crate::sampling::{Density, Pdf, SolidAngle};
use crate::spectrum::Spectrum;
use std::f64::consts::PI;

/// The same radiance from every direction where nothing is hit.
#[derive(Debug, Clone, Copy)]
pub struct Sky {
    /// That radiance.
    pub radiance: Spectrum,
}

impl Sky {
    /// A direction chosen uniformly.
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> LightSample {
        let wi = warp::uniform_sphere(u);
        LightSample { wi, radiance: self.radiance, density: Density::Smooth(self.pdf()), end: End::Infinity }
    }

    /// The density of any direction.
    #[inline]
    pub fn pdf(&self) -> Pdf<SolidAngle> {
        Pdf::new(std::f32::consts::FRAC_1_PI * 0.25)
    }

    /// What enters a sphere of `radius`: π L through each element of its surface.
    pub fn power(&self, radius: f32) -> f64 {
        4.0 * (PI * f64::from(radius)).powi(2) * f64::from(self.radiance.mean())
    }
}
