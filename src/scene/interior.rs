//! The medium inside a body.

use crate::spectrum::Spectrum;

/// Interior medium of a material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Interior {
    /// Absorption coefficient per scene unit of length.
    pub(super) absorption: Spectrum,
    /// Refractive index.
    pub(super) ior: f32,
    /// Precedence: see `bodies`.
    pub(super) priority: i32,
}

impl Interior {
    /// Returns a key that is equal for equal interiors.
    pub(super) fn key(&self) -> ([u32; 4], i32) {
        let [r, g, b] = self.absorption.0;
        ([r, g, b, self.ior].map(f32::to_bits), self.priority)
    }
}
