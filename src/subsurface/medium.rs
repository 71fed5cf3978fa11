//! The coefficients of one wavelength lane of a homogeneous medium.

/// Scattering over absorption of the limit of media that do not scatter.
const FAINT: f64 = 1e-9;

/// One wavelength lane of a homogeneous medium with Henyey–Greenstein scattering and a smooth boundary.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MediumLane {
    /// σa per unit of length, finite and not negative. It is stored by itself, since 1 − ω loses its digits in media
    /// that hardly absorb.
    pub absorption: f64,
    /// σs per unit of length, finite and not negative.
    pub scattering: f64,
    /// Mean cosine g of the phase function, inside (−1, 1).
    pub mean_cosine: f64,
    /// Index of refraction inside over that outside, at least 1.
    pub eta: f64,
}

impl MediumLane {
    /// Returns the index-matched medium of extinction 1 that scatters isotropically with albedo `omega` in [0, 1].
    pub fn isotropic(omega: f64) -> Self {
        MediumLane { absorption: 1.0 - omega, scattering: omega, mean_cosine: 0.0, eta: 1.0 }
    }

    /// Returns σt, per unit of length.
    pub fn extinction(&self) -> f64 {
        self.absorption + self.scattering
    }

    /// Returns the single-scattering albedo ω = σs / σt.
    pub fn albedo(&self) -> f64 {
        self.scattering / self.extinction()
    }

    /// Returns the medium of isotropic scattering with the same diffusion, σs' = (1 − g) σs [Jensen01 §2.1]. The
    /// similarity is exact only far from sources and boundaries.
    pub fn reduced(&self) -> Self {
        MediumLane { scattering: (1.0 - self.mean_cosine) * self.scattering, mean_cosine: 0.0, ..*self }
    }

    /// Returns a medium that scatters at least a little, whose profile has the shape of the limit.
    pub(super) fn lit(&self) -> Self {
        MediumLane { scattering: self.scattering.max(FAINT * self.absorption), ..*self }
    }

    /// Panics unless the coefficients are in their ranges and the extinction is positive.
    pub(super) fn check(&self) {
        assert!(self.absorption >= 0.0 && self.scattering >= 0.0, "negative coefficients: {self:?}");
        assert!(self.extinction() > 0.0 && self.extinction().is_finite(), "extinction must be positive: {self:?}");
        assert!(self.mean_cosine.abs() < 1.0, "mean cosine out of range: {self:?}");
        assert!(self.eta >= 1.0 && self.eta.is_finite(), "the index inside must be at least that outside: {self:?}");
    }
}
