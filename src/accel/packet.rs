//! Widths of packets, the groups of rays that a backend traces with one instruction stream.

/// Number of rays in a query of many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Packet {
    /// Single rays.
    One,
    /// Eight, with AVX.
    Eight,
    /// Sixteen, with AVX-512.
    Sixteen,
}

impl Packet {
    /// Returns the number of rays.
    pub fn rays(self) -> u32 {
        match self {
            Packet::One => 1,
            Packet::Eight => 8,
            Packet::Sixteen => 16,
        }
    }
}
