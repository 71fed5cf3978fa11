//! Random numbers and what is made of them: addressed samplers, densities that say their measure, warps with their pdf
//! and inverse, discrete tables.

mod hash;
mod heuristic;
mod independent;
mod pdf;
mod sobol;
mod table;
pub mod warp;

pub use hash::{Address, mix64, unit_f32, unit_f64};
pub use heuristic::{Heuristic, balance, power};
pub use independent::Independent;
pub use pdf::{Area, Density, Discrete, Measure, Pdf, SolidAngle};
pub use sobol::Sobol;
pub use table::Distribution;

/// What a number is used for at one bounce. Numbers are addressed by slot and never consumed in order, so that control
/// flow cannot shift the meaning of another number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Slot {
    /// Choice of a BSDF lobe (1).
    Lobe = 0,
    /// Direction (2), slots 1 and 2.
    Direction = 1,
    /// Choice of a light (1).
    LightPick = 3,
    /// Point on a light (2), slots 4 and 5.
    LightPoint = 4,
    /// Russian roulette (1).
    Roulette = 6,
    /// Distance in a medium (1).
    Distance = 7,
    /// Events on an edge: alpha and null boundaries (1).
    Event = 8,
    /// Choice of a wavelength channel (1).
    Channel = 9,
    /// Auxiliary (2), slots 10 and 11; at bounce 0 the position in the pixel.
    Aux = 10,
}

/// How many slots one bounce has.
pub const SLOTS: u32 = 12;

/// The samplers by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SamplerKind {
    /// Independent numbers.
    Independent,
    /// Owen-scrambled Sobol' points.
    #[default]
    Sobol,
}

/// A source of numbers in [0, 1), each a pure function of its address.
pub trait Sampler {
    /// One number.
    fn u1(&mut self, bounce: u32, slot: Slot) -> f32;
    /// Two numbers that are stratified together where the sampler stratifies.
    fn u2(&mut self, bounce: u32, slot: Slot) -> [f32; 2];
}
