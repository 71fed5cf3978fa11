//! Resolution of the method and its parameters.

use super::SettingsPatch;
use super::settings_patch::{between, in_range};
use crate::error::{Error, Result};
use crate::integrator::{
    BdptConfig, ChainsConfig, DeterministicLightcutsConfig, LightcutsConfig, MOST_GROUPS, MethodConfig, MltConfig,
    MmltConfig, PathConfig, PssmltConfig, VirtualLightsConfig,
};
use crate::path::Techniques;

/// Limit of the light subpaths with virtual lights: about 8 GB.
const MOST_VIRTUAL_LIGHTS: u32 = 1 << 22;

impl SettingsPatch {
    /// Resolves the method and its parameters.
    ///
    /// # Errors
    /// A value is out of range, whether or not the method reads it, or contradicts the method.
    pub fn method_config(&self) -> Result<MethodConfig> {
        let method = self.method.unwrap_or_default();
        let techniques = Techniques::without(self.without.as_deref().unwrap_or_default());
        let bdpt = BdptConfig { techniques, heuristic: self.heuristic.unwrap_or_default() };
        let chains = self.chains_config()?;
        let (pssmlt, mmlt) = (PssmltConfig::default(), MmltConfig::default());
        let large_step = self.large_step.unwrap_or(pssmlt.large_step);
        if !(large_step > 0.0 && large_step <= 1.0) {
            return Err(Error::usage(
                "large-step must be above 0 and at most 1: small steps alone do not reach every path",
            ));
        }
        let mmlt_depths = between("mmlt-depths", self.mmlt_depths.unwrap_or(mmlt.mmlt_depths), 2..=64)?;
        let virtual_lights = self.virtual_lights_config()?;
        let (lightcuts, bounded) = (LightcutsConfig::default(), DeterministicLightcutsConfig::default());
        let cut_size = between("cut-size", self.cut_size.unwrap_or(lightcuts.cut_size), 1..=MOST_GROUPS)?;
        let cut_error = self.cut_error.unwrap_or(bounded.cut_error);
        if !(cut_error >= 0.0 && cut_error.is_finite()) {
            return Err(Error::usage("cut-error must not be negative"));
        }
        if self.clamp.is_some() && method.has_chains() {
            return Err(Error::usage(
                "clamp does nothing sensible to chains, whose samples are all alike: leave it out",
            ));
        }
        let path = PathConfig { subsurface: self.subsurface };
        Ok(match MethodConfig::from(method) {
            MethodConfig::PathNee(_) => MethodConfig::PathNee(path),
            MethodConfig::Path(_) => MethodConfig::Path(path),
            MethodConfig::Bdpt(_) => MethodConfig::Bdpt(bdpt),
            MethodConfig::Vpl(_) => MethodConfig::Vpl(virtual_lights),
            MethodConfig::Lightcuts(_) => MethodConfig::Lightcuts(LightcutsConfig { virtual_lights, cut_size }),
            MethodConfig::DeterministicLightcuts(_) => {
                MethodConfig::DeterministicLightcuts(DeterministicLightcutsConfig { virtual_lights, cut_error })
            }
            MethodConfig::Pssmlt(_) => MethodConfig::Pssmlt(PssmltConfig { bdpt, chains, large_step }),
            MethodConfig::Mmlt(_) => MethodConfig::Mmlt(MmltConfig { bdpt, chains, large_step, mmlt_depths }),
            MethodConfig::Mlt(_) => {
                MethodConfig::Mlt(MltConfig { bdpt, chains, mutations: self.mutations.unwrap_or_default() })
            }
            MethodConfig::PathNaive => MethodConfig::PathNaive,
            MethodConfig::Light => MethodConfig::Light,
        })
    }

    fn virtual_lights_config(&self) -> Result<VirtualLightsConfig> {
        if self.clamp_vpl.is_some_and(|clamp| !(clamp > 0.0 && clamp.is_finite())) {
            return Err(Error::usage("clamp-vpl must be above zero"));
        }
        let count = |count| in_range("virtual-lights", count, MOST_VIRTUAL_LIGHTS);
        let virtual_lights = self.virtual_lights.map(count).transpose()?;
        Ok(VirtualLightsConfig { virtual_lights, clamp_vpl: self.clamp_vpl })
    }

    fn chains_config(&self) -> Result<ChainsConfig> {
        if self.chain_threshold.is_some_and(|threshold| !(threshold >= 0.0 && threshold.is_finite())) {
            return Err(Error::usage("chain-threshold must not be negative"));
        }
        let chains = self.chains.map(|chains| in_range("chains", chains, 1 << 20)).transpose()?;
        Ok(ChainsConfig {
            chains,
            chain_threshold: self.chain_threshold,
            two_stage: self.two_stage.unwrap_or_default(),
        })
    }
}
