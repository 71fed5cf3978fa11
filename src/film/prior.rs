//! What is known of a film's samples before the first is taken: what they share, and what light the method may miss.

use super::Independent;

/// What is known beforehand of a method's samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Known {
    /// What of the image is independent of the rest.
    pub independent: Independent,
    /// What light the method may miss in the scene.
    pub prior: Prior,
}

/// The light of a scene that a method samples by luck only, or not at all.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Prior {
    /// Whether the method is blind to some of the light: its expectation is then not the picture.
    pub blind: bool,
    /// The radiance that a sample may bring by a path whose last scattering hardly any technique of the method samples (caustics of
    /// small lamps, their mirror images); 0 where there is no such path.
    pub rare_radiance: f64,
}

/// Samples that nothing else is known of.
impl From<Independent> for Known {
    fn from(independent: Independent) -> Self {
        Known { independent, prior: Prior::default() }
    }
}
