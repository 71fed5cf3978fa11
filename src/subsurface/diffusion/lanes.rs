//! Profiles of all wavelength lanes together.

use super::super::{LANES, Lanes};
use super::RadialProfile;
use std::array::from_fn;

/// One profile per wavelength lane.
#[derive(Debug, Clone, Copy)]
pub struct ProfileLanes<P>(pub Lanes<P>);

/// A sampled radius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RadialSample {
    /// The radius.
    pub radius: f32,
    /// R_d per area by lane.
    pub value: Lanes,
    /// Density per area over all lanes that could have sampled the radius.
    pub density: f32,
}

impl<P: RadialProfile> ProfileLanes<P> {
    /// Returns R_d(r) per area by lane.
    pub fn value(&self, radius: f32) -> Lanes {
        from_fn(|lane| self.0[lane].value(radius.into()) as f32)
    }

    /// Returns the total reflectance by lane.
    pub fn total(&self) -> Lanes {
        from_fn(|lane| self.0[lane].total() as f32)
    }

    /// Returns the radius beyond which each lane loses at most the share `tail` in (0, 1] of its light.
    pub fn max_radius(&self, tail: f32) -> f32 {
        self.0.iter().map(|p| p.radius(tail.into())).fold(0.0, f64::max) as f32
    }

    /// Returns the density per area of [`ProfileLanes::sample`] at the radius, for the same `weights`.
    ///
    /// The weights are not negative. All lanes count alike if all weights are 0.
    pub fn density(&self, weights: Lanes, radius: f32) -> f32 {
        let shares = shares(weights);
        (0..LANES).map(|lane| shares[lane] * self.0[lane].density(radius.into())).sum::<f64>() as f32
    }

    /// Samples a radius: the lane by `weights` and `u` in [0, 1), then its profile by `v` in [0, 1).
    ///
    /// The weights are not negative; path throughput times total reflectance is a good choice. The ratio of value and
    /// density is at most the lane's total over its share of the weights.
    pub fn sample(&self, weights: Lanes, u: f32, v: f32) -> RadialSample {
        let shares = shares(weights);
        let mut rest = f64::from(u);
        let mut chosen = 0;
        for (lane, share) in shares.into_iter().enumerate() {
            if share <= 0.0 {
                continue;
            }
            chosen = lane;
            if rest < share {
                break;
            }
            rest -= share;
        }
        let radius = self.0[chosen].radius(1.0 - f64::from(v)) as f32;
        RadialSample { radius, value: self.value(radius), density: self.density(weights, radius) }
    }
}

/// Returns the weights over their sum.
fn shares(weights: Lanes) -> Lanes<f64> {
    let sum: f64 = weights.into_iter().map(f64::from).sum();
    weights.map(|w| if sum > 0.0 { f64::from(w) / sum } else { 1.0 / LANES as f64 })
}
