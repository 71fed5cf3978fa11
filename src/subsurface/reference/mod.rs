//! A random walk in a half-space: the reference of the radial profiles.
//!
//! All in f64 and in units of the mean free path, for tables and tests. It shares only Fresnel's formula with the
//! profiles. Light enters at the origin; the walk scores where it leaves.

mod bins;
mod walk;

use crate::sampling::mix64;

pub use bins::Bins;
pub use walk::{Incidence, Reflectance, Walk};

/// Advances the state and returns a uniform variate in [0, 1) of 53 bits.
pub(super) fn split_mix(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    (mix64(*state) >> 11) as f64 * 2f64.powi(-53)
}
