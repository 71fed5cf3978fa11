//! MIS compensation of the density [Karlík19 §4].
//!
//! Scattered rays find the even part of an environment. Light samples are of use where radiance stands out. So a share
//! of the mean radiance is taken from every texel before the tables are built. A fraction of each texel stays, so that
//! the density is positive exactly where the radiance is, and every technique stays unbiased by itself.
//!
//! Limits: next-event estimation without the other technique (`path-nee`) loses where the sky is even. Its density
//! there is down to [`LEAST`] of what it would be.

use etendue_lanes::Float;

/// Share of the mean radiance that is taken. Measured: docs/measurements.md, "Many lights".
const TAKEN: f64 = 0.7;

/// The fraction of a texel that is left at least.
const LEAST: f32 = 0.1;

/// Shares of texels in the density, before it is normalised.
#[derive(Debug, Clone, Copy)]
pub(super) struct Compensation {
    taken: f32,
}

impl Compensation {
    /// Returns the compensation of a map of this mean radiance.
    pub(super) fn new(mean: f64) -> Self {
        Compensation { taken: (TAKEN * mean) as f32 }
    }

    /// Returns the share of a texel of this mean over lanes.
    #[inline(always)]
    pub(super) fn of<F: Float>(self, mean: F) -> F {
        (mean - F::splat(self.taken)).max(mean * F::splat(LEAST))
    }
}
