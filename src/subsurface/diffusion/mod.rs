//! Radial diffuse reflectance profiles: the flux per area R_d(r) that leaves a flat half-space at the distance r from
//! the point where unit flux entered.
//!
//! * [`Dipole::classical`]: the classical dipole [Jensen01].
//! * [`Dipole::better`]: the better dipole [dEon12], multiple scattering only.
//! * [`Burley`]: normalized diffusion, a fit to random walks [ChristensenBurley15].
//! * [`beam`]: photon beam diffusion [Habel13], multiple scattering and exact single scattering.
//!
//! All are approximations. Errors of the profile at normal incidence, against the random walk in media of isotropic
//! scattering with ω from 0.2 to 0.99 (mean over 0.1 to 10 mean free paths, weighted by r R_d):
//!
//! | model | index 1 | index 1.4 | total, index 1 |
//! |---|---|---|---|
//! | classical dipole | 28–57 % | 20–156 % | −32 to −1 % |
//! | better dipole with single scattering | 8–25 % | 12–20 % | +3 to +18 % |
//! | photon beam diffusion | 7–16 % | 3–12 % | +5 to +14 % |
//! | the same with the exact total | 3–6 % | 1–7 % | exact |
//! | normalized diffusion | 2–5 % | 13–41 % | exact |
//!
//! Each is sampled exactly: the density of a sampled radius is the profile over its total. Radii have the unit of the
//! mean free path. A density is per area, that is per 2π r dr; the azimuth is uniform.

pub mod beam;
mod burley;
mod dipole;
mod lanes;
mod tabulated;
#[cfg(test)]
mod tests;

pub use burley::Burley;
pub use dipole::Dipole;
pub use lanes::{ProfileLanes, RadialSample};
pub use tabulated::Tabulated;

/// A radial profile of one wavelength lane.
pub trait RadialProfile {
    /// Returns the total reflectance, 2π ∫ r R_d(r) dr, in [0, 1] up to the model's error.
    fn total(&self) -> f64;

    /// Returns the density of [`RadialProfile::radius`] per area at the radius `r`, not negative. It is positive and
    /// finite at 0, where some profiles have a pole that is cut far below any sample.
    fn density(&self, r: f64) -> f64;

    /// Returns the share of the total that leaves beyond the radius `r`, not negative.
    fn tail(&self, r: f64) -> f64;

    /// Returns the radius beyond which the share `tail` in (0, 1] of the total leaves.
    ///
    /// A uniform variate as `tail` samples [`RadialProfile::density`] exactly. A small one gives a maximal radius: a
    /// search no farther than it loses this share of the light.
    fn radius(&self, tail: f64) -> f64;

    /// Returns R_d(r), the reflectance per area at the radius `r`, not negative.
    fn value(&self, r: f64) -> f64 {
        self.total() * self.density(r)
    }
}
