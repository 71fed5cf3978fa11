//! Random numbers and sampling: addressed samplers, densities typed by measure, warps with their pdf and inverse,
//! discrete distributions.

mod hash;
mod heuristic;
mod independent;
mod pdf;
mod sobol;
mod table;
pub mod warp;

pub use hash::{Address, mix64, unit_f32, unit_f64};
pub use heuristic::{Heuristic, balance, power};
pub use independent::IndependentSampler;
pub use pdf::{Area, Density, Discrete, Measure, Pdf, SolidAngle};
pub use sobol::Sobol;
pub use table::Distribution;

/// Purpose of a random number at one bounce. Random numbers are addressed by slot instead of consumed in order, so that
/// control flow does not change the meaning of the others. Counts of dimensions are in parentheses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Slot {
    /// BSDF lobe selection (1).
    Lobe = 0,
    /// Direction (2), slots 1 and 2.
    Direction = 1,
    /// Light selection (1).
    LightPick = 3,
    /// Point on a light (2), slots 4 and 5.
    LightPoint = 4,
    /// Russian roulette (1).
    Roulette = 6,
    /// Distance in a medium (1).
    Distance = 7,
    /// Events along an edge: alpha and null boundaries (1).
    Event = 8,
    /// Wavelength channel selection (1).
    Channel = 9,
    /// Auxiliary (2), slots 10 and 11; at bounce 0 the position within the pixel.
    Aux = 10,
    /// Point of the camera's lens (2). No camera has one yet.
    Lens = 11,
}

/// Number of slots per bounce.
pub const SLOTS: u32 = 12;

/// Sampler types.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SamplerKind {
    /// Independent random numbers.
    Independent,
    /// Owen-scrambled Sobol' points.
    #[default]
    Sobol,
}

/// A source of random numbers in [0, 1), each a pure function of its address.
pub trait Sampler {
    /// Returns one random number.
    fn u1(&mut self, bounce: u32, slot: Slot) -> f32;
    /// Returns two random numbers, jointly stratified if the sampler stratifies.
    fn u2(&mut self, bounce: u32, slot: Slot) -> [f32; 2];
}
