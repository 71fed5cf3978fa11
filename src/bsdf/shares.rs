//! Which part of a surface's scattering is diffuse and which a lobe, in outline.

/// Weights of a [`ScatteringOutline`](crate::transport::ScatteringOutline), for one known direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares<F = f32> {
    /// Weight of the diffuse part, and of transmission.
    pub diffuse: F,
    /// Weight of the lobe of reflection.
    pub glossy: F,
    /// α² of its facets.
    pub alpha2: F,
}

impl Shares {
    /// All is diffuse.
    pub(super) const DIFFUSE: Shares = Shares { diffuse: 1.0, glossy: 0.0, alpha2: 1.0 };
}
