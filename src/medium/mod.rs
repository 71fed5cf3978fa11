//! Participating media: what happens to light between surfaces.
//!
//! Phase functions follow the conventions of scattering functions: light arrives along `wi` and leaves along `wo`, and
//! both point away from the vertex. Coefficients are per unit of length, one a lane.

mod blocks;
mod colors;
mod flight;
mod grid;
mod homogeneous;
pub mod inversion;
mod phase;
mod reach;
mod track;
#[cfg(test)]
mod tracking;
mod varying;

pub use blocks::Blocks;
pub use colors::{ColorCells, Colors};
pub use flight::{Collision, Flight, density};
pub use grid::Grid;
pub use homogeneous::Homogeneous;
pub use phase::{Phase, PhaseSample};
pub use varying::Medium;
