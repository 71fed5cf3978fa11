//! Subsurface scattering below the diffusion approximation's cost: the artists' parameters, radial diffuse reflectance
//! profiles, and the references they are judged by.
//!
//! * [`inversion`] turns a colour and a mean free path into coefficients of a medium.
//! * [`diffusion`] has the radial profiles R_d(r), with exact sampling of the radius.
//! * [`half_space`] has exact total reflectances.
//! * [`reference`] has the random walk that measures totals and profiles with standard errors.
//!
//! All reflectances count light that has passed the boundary into the medium. The caller multiplies by the Fresnel
//! transmittance of entry. Light that leaves has paid the boundary's internal reflection. Lengths have any one unit,
//! and coefficients its reciprocal. Keys in brackets are listed in `references.md`.

pub mod diffusion;
pub mod half_space;
pub mod inversion;
mod medium;
mod numeric;
pub mod reference;
#[cfg(test)]
mod test_support;

mod fresnel;

pub use medium::Medium;

/// Number of wavelength lanes.
pub const LANES: usize = 3;

/// One value per wavelength lane.
pub type Lanes<T = f32> = [T; LANES];
