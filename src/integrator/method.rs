//! The methods by name.

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
}
