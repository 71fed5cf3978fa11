//! Media whose density may vary from place to place.

use super::reach::Reach;
use super::{Colors, Grid, Homogeneous};
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
    pub albedo: Option<Colors>,
    /// What multiplies emission; empty outside of its box.
    pub emission: Option<Colors>,
}

/// Largest number of steps through a grid of emission.
const MOST_STEPS: f32 = 1024.0;

impl From<Homogeneous> for Medium {
    fn from(unit: Homogeneous) -> Self {
        Medium { unit, grid: None, albedo: None, emission: None }
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

    /// Returns the radiance that the segment emits toward `origin`, or an unbiased estimate by `u` in [0, 1) where a
    /// grid multiplies the emission. Without such a grid all coefficients have the same density, so that it is that of
    /// a homogeneous medium as long as the integral of the density.
    #[inline]
    pub fn emitted(&self, origin: Vec3, w: Vec3, length: f32, u: f32) -> Spectrum {
        match &self.emission {
            None => self.unit.emitted(self.depth(origin, w, length)),
            Some(emission) => self.emitted_in_steps(emission, [origin, w], length, u),
        }
    }

    /// Estimates the integral of emission times transmittance in steps of a cell at most, as far as [`MOST_STEPS`]
    /// reach, with a point at the same place `u` of each.
    fn emitted_in_steps(&self, emission: &Colors, [origin, w]: [Vec3; 2], length: f32, u: f32) -> Spectrum {
        let Some(([from, to], cells)) = emission.crossed(origin, w, length) else { return Spectrum::ZERO };
        let steps = cells.ceil().clamp(1.0, MOST_STEPS);
        let step = (to - from) / steps;
        let (mut sum, mut depth, mut last) = (Spectrum::ZERO, 0.0, 0.0);
        for k in 0..steps as u32 {
            let t = from + (k as f32 + u) * step;
            depth += self.depth(origin + w * last, w, t - last);
            last = t;
            let p = origin + w * t;
            sum += self.unit.transmittance(depth) * emission.at(p) * self.density(p);
        }
        self.unit.emission * sum * step
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
