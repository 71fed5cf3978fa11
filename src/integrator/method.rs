//! Names of the integration methods, and the statistical structure of their images.

use crate::film::Independent;

/// A rendering method, as named on the command line, in `render.toml` and in reports.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    Default,
    serde::Serialize,
    serde::Deserialize,
    strum::VariantArray,
    strum::IntoStaticStr,
    strum::EnumMessage,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Method {
    /// Path tracing with uniformly sampled directions and no light sampling: a slow reference. Blind to point, spot and
    /// directional lights and to mirrors and clear glass.
    PathNaive,
    /// Path tracing with BSDF sampling and next-event estimation.
    PathNee,
    /// Path tracing with next-event estimation, multiple importance sampling and Russian roulette.
    #[default]
    Path,
    /// Light tracing: light subpaths with each vertex connected to the camera. Blind to what is seen in mirrors and
    /// through clear glass.
    Light,
    /// Bidirectional path tracing: subpaths from both ends and all connections between them, combined by multiple
    /// importance sampling.
    Bdpt,
    /// Metropolis light transport in primary sample space: chains of the random numbers of bidirectional path tracing.
    Pssmlt,
    /// Multiplexed Metropolis light transport: chains of single paths whose technique is one of the coordinates.
    Mmlt,
    /// Metropolis light transport in path space: chains of paths under mutations and perturbations.
    Mlt,
    /// Instant radiosity: every vertex of a camera path is lit by all virtual point lights of the pass. A reference for
    /// lightcuts.
    Vpl,
    /// Stochastic lightcuts: many lights and virtual point lights, chosen for each vertex of a camera path by a cut
    /// through their tree.
    Lightcuts,
    /// Deterministic lightcuts: lights and virtual point lights in groups, of each of which the same light stands for all,
    /// within an error bound. Biased: for previews.
    DeterministicLightcuts,
}

impl Method {
    /// Returns the statistically independent units of an image.
    pub fn independent(self) -> Independent {
        match self {
            Method::PathNaive | Method::PathNee | Method::Path => Independent::Pixels,
            // A light subpath splats to a few pixels anywhere, rarely the same ones again. A splat contributes to all
            // pixels in its filter footprint.
            Method::Light | Method::Bdpt => Independent::Blocks,
            // All pixels of a pass share the virtual lights.
            Method::Vpl | Method::Lightcuts | Method::DeterministicLightcuts => Independent::Replicates,
            Method::Pssmlt | Method::Mmlt | Method::Mlt => Independent::Replicates,
        }
    }

    /// Returns the methods that are compared unless others are named: all without virtual lights.
    pub fn compared() -> Vec<Method> {
        use strum::VariantArray;
        Method::VARIANTS.iter().copied().filter(|method| !method.has_virtual_lights()).collect()
    }

    /// Whether all pixels of a pass are lit by the same virtual lights.
    pub fn has_virtual_lights(self) -> bool {
        matches!(self, Method::Vpl | Method::Lightcuts | Method::DeterministicLightcuts)
    }

    /// Whether passes are groups of Markov chains.
    pub fn has_chains(self) -> bool {
        matches!(self, Method::Pssmlt | Method::Mmlt | Method::Mlt)
    }

    /// Default number of replicates for error estimation. Each replicate costs some of the advantage of quasi-random
    /// numbers. Where pixels themselves reveal the noise of the error estimate, the smallest number that does so is
    /// used.
    pub fn replicates(self) -> u32 {
        match self.independent() {
            Independent::Pixels | Independent::Blocks => 4,
            Independent::Replicates => 16,
        }
    }
}
