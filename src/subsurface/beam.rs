//! Photon beam diffusion: dipoles integrated along the beam that enters, and exact single scattering [Habel13].

use super::MediumLane;
use super::Tabulated;
use super::dipole::Boundary;
use super::fresnel::internal_reflectance;
use super::numeric::integrate_to_infinity;
use std::f64::consts::PI;

/// Returns the profile of light at normal incidence: multiple and single scattering [Habel13].
///
/// The total exceeds the exact one by 5 to 14 % in index-matched media of isotropic scattering, also where that is 1.
/// It falls short by 6 to 26 % for a mean cosine of 0.8. The shape is much better than that: [`Tabulated::with_total`]
/// repairs the total where the exact one is known.
///
/// It is tabulated at 512 radii, from 1e-4 mean free paths to where e^−40 of the light is left, at most 1e5 mean free
/// paths. This takes some ten milliseconds. The table's total differs from the model's by less than 2e-4.
///
/// # Panics
/// Unless `medium` is in the ranges its fields state, with positive extinction.
pub fn profile(medium: &MediumLane) -> Tabulated {
    let model = Beam::new(medium);
    Tabulated::of_medium(medium, model.boundary.decay, |r| model.multiple(r) + model.single(r))
}

/// Returns the profile of light at normal incidence that is scattered exactly once [Habel13], by the table of
/// [`profile`] up to 40 mean free paths. In the index-matched medium of isotropic scattering its total is
/// (ω / 2) (1 − ln 2).
///
/// # Panics
/// Unless `medium` is in the ranges its fields state, with positive extinction.
pub fn single_scattering(medium: &MediumLane) -> Tabulated {
    let model = Beam::new(medium);
    Tabulated::of_medium(medium, model.medium.extinction(), |r| model.single(r))
}

/// The integrands of the model.
pub(super) struct Beam {
    medium: MediumLane,
    reduced: MediumLane,
    pub(super) boundary: Boundary,
}

impl Beam {
    /// A medium without scattering is replaced by one with little, whose shape is that of the limit.
    pub(super) fn new(medium: &MediumLane) -> Self {
        medium.check();
        let medium = medium.lit();
        let reduced = medium.reduced();
        Beam { medium, reduced, boundary: Boundary::better(&reduced) }
    }

    /// Returns light scattered twice or more: the better dipole with sources along the beam, each damped close to
    /// itself by the empirical factor 1 − e^(−2 σt' (d + t)) [Habel13].
    pub(super) fn multiple(&self, r: f64) -> f64 {
        let sum = integrate_to_infinity(|x| {
            let depth = x / self.reduced.extinction();
            let near = -(-2.0 * (self.reduced.extinction() * depth.hypot(r) + x)).exp_m1();
            (-x).exp() * near * self.boundary.sum(depth, r)
        });
        self.reduced.albedo().powi(2) * sum / (4.0 * PI)
    }

    /// Returns light scattered once, without approximation [Habel13].
    pub(super) fn single(&self, r: f64) -> f64 {
        let extinction = self.medium.extinction();
        let eta = self.medium.eta;
        // Depth above which light is reflected totally on its way to r.
        let first = r * (eta * eta - 1.0).sqrt();
        let sum = integrate_to_infinity(|x| {
            let depth = first + x / extinction;
            let d = depth.hypot(r);
            let mu = depth / d;
            let leaves = 1.0 - internal_reflectance(mu, eta);
            let phase = henyey_greenstein(self.medium.mean_cosine, -mu);
            (-extinction * (depth + d)).exp() * phase * leaves * mu / (d * d)
        });
        self.medium.albedo() * sum
    }
}

/// Returns the Henyey–Greenstein phase function per solid angle, for the cosine `cos` of the turn.
fn henyey_greenstein(g: f64, cos: f64) -> f64 {
    let base = 1.0 + g * g - 2.0 * g * cos;
    (1.0 - g * g) / (4.0 * PI * base * base.sqrt())
}
