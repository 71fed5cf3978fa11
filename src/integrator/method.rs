//! The methods by name, and what their pictures are made of.

use crate::film::Independent;

/// A rendering method, as the command line, `render.toml` and reports name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Path tracing with uniformly sampled directions and no light sampling: a slow reference. Blind to point, spot and
    /// directional lights and to mirrors and clear glass.
    PathNaive,
    /// Path tracing with BSDF sampling and next-event estimation.
    PathNee,
    /// Path tracing with next-event estimation, multiple importance sampling and Russian roulette.
    #[default]
    Path,
    /// Light tracing: walks from lights, each vertex connected with the camera. Blind to what is seen in mirrors and through clear
    /// glass.
    Light,
    /// Bidirectional path tracing: walks from both ends and every connection between them, combined by multiple importance sampling.
    Bdpt,
    /// Metropolis light transport in primary sample space: chains of the numbers of bidirectional path tracing.
    Pssmlt,
    /// Multiplexed Metropolis light transport: chains of single paths whose technique is a number of theirs.
    Mmlt,
    /// Metropolis light transport in path space: chains of paths under mutations and perturbations.
    Mlt,
}

impl Method {
    /// What of its pictures is independent of the rest.
    pub fn independent(self) -> Independent {
        match self {
            Method::PathNaive | Method::PathNee | Method::Path => Independent::Pixels,
            // A walk from a light falls on a few pixels anywhere, which is seldom twice on the same ones; a splat reaches all pixels
            // that its filter covers.
            Method::Light | Method::Bdpt => Independent::Blocks,
            Method::Pssmlt | Method::Mmlt | Method::Mlt => Independent::Replicates,
        }
    }

    /// Whether its passes are groups of Markov chains.
    pub fn has_chains(self) -> bool {
        self.independent() == Independent::Replicates
    }

    /// How many replicates its error is measured between if nobody says otherwise. Each costs some of the advantage of
    /// quasi-random numbers: where pixels tell the noise of the error, the least do that say what the noise is.
    pub fn replicates(self) -> u32 {
        match self.independent() {
            Independent::Pixels | Independent::Blocks => 4,
            Independent::Replicates => 16,
        }
    }
}
