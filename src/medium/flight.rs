//! Free flights: how far light goes along an edge until it collides with a medium and scatters.
//!
//! A flight crosses the media of an edge one after the other. Its length is exponential in the optical depth of one
//! lane. The density of a collision, and the probability of reaching the end, are means over lanes, so that every lane
//! is estimated by every flight.
//!
//! **Spectral MIS** [Wilkie14]. A walk of many flights stands for all walks that follow one lane from vertex to vertex: its
//! density is the mean over lanes of the products of their densities. Each flight selects a lane with the probability
//! that the walk so far has followed it, the *prior*; so the throughput stays below the number of lanes however many
//! vertices there are. With a prior of its own for each edge it would grow without bound, since a product of means is
//! not the mean of products.
//!
//! In media that only absorb there are no collisions, and light is weighted by the transmittance.

use super::Medium;
use super::reach::Reach;
use crate::numeric::BELOW_ONE;
use crate::spectrum::{LANES, Spectrum};
use glam::Vec3;

/// A flight on its way along an edge.
#[derive(Debug, Clone, Copy)]
pub struct Flight {
    /// Density of the walk so far by each lane over the mean.
    prior: Spectrum,
    lane: usize,
    /// What the selection of the lane left of its number, uniform in [0, 1).
    rest: f32,
    /// Optical depth in that lane until the collision.
    left: f32,
    /// Transmittance of the scattering media that it has crossed.
    through: Spectrum,
    /// The same of those that only absorb.
    absorbed: Spectrum,
}

/// A collision that scatters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Collision {
    /// Distance in the last medium.
    pub distance: f32,
    /// Density of the medium there: a factor of its coefficients.
    pub at: f32,
    /// σs times the transmittance over the density, see [`density`].
    pub factor: Spectrum,
}

/// Returns the density per length with which flights of the prior 1 along an edge collide where the medium has this
/// `extinction`, or, for an extinction of 1, the probability with which they reach a surface there. `through` is the
/// transmittance of the scattering media on the edge.
#[inline]
pub fn density(through: Spectrum, extinction: Spectrum) -> f32 {
    (through * extinction).mean()
}

impl Flight {
    /// Begins a flight by u in [0, 1)²: of the lane, and of the length. `prior` has the density of the walk so far by
    /// each lane over the mean of all lanes.
    #[inline]
    pub fn new(prior: Spectrum, [lane, u]: [f32; 2]) -> Self {
        let mut left = lane * LANES as f32;
        let passed = prior.0[..LANES - 1].iter().take_while(|&&share| {
            left -= share;
            left >= 0.0
        });
        let lane = passed.count();
        let share = prior.0[lane];
        let rest = (if left < 0.0 { left + share } else { left }) / share;
        let rest = if rest >= 0.0 { rest.min(BELOW_ONE) } else { 0.0 };
        Flight { prior, lane, rest, left: -(-u).ln_1p(), through: Spectrum::ONE, absorbed: Spectrum::ONE }
    }

    /// Returns a number in [0, 1) that is independent of how far it flies.
    #[inline]
    pub fn rest(&self) -> f32 {
        self.rest
    }

    /// Crosses the segment of `length` from `origin` along the unit vector `w` in `medium`; returns the collision on
    /// the way, if there is one.
    #[inline]
    pub fn cross(&mut self, medium: &Medium, origin: Vec3, w: Vec3, length: f32) -> Option<Collision> {
        let unit = &medium.unit;
        if !unit.scatters() {
            self.absorbed *= medium.transmittance(origin, w, length);
            return None;
        }
        // Infinite in a lane without extinction.
        let depth = self.left / unit.extinction[self.lane];
        match medium.reach(origin, w, length, depth) {
            Reach::Ends(distance, at) => {
                self.through *= unit.transmittance(depth);
                // The density at the collision is a factor of σs and of the density of the flight.
                let found = density(self.prior * self.through, unit.extinction);
                let factor = self.absorbed * self.through * unit.scattering / found;
                Some(Collision { distance, at, factor })
            }
            Reach::Passes(passed) => {
                if unit.extinction[self.lane] > 0.0 {
                    self.left -= unit.extinction[self.lane] * passed;
                }
                self.through *= unit.transmittance(passed);
                None
            }
        }
    }

    /// Returns the transmittance of the scattering media that it has crossed.
    #[inline]
    pub fn through(&self) -> Spectrum {
        self.through
    }

    /// Returns the transmittance over the probability of getting as far as it has.
    #[inline]
    pub fn factor(&self) -> Spectrum {
        self.absorbed * self.through / density(self.prior * self.through, Spectrum::ONE)
    }

    /// Returns the prior of the next flight after one that ended at `extinction`, which is 1 on a surface.
    #[inline]
    pub fn posterior(&self, extinction: Spectrum) -> Spectrum {
        let found = self.prior * self.through * extinction;
        found / found.mean()
    }
}
