//! Media whose density may vary from place to place.

use super::{Grid, Homogeneous};
use crate::spectrum::Spectrum;
use glam::Vec3;

/// A medium: its coefficients where the density is 1, and the density, which is 1 everywhere without a grid.
#[derive(Debug)]
pub struct Medium {
    /// Coefficients and phase function at density 1.
    pub unit: Homogeneous,
    /// The density; empty outside of its box.
    pub grid: Option<Grid>,
}

/// How far a flight got.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Reach {
    /// It ends at this distance, where the density is the second number.
    Ends(f32, f32),
    /// It passes the whole length, and the integral of the density over it is this.
    Passes(f32),
}

impl From<Homogeneous> for Medium {
    fn from(unit: Homogeneous) -> Self {
        Medium { unit, grid: None }
    }
}

impl Medium {
    /// Returns the transmittance of the segment of `length` from `origin` along the unit vector `w`.
    #[inline]
    pub fn transmittance(&self, origin: Vec3, w: Vec3, length: f32) -> Spectrum {
        self.unit.transmittance(self.depth(origin, w, length))
    }

    /// Returns the radiance that the segment emits toward `origin`. All coefficients have the same density, so that it is
    /// that of a homogeneous medium as long as the integral of the density.
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
