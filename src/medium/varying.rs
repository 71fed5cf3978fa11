//! Media whose density may vary from place to place.

use super::reach::Reach;
use super::{Albedos, Grid, Homogeneous};
use crate::spectrum::Spectrum;
use glam::Vec3;

/// A medium: its coefficients where the density is 1, and the density, which is 1 everywhere without a grid.
#[derive(Debug)]
pub struct Medium {
    /// Coefficients and phase function at density 1.
    pub unit: Homogeneous,
    /// The density; empty outside of its box.
    pub grid: Option<Grid>,
    /// The albedo, which multiplies scattering.
    pub albedo: Option<Albedos>,
}

impl From<Homogeneous> for Medium {
    fn from(unit: Homogeneous) -> Self {
        Medium { unit, grid: None, albedo: None }
    }
}

impl Medium {
    /// Returns the transmittance of the segment of `length` from `origin` along the unit vector `w`.
    #[inline]
    pub fn transmittance(&self, origin: Vec3, w: Vec3, length: f32) -> Spectrum {
        self.unit.transmittance(self.depth(origin, w, length))
    }

    /// Returns the density at the point `p`.
    #[inline]
    pub fn density(&self, p: Vec3) -> f32 {
        self.grid.as_ref().map_or(1.0, |grid| grid.density(p))
    }

    /// Returns the factor of scattering at the point `p`.
    #[inline]
    pub fn albedo(&self, p: Vec3) -> Spectrum {
        self.albedo.as_ref().map_or(Spectrum::ONE, |grid| grid.at(p))
    }

    /// Returns the radiance that the segment emits toward `origin`. All coefficients have the same density, so that it
    /// is that of a homogeneous medium as long as the integral of the density.
    #[inline]
    pub fn emitted(&self, origin: Vec3, w: Vec3, length: f32) -> Spectrum {
        self.unit.emitted(self.depth(origin, w, length))
    }

    /// Returns the integral of the density over the segment.
    #[inline]
    fn depth(&self, origin: Vec3, w: Vec3, length: f32) -> f32 {
        self.grid.as_ref().map_or(length, |grid| grid.depth(origin, w, length))
    }

    /// Goes from `origin` along the unit vector `w` until the integral of the density is `depth`, for `length` at most.
    #[inline]
    pub(super) fn reach(&self, origin: Vec3, w: Vec3, length: f32, depth: f32) -> Reach {
        match &self.grid {
            Some(grid) => grid.fly(origin, w, length, depth),
            None if depth < length => Reach::Ends(depth, 1.0),
            None => Reach::Passes(length),
        }
    }
}
