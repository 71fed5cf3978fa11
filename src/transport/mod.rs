//! The transported quantity of a random walk. Scattering functions are always evaluated in the direction of light flow,
//! `eval(wi, wo)`: light arrives along `wi` and leaves along `wo`. Both point away from the surface. This holds for
//! camera and light subpaths.

mod outline;

pub use outline::ScatteringOutline;

/// Transported quantity, as in pbrt and Mitsuba.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum TransportMode {
    /// Radiance, in camera subpaths: `wo` is known and `wi` is sampled.
    Radiance,
    /// Importance, in light subpaths: `wi` is known and `wo` is sampled.
    Importance,
}

impl TransportMode {
    /// Returns the mode of a subpath from the other end of the path.
    #[inline]
    pub fn reversed(self) -> Self {
        match self {
            TransportMode::Radiance => TransportMode::Importance,
            TransportMode::Importance => TransportMode::Radiance,
        }
    }

    /// Orders (known, sampled) in the direction of light flow: `(wi, wo)`.
    #[inline]
    pub fn flow<D>(self, known: D, sampled: D) -> (D, D) {
        match self {
            TransportMode::Radiance => (sampled, known),
            TransportMode::Importance => (known, sampled),
        }
    }
}
