//! Which way a walk goes. Scattering functions are always evaluated in light flow, `eval(wi, wo)`: light arrives along
//! `wi` and leaves along `wo` (both point away from the surface), whichever end the walk came from.

/// The end of the path that a walk goes toward.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Transport {
    /// A camera walk, toward the light: `wo` is known and `wi` is sampled.
    Light,
    /// A light walk, toward the camera: `wi` is known and `wo` is sampled.
    Camera,
}

impl Transport {
    /// The way of a walk from the other end.
    #[inline]
    pub fn reversed(self) -> Self {
        match self {
            Transport::Light => Transport::Camera,
            Transport::Camera => Transport::Light,
        }
    }

    /// Orders (known, sampled) as the light flows: `(wi, wo)`.
    #[inline]
    pub fn flow<D>(self, known: D, sampled: D) -> (D, D) {
        match self {
            Transport::Light => (sampled, known),
            Transport::Camera => (known, sampled),
        }
    }
}
