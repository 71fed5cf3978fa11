//! Upper bounds of scattered light, for estimates with a guaranteed error.

/// An upper bound of F |cos| over all other directions, all smooth lobes: `diffuse` |cos| + `glossy`, where cos is the
/// cosine of the other direction to the shading normal. The greatest lane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScatteringBound {
    /// Factor of the cosine.
    pub diffuse: f32,
    /// Constant.
    pub glossy: f32,
}

impl ScatteringBound {
    /// No bound is known.
    pub const NONE: ScatteringBound = ScatteringBound { diffuse: 0.0, glossy: f32::INFINITY };
    /// Nothing scatters.
    pub(super) const ZERO: ScatteringBound = ScatteringBound { diffuse: 0.0, glossy: 0.0 };
}
