//! Profiles of all wavelength lanes together.

use super::{RadialProfile, Tabulated};
use crate::spectrum::{LANES, Spectrum};

/// One profile per wavelength lane.
#[derive(Debug, Clone)]
pub struct ProfileLanes(pub [Tabulated; LANES]);

impl ProfileLanes {
    /// Returns R_d(r) per area by lane.
    pub fn value(&self, radius: f32) -> Spectrum {
        self.lanes(|profile| profile.value(radius.into()))
    }

    /// Returns the total reflectance by lane.
    pub fn total(&self) -> Spectrum {
        self.lanes(RadialProfile::total)
    }

    /// Returns the radius beyond which each lane loses at most the share `tail` in (0, 1] of its light.
    pub fn max_radius(&self, tail: f32) -> f32 {
        self.0.iter().map(|p| p.radius(tail.into())).fold(0.0, f64::max) as f32
    }

    /// Returns the density per area of the radius for samples of a lane, drawn with the probabilities `shares`.
    pub fn density(&self, shares: Spectrum, radius: f32) -> f32 {
        let by_lane = self.lanes(|profile| profile.density(radius.into()));
        (shares * by_lane).0.into_iter().sum()
    }

    /// Samples a radius: the lane with the probabilities `shares`, which sum to 1, by `u` in [0, 1), and then its
    /// profile by `v` in [0, 1).
    pub fn sample(&self, shares: Spectrum, u: f32, v: f32) -> f32 {
        let mut rest = u;
        let mut chosen = 0;
        for (lane, share) in shares.0.into_iter().enumerate().filter(|&(_, share)| share > 0.0) {
            chosen = lane;
            if rest < share {
                break;
            }
            rest -= share;
        }
        self.0[chosen].radius(1.0 - f64::from(v)) as f32
    }

    fn lanes(&self, f: impl Fn(&Tabulated) -> f64) -> Spectrum {
        Spectrum(std::array::from_fn(|lane| f(&self.0[lane]) as f32))
    }
}
