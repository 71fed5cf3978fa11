//! Methods with the parameters that tests vary.

use etendue::integrator::{BdptConfig, ChainsConfig, Method, MethodConfig, MltConfig, MmltConfig, PssmltConfig};
use etendue::path::Techniques;

/// Parameters of methods with chains that tests vary; `None` and `false` stand for the defaults.
#[derive(Debug, Clone, Copy, Default)]
pub struct ChainOptions {
    /// See [`ChainsConfig::chain_threshold`].
    pub threshold: Option<f64>,
    /// See [`MmltConfig::mmlt_depths`].
    pub depths: Option<u32>,
    /// See [`ChainsConfig::two_stage`].
    pub two_stage: bool,
}

impl ChainOptions {
    /// Everything is left to chains.
    pub fn all() -> Self {
        ChainOptions { threshold: Some(0.0), ..ChainOptions::default() }
    }

    /// Returns `method` with these parameters and with those `techniques`, where it has them.
    pub fn config(self, method: Method, techniques: Techniques) -> MethodConfig {
        let bdpt = BdptConfig { techniques, ..BdptConfig::default() };
        let chains =
            ChainsConfig { chain_threshold: self.threshold, two_stage: self.two_stage, ..ChainsConfig::default() };
        match method.into() {
            MethodConfig::Bdpt(_) => MethodConfig::Bdpt(bdpt),
            MethodConfig::Pssmlt(config) => MethodConfig::Pssmlt(PssmltConfig { bdpt, chains, ..config }),
            MethodConfig::Mlt(config) => MethodConfig::Mlt(MltConfig { bdpt, chains, ..config }),
            MethodConfig::Mmlt(config) => {
                let mmlt_depths = self.depths.unwrap_or(config.mmlt_depths);
                MethodConfig::Mmlt(MmltConfig { bdpt, chains, mmlt_depths, ..config })
            }
            plain => plain,
        }
    }
}
