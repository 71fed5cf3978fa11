//! Random numbers and sampling: addressed samplers, densities typed by measure, warps with their pdf and inverse,
//! discrete distributions.

mod hash;
mod heuristic;
mod independent;
pub mod lanes;
mod pdf;
mod sobol;
mod table;
pub mod warp;

pub use hash::{Address, mix64, unit_f32, unit_f64};
pub use heuristic::{Heuristic, power};
pub use independent::IndependentSampler;
pub use pdf::{Area, Density, Discrete, Measure, Pdf, SolidAngle};
pub use sobol::Sobol;
pub use table::Distribution;

/// Purpose of a random number at one bounce. Random numbers are addressed by slot instead of consumed in order, so that
/// control flow does not change the meaning of the others. A slot of two dimensions takes two numbers. Samplers that
/// stratify do so alike in every slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Slot {
    /// BSDF lobe selection.
    Lobe = 0,
    /// Direction, two dimensions.
    Direction = 1,
    /// Light selection, where the first number of the point does not also select.
    LightPick = 3,
    /// Point on a light, two dimensions.
    LightPoint = 4,
    /// Russian roulette.
    Roulette = 6,
    /// Events along an edge in their order, each decided by what the one before left of the number: surfaces that blend
    /// by alpha, null boundaries, collisions in media.
    Event = 7,
    /// Free flight in media, two dimensions: the lane, and the optical depth.
    MediumDistance = 8,
    /// Position on the film, two dimensions, at bounce 0.
    Film = 10,
    /// Point of the camera's lens, two dimensions: of a camera subpath at bounce 0, and of the connection of a light
    /// subpath's vertex to the camera at the bounce of the vertex.
    Lens = 12,
    /// Time in the shutter interval, at bounce 0. Nothing draws it yet.
    Time = 14,
    /// Length of a path in multiplexed chains; spare elsewhere.
    PathLength = 15,
}

/// Number of slots per bounce.
pub const SLOTS: u32 = 16;

/// Sampler types.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    Default,
    serde::Serialize,
    serde::Deserialize,
    strum::VariantArray,
    strum::IntoStaticStr,
    strum::EnumMessage,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum SamplerKind {
    /// Independent random numbers.
    Independent,
    /// Owen-scrambled Sobol' points.
    #[default]
    Sobol,
}

/// A source of random numbers in [0, 1), each a pure function of its address; in each lane of `F` one of its own.
pub trait Sampler<F = f32> {
    /// Returns one random number.
    fn u1(&mut self, bounce: u32, slot: Slot) -> F;
    /// Returns two random numbers, jointly stratified if the sampler stratifies.
    fn u2(&mut self, bounce: u32, slot: Slot) -> [F; 2];
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No two numbers of a path share an address: neither two slots of a bounce nor those of two bounces.
    #[test]
    fn slots_of_a_bounce_do_not_overlap() {
        use Slot::*;
        let slots = [
            (Lobe, 1),
            (Direction, 2),
            (LightPick, 1),
            (LightPoint, 2),
            (Roulette, 1),
            (Event, 1),
            (MediumDistance, 2),
            (Film, 2),
            (Lens, 2),
            (Time, 1),
            (PathLength, 1),
        ];
        let taken: Vec<u32> = slots.iter().flat_map(|&(slot, size)| slot as u32..slot as u32 + size).collect();
        assert_eq!(taken, (0..SLOTS).collect::<Vec<u32>>());
    }
}
