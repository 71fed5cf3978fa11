//! Diffusion models of subsurface scattering: light that enters a body leaves it again nearby, at a distance whose
//! distribution is known beforehand. They replace the random walk in media behind a boundary by one step.
//!
//! * [`DiffusionModel`] names the models and makes their profiles.
//! * [`RadialProfile`] is what each of them offers, with exact sampling of the radius; [`ProfileLanes`] joins lanes.
//! * [`totals`] has the exact total reflectance of half-spaces.
//! * [`reference`] has the random walk in a half-space that profiles are measured against.
//!
//! A profile R_d(r) is the flux per area that leaves a flat half-space at the distance r from the point where unit flux
//! has passed the boundary into it. Light that leaves has paid the reflection of the boundary inside. The caller
//! multiplies by the Fresnel transmittance of entry, and gives what leaves its directions. Lengths have any one unit,
//! and coefficients its reciprocal.
//!
//! All models are approximations. Errors of the profile under diffuse light, against the random walk in media of
//! isotropic scattering with ω from 0.2 to 0.99 (mean over 0.1 to 10 mean free paths, weighted by r R_d;
//! docs/diffusion-table.md has more media):
//!
//! | model | index 1 | index 1.4 | total, index 1.4 |
//! |---|---|---|---|
//! | classical dipole | 26–42 % | 18–123 % | −3 to +31 % |
//! | better dipole with single scattering | 14–25 % | 10–13 % | −4 to +5 % |
//! | photon beam diffusion with the exact total | 2–9 % | 2–7 % | exact |
//! | normalized diffusion | 2–4 % | 8–44 % | exact |
//!
//! Their common limits: the body is flat and deep as far as light gets in it, its medium is the same everywhere, and
//! nothing is inside. Thin parts are too bright or too dark, and light that comes in from behind them is missed.

mod beam;
mod burley;
mod dipole;
mod fresnel;
mod lanes;
mod medium;
mod model;
mod numeric;
pub mod reference;
mod tabulated;
#[cfg(test)]
mod tests;
pub mod totals;

pub use beam::{profile as photon_beam, single_scattering};
pub use burley::Burley;
pub use dipole::Dipole;
pub use fresnel::exit_share;
pub use lanes::ProfileLanes;
pub use medium::MediumLane;
pub use model::DiffusionModel;
pub use tabulated::Tabulated;

/// A radial profile of one wavelength lane. A density is per area, that is per 2π r dr; the azimuth is uniform.
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
