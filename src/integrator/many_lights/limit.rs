//! The limit of the contribution of a virtual light.
//!
//! Let the edge from x to y join two vertices that scatter smoothly. A virtual light at y is one way to sample the
//! path, a walk that scatters at x is another. The share c of the virtual light is a function of the edge alone,
//! c = min(1, b / (F cos_x cos_y κ / d²)), where κ is a measure of the peak of the BSDF at y and b the limit. The walk
//! has the share 1 − c: it goes on beyond y with this probability [KolligKeller06 §3].

use crate::integrator::PilotEstimate;
use crate::scene::Scene;
use crate::spectrum::Spectrum;

/// Contribution of a virtual light, as a multiple of the typical radiance of a pixel, at which the limit begins.
const DEFAULT_LIMIT: f64 = 1.0;

/// The limit of a pass.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limit {
    /// b in the head of this module.
    pub(super) most: f32,
    /// Whether walks make up for what it takes away.
    pub(super) is_compensated: bool,
}

impl Limit {
    /// Returns the limit where about `gathered` virtual lights light a receiver. With `clamp`, a multiple of the typical
    /// radiance of a pixel, it is not compensated.
    ///
    /// It depends on the power of the lights and not on the flux of virtual lights, which would be correlated with the
    /// contributions.
    pub(super) fn new(scene: &Scene, pilot: &PilotEstimate, gathered: usize, clamp: Option<f64>) -> Self {
        let power: f64 = scene.lights().all().iter().map(|light| light.power(scene.radius())).sum();
        let most = clamp.unwrap_or(DEFAULT_LIMIT) * f64::from(pilot.typical) * gathered as f64 / power;
        // Without light there are no virtual lights.
        Limit { most: if most.is_finite() { most as f32 } else { 0.0 }, is_compensated: clamp.is_none() }
    }

    /// Returns the share of the virtual light at the end of an edge: F |cos| at the receiver, the cosine at the light,
    /// the squared distance, and the peak of the light's BSDF.
    #[inline]
    pub(super) fn share(&self, f_cos: Spectrum, cos: f32, d2: f32, peak: f32) -> f32 {
        let strength = f_cos.max_lane() * cos * peak / d2;
        // Where there is nothing to limit the quotient is infinite or not a number.
        (self.most / strength).min(1.0)
    }
}

/// Light within the limit, and beyond it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limited {
    pub(super) light: Spectrum,
    pub(super) excess: Spectrum,
}

impl Limited {
    pub(super) const ZERO: Limited = Limited { light: Spectrum::ZERO, excess: Spectrum::ZERO };

    /// Returns the sum of this and `times` the other.
    pub(super) fn plus(self, other: Limited, times: f32) -> Self {
        Limited { light: self.light + other.light * times, excess: self.excess + other.excess * times }
    }
}
