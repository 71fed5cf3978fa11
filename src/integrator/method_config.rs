//! Parameters of each method. A method has those that it reads and no others, so that settings that differ in nothing
//! else have one hash.

use super::{Method, Mutations};
use crate::path::{Technique, Techniques};
use crate::sampling::Heuristic;
use crate::subsurface::DiffusionModel;
use serde::{Deserialize, Serialize};

/// A method with its parameters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "method", rename_all = "kebab-case")]
pub enum MethodConfig {
    /// [`Method::PathNaive`].
    PathNaive,
    /// [`Method::PathNee`].
    PathNee(PathConfig),
    /// [`Method::Path`].
    Path(PathConfig),
    /// [`Method::Light`].
    Light,
    /// [`Method::Bdpt`].
    Bdpt(BdptConfig),
    /// [`Method::Vpl`].
    Vpl(VirtualLightsConfig),
    /// [`Method::Lightcuts`].
    Lightcuts(LightcutsConfig),
    /// [`Method::DeterministicLightcuts`].
    DeterministicLightcuts(DeterministicLightcutsConfig),
    /// [`Method::Pssmlt`].
    Pssmlt(PssmltConfig),
    /// [`Method::Mmlt`].
    Mmlt(MmltConfig),
    /// [`Method::Mlt`].
    Mlt(MltConfig),
}

/// Parameters of path tracing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct PathConfig {
    /// Approximation of subsurface scattering; `None` for the random walk, which is exact.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub subsurface: Option<DiffusionModel>,
}

/// Parameters of bidirectional path tracing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BdptConfig {
    /// Enabled techniques, stored as the list of disabled ones.
    #[serde(rename = "without", with = "disabled")]
    pub techniques: Techniques,
    /// Heuristic of the MIS weights.
    pub heuristic: Heuristic,
}

/// Parameters of all methods with virtual lights, and those of instant radiosity.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct VirtualLightsConfig {
    /// Light subpaths of a pass; `None` for the default of the method.
    pub virtual_lights: Option<u32>,
    /// Limit of the contribution of a virtual light, as a multiple of the typical radiance, without compensation;
    /// `None` for none.
    pub clamp_vpl: Option<f64>,
}

/// Parameters of stochastic lightcuts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct LightcutsConfig {
    /// Virtual lights.
    #[serde(flatten)]
    pub virtual_lights: VirtualLightsConfig,
    /// Groups of a cut, of the scene's lights and of virtual lights.
    pub cut_size: u32,
}

/// Parameters of deterministic lightcuts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct DeterministicLightcutsConfig {
    /// Virtual lights.
    #[serde(flatten)]
    pub virtual_lights: VirtualLightsConfig,
    /// Largest error of the light at a point, as a share of it.
    pub cut_error: f64,
}

/// Parameters of all methods with chains.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct ChainsConfig {
    /// Chains in a pass; `None` to derive it from the image size.
    pub chains: Option<u32>,
    /// Threshold of bidirectional samples, as a multiple of the typical radiance at their position; chains estimate the
    /// excess. 0 assigns everything to chains; `None` lets a pilot decide.
    pub chain_threshold: Option<f64>,
    /// Whether chains visit all parts of the image equally, dark or bright.
    pub two_stage: bool,
}

/// Parameters of Metropolis light transport in primary sample space.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct PssmltConfig {
    /// Bidirectional samples.
    #[serde(flatten)]
    pub bdpt: BdptConfig,
    /// Chains.
    #[serde(flatten)]
    pub chains: ChainsConfig,
    /// Probability of a large step.
    pub large_step: f64,
}

/// Parameters of multiplexed Metropolis light transport.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct MmltConfig {
    /// Bidirectional samples.
    #[serde(flatten)]
    pub bdpt: BdptConfig,
    /// Chains.
    #[serde(flatten)]
    pub chains: ChainsConfig,
    /// Probability of a large step.
    pub large_step: f64,
    /// Maximum path length, in scattering events, with chains of its own; longer paths share one class.
    pub mmlt_depths: u32,
}

/// Parameters of Metropolis light transport in path space.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct MltConfig {
    /// Bidirectional samples.
    #[serde(flatten)]
    pub bdpt: BdptConfig,
    /// Chains.
    #[serde(flatten)]
    pub chains: ChainsConfig,
    /// Relative frequencies of the mutations.
    pub mutations: Mutations,
}

impl Default for BdptConfig {
    fn default() -> Self {
        BdptConfig { techniques: Techniques::ALL, heuristic: Heuristic::default() }
    }
}

impl Default for LightcutsConfig {
    fn default() -> Self {
        LightcutsConfig { virtual_lights: VirtualLightsConfig::default(), cut_size: 8 }
    }
}

impl Default for DeterministicLightcutsConfig {
    fn default() -> Self {
        DeterministicLightcutsConfig { virtual_lights: VirtualLightsConfig::default(), cut_error: 0.1 }
    }
}

impl Default for PssmltConfig {
    fn default() -> Self {
        PssmltConfig { bdpt: BdptConfig::default(), chains: ChainsConfig::default(), large_step: 0.3 }
    }
}

impl Default for MmltConfig {
    fn default() -> Self {
        MmltConfig { bdpt: BdptConfig::default(), chains: ChainsConfig::default(), large_step: 0.3, mmlt_depths: 8 }
    }
}

impl From<Method> for MethodConfig {
    /// Returns the method with its defaults.
    fn from(method: Method) -> Self {
        match method {
            Method::PathNaive => MethodConfig::PathNaive,
            Method::PathNee => MethodConfig::PathNee(PathConfig::default()),
            Method::Path => MethodConfig::Path(PathConfig::default()),
            Method::Light => MethodConfig::Light,
            Method::Bdpt => MethodConfig::Bdpt(BdptConfig::default()),
            Method::Vpl => MethodConfig::Vpl(VirtualLightsConfig::default()),
            Method::Lightcuts => MethodConfig::Lightcuts(LightcutsConfig::default()),
            Method::DeterministicLightcuts => {
                MethodConfig::DeterministicLightcuts(DeterministicLightcutsConfig::default())
            }
            Method::Pssmlt => MethodConfig::Pssmlt(PssmltConfig::default()),
            Method::Mmlt => MethodConfig::Mmlt(MmltConfig::default()),
            Method::Mlt => MethodConfig::Mlt(MltConfig::default()),
        }
    }
}

impl Default for MethodConfig {
    fn default() -> Self {
        Method::default().into()
    }
}

impl MethodConfig {
    /// Returns the method.
    pub fn kind(&self) -> Method {
        match self {
            MethodConfig::PathNaive => Method::PathNaive,
            MethodConfig::PathNee(_) => Method::PathNee,
            MethodConfig::Path(_) => Method::Path,
            MethodConfig::Light => Method::Light,
            MethodConfig::Bdpt(_) => Method::Bdpt,
            MethodConfig::Vpl(_) => Method::Vpl,
            MethodConfig::Lightcuts(_) => Method::Lightcuts,
            MethodConfig::DeterministicLightcuts(_) => Method::DeterministicLightcuts,
            MethodConfig::Pssmlt(_) => Method::Pssmlt,
            MethodConfig::Mmlt(_) => Method::Mmlt,
            MethodConfig::Mlt(_) => Method::Mlt,
        }
    }

    /// Returns the parameters of its bidirectional samples. Light tracing has one technique, of weight 1.
    pub fn bdpt(&self) -> BdptConfig {
        match self {
            MethodConfig::Bdpt(bdpt) => *bdpt,
            MethodConfig::Pssmlt(config) => config.bdpt,
            MethodConfig::Mmlt(config) => config.bdpt,
            MethodConfig::Mlt(config) => config.bdpt,
            MethodConfig::Light => BdptConfig { techniques: Techniques::LIGHT, ..BdptConfig::default() },
            MethodConfig::PathNaive
            | MethodConfig::PathNee(_)
            | MethodConfig::Path(_)
            | MethodConfig::Vpl(_)
            | MethodConfig::Lightcuts(_)
            | MethodConfig::DeterministicLightcuts(_) => BdptConfig::default(),
        }
    }

    /// Returns the diffusion model that replaces random walks in bodies, if any. The image is then approximate.
    pub fn subsurface(&self) -> Option<DiffusionModel> {
        match self {
            MethodConfig::PathNee(config) | MethodConfig::Path(config) => config.subsurface,
            _ => None,
        }
    }

    /// Returns the limit of virtual lights that is not compensated, if any.
    pub fn clamp_vpl(&self) -> Option<f64> {
        match self {
            MethodConfig::Vpl(config) => config.clamp_vpl,
            MethodConfig::Lightcuts(config) => config.virtual_lights.clamp_vpl,
            MethodConfig::DeterministicLightcuts(config) => config.virtual_lights.clamp_vpl,
            _ => None,
        }
    }

    /// Returns the parameters of its chains; the defaults for a method without chains.
    pub fn chains(&self) -> ChainsConfig {
        match self {
            MethodConfig::Pssmlt(config) => config.chains,
            MethodConfig::Mmlt(config) => config.chains,
            MethodConfig::Mlt(config) => config.chains,
            _ => ChainsConfig::default(),
        }
    }
}

/// Techniques as the list of those that are disabled.
mod disabled {
    use super::{Deserialize, Serialize, Technique, Techniques};
    use serde::{Deserializer, Serializer};

    pub(super) fn serialize<S: Serializer>(techniques: &Techniques, serializer: S) -> Result<S::Ok, S::Error> {
        techniques.disabled().serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Techniques, D::Error> {
        Vec::<Technique>::deserialize(deserializer).map(|list| Techniques::without(&list))
    }
}
