//! A random walk in a half-space: the reference of the radial profiles.
//!
//! All in f64 and in units of the mean free path, for tables and tests. It shares only Fresnel's formula with the
//! profiles. Light enters at the origin; the walk scores where it leaves.

mod bins;
mod walk;

pub use bins::{Bins, Estimate};
pub use walk::{Incidence, Reflectance, Walk};

/// Advances the state and returns a uniform variate in [0, 1) of 53 bits: SplitMix64 [Steele14].
pub(super) fn split_mix(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 * 2f64.powi(-53)
}
