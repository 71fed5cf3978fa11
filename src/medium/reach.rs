//! The end of a flight through a density.

/// How far a flight got.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Reach {
    /// It ends at this distance, where the density is the second number.
    Ends(f32, f32),
    /// It passes the whole length, and the integral of the density over it is this.
    Passes(f32),
}
