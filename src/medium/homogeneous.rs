//! Media that are the same everywhere, for which all integrals are known.

use super::Phase;
use crate::spectrum::Spectrum;

/// A homogeneous medium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Homogeneous {
    /// Absorption and scattering together, σt per unit of length.
    pub extinction: Spectrum,
    /// σs per unit of length.
    pub scattering: Spectrum,
    /// Emitted radiance per unit of length.
    pub emission: Spectrum,
    /// How it scatters.
    pub phase: Phase,
}

impl Homogeneous {
    /// Returns the medium with coefficients of absorption and scattering per unit of length, finite and not negative.
    pub fn new(absorption: Spectrum, scattering: Spectrum, phase: Phase) -> Self {
        Homogeneous { extinction: absorption + scattering, scattering, emission: Spectrum::ZERO, phase }
    }

    /// Returns the medium that emits this radiance per unit of length, finite and not negative.
    pub fn emitting(self, emission: Spectrum) -> Self {
        Homogeneous { emission, ..self }
    }

    /// Whether light passes it unchanged, and it adds none.
    pub fn is_clear(&self) -> bool {
        self.extinction.is_black() && !self.emits()
    }

    /// Whether it emits light.
    #[inline]
    pub fn emits(&self) -> bool {
        !self.emission.is_black()
    }

    /// Returns all its numbers: media with the same numbers are equal.
    pub fn numbers(&self) -> [f32; 13] {
        let ([a, b, c], [d, e, f], [g, h, i, j]) = (self.extinction.0, self.scattering.0, self.phase.numbers());
        let [k, l, m] = self.emission.0;
        [a, b, c, d, e, f, g, h, i, j, k, l, m]
    }

    /// Whether anything is scattered in it.
    #[inline]
    pub fn scatters(&self) -> bool {
        !self.scattering.is_black()
    }

    /// Returns the transmittance of `length` (Beer and Lambert).
    #[inline]
    pub fn transmittance(&self, length: f32) -> Spectrum {
        // A lane without extinction transmits fully, also where 0 · ∞ would be NaN.
        self.extinction.map(|s: f32| if s > 0.0 { (-s * length).exp() } else { 1.0 })
    }

    /// Returns the radiance that `length` of it emits toward one end: ∫ ε exp(−σt t) dt. It is black along an infinite
    /// length without extinction, where there is no answer.
    #[inline]
    pub fn emitted(&self, length: f32) -> Spectrum {
        let along = |s: f32| if s > 0.0 { -(-s * length).exp_m1() / s } else { length };
        let glow = self.emission * self.extinction.map(along);
        glow.map(|lane: f32| if lane.is_finite() { lane } else { 0.0 })
    }
}
