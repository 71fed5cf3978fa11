//! The medium inside a body.

use crate::medium::Homogeneous;

/// Interior medium of a material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Interior {
    /// The medium at density 1; coefficients are per scene unit of length.
    pub(super) medium: Homogeneous,
    /// Index of its density, if it varies.
    pub(super) density: Option<usize>,
    /// Index of its albedo, if it varies.
    pub(super) albedo: Option<usize>,
    /// Index of what multiplies its emission, if that varies.
    pub(super) emission_grid: Option<usize>,
    /// Refractive index.
    pub(super) ior: f32,
    /// Precedence: see `bodies`.
    pub(super) priority: i32,
}

impl Interior {
    /// Returns a key that is equal for equal interiors.
    pub(super) fn key(&self) -> ([u32; 14], [Option<usize>; 3], i32) {
        let mut bits = [0; 14];
        let numbers = self.medium.numbers().into_iter().chain([self.ior]);
        bits.iter_mut().zip(numbers).for_each(|(bits, number)| *bits = number.to_bits());
        (bits, [self.density, self.albedo, self.emission_grid], self.priority)
    }
}
