//! Selection of the candidates: every method that samples all light of the scene, with every backend.

use super::REPLICATES;
use crate::accel::Backend;
use crate::error::{Error, Result};
use crate::integrator::{self, Method};
use crate::lab::unique;
use crate::named::Named;
use crate::scene::Scene;
use crate::session::{LoadedScene, RenderSettings, SettingsPatch, Size};
use serde::Serialize;

/// Requested candidates; `None` stands for all.
#[derive(Debug, Clone, Default)]
pub struct VerifyRequest {
    /// Only these methods.
    pub methods: Option<Vec<Method>>,
    /// Only these backends.
    pub backends: Option<Vec<Backend>>,
}

/// Methods to compare, and excluded methods.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Lineup {
    /// The compared methods.
    pub methods: Vec<Method>,
    /// The excluded methods.
    pub excluded: Vec<Excluded>,
}

/// An excluded method.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Excluded {
    /// The method.
    pub method: Method,
    /// Its blind spots in the scene, one sentence each.
    pub reasons: Vec<String>,
}

impl VerifyRequest {
    /// Returns the requested backends without duplicates.
    pub fn backends(&self) -> Vec<Backend> {
        unique(self.backends.as_deref().unwrap_or(Backend::AVAILABLE))
    }

    /// Selects the requested methods that can be compared on `scene`.
    ///
    /// # Errors
    /// A usage error if there are fewer than two candidates.
    pub fn lineup(&self, scene: &Scene) -> Result<Lineup> {
        let wanted = unique(self.methods.as_deref().unwrap_or(&Method::compared()));
        let judged =
            wanted.into_iter().map(|method| Excluded { method, reasons: integrator::blind_spots(method, scene) });
        let (seeing, excluded): (Vec<_>, Vec<_>) = judged.partition(|e| e.reasons.is_empty());
        let lineup = Lineup { methods: seeing.into_iter().map(|e| e.method).collect(), excluded };
        let candidates = lineup.methods.len() * self.backends().len();
        if candidates >= 2 { Ok(lineup) } else { Err(too_few(&lineup, candidates)) }
    }
}

fn too_few(lineup: &Lineup, candidates: usize) -> Error {
    let how_many = if candidates == 0 { "no method" } else { "one method with one backend" };
    let reasons: String = lineup.excluded.iter().flat_map(|e| &e.reasons).map(|r| format!("; {r}")).collect();
    Error::usage(format!("nothing to compare: {how_many} is left, and two are needed (--methods, --backends){reasons}"))
}

/// Default length of the longer side, in pixels. It is small, since many samples in few pixels give the smallest error.
const LONGEST_SIDE: f64 = 128.0;

/// Returns the default size for a camera with aspect ratio `aspect` (width over height).
pub fn default_size(aspect: Option<f64>) -> Size {
    let aspect = aspect.filter(|a| a.is_finite() && *a > 0.0).unwrap_or(16.0 / 9.0);
    let side = |ratio: f64| (LONGEST_SIDE * ratio.min(1.0)).round().max(1.0) as u32;
    Size { width: side(aspect), height: Some(side(1.0 / aspect)) }
}

/// Resolves the settings of a candidate. Its seed depends on its name and the given seed, but not on the other
/// candidates.
pub(super) fn settings(
    choices: &SettingsPatch,
    stage: &LoadedScene,
    method: Method,
    backend: Backend,
) -> Result<RenderSettings> {
    let aspect = stage.scene.aspect(choices.camera.as_deref())?;
    let size = choices.size.unwrap_or_else(|| default_size(aspect));
    // Clamping biases each method differently. AOVs are not compared.
    let choices = SettingsPatch {
        method: Some(method),
        backend: Some(backend),
        seed: Some(seed(choices.seed.unwrap_or(0), method, backend)),
        replicates: Some(REPLICATES),
        size: Some(size),
        clamp: None,
        aovs: None,
        ..choices.clone()
    };
    stage.settings(&choices)
}

fn seed(seed: u64, method: Method, backend: Backend) -> u64 {
    let hash = blake3::hash(format!("verify {seed} {} {}", method.name(), backend.name()).as_bytes());
    // 48 bits, which every JSON reader preserves.
    hash.as_bytes()[..6].iter().fold(0, |bits, &byte| bits << 8 | u64::from(byte))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn candidates_have_their_own_seeds() {
        let mut seeds = vec![seed(0, Method::Path, Backend::Obvhs), seed(1, Method::Path, Backend::Obvhs)];
        seeds.push(seed(0, Method::Path, Backend::Embree));
        seeds.push(seed(0, Method::PathNee, Backend::Obvhs));
        assert_eq!(unique(&seeds).len(), 4);
    }

    #[test]
    fn the_longest_side_is_the_same_for_all_shapes() {
        for (aspect, width, height) in
            [(Some(1.0), 128, 128), (Some(2.0), 128, 64), (Some(0.5), 64, 128), (None, 128, 72)]
        {
            assert_eq!(default_size(aspect), Size { width, height: Some(height) });
        }
        assert_eq!(default_size(Some(1e9)), Size { width: 128, height: Some(1) });
    }
}
