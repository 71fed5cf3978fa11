//! Prior knowledge of a method's samples: their independence, and the light that the method may miss.

use super::Independent;

/// Prior knowledge of a method's samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Known {
    /// Independent parts of the image.
    pub independent: Independent,
    /// Light of the scene that the method may miss.
    pub prior: Prior,
}

/// Light of a scene that the method samples rarely or not at all.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Prior {
    /// Whether the method cannot sample some of the light; its expectation then differs from the true image.
    pub blind: bool,
    /// Bound on the radiance of a sample whose last scattering is hardly sampled by any technique of the method
    /// (caustics of small lamps, their mirror images); 0 without such paths.
    pub rare_radiance: f64,
}

/// Samples without any other prior knowledge.
impl From<Independent> for Known {
    fn from(independent: Independent) -> Self {
        Known { independent, prior: Prior::default() }
    }
}
