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
    /// How it scatters.
    pub phase: Phase,
}

impl Homogeneous {
    /// Returns the medium with coefficients of absorption and scattering per unit of length, finite and not negative.
    pub fn new(absorption: Spectrum, scattering: Spectrum, phase: Phase) -> Self {
        Homogeneous { extinction: absorption + scattering, scattering, phase }
    }

    /// Whether light passes it unchanged.
    pub fn is_clear(&self) -> bool {
        self.extinction.is_black()
    }

    /// Returns all its numbers: media with the same numbers are equal.
    pub fn numbers(&self) -> [f32; 10] {
        let ([a, b, c], [d, e, f], [g, h, i, j]) = (self.extinction.0, self.scattering.0, self.phase.numbers());
        [a, b, c, d, e, f, g, h, i, j]
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
}
