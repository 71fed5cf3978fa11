//! A job: all choices about a picture, resolved in one place.

use super::{
    LoadedScene, Overrides, PassPlan, PassSelection, Provenance, RenderSettings, SettingsPatch, Size, ToneMapping,
};
use crate::error::Result;
use crate::integrator::Method;
use std::path::Path;

/// Resolved choices about a picture. It exists before the scene is loaded, so that mistakes are reported at once; only
/// a missing height waits for the camera: see [`RenderJob::fitted`].
#[derive(Debug, Clone)]
pub struct RenderJob {
    /// Settings of the passes.
    pub settings: RenderSettings,
    /// Passes to render.
    pub plan: PassPlan,
    /// Tone mapping of PNG images.
    pub tone: ToneMapping,
    /// What is not that of the scene's file.
    pub overrides: Overrides,
    patch: SettingsPatch,
}

impl SettingsPatch {
    /// Resolves the choices for that selection of the passes.
    ///
    /// # Errors
    /// A usage error for the first value that is out of range or contradicts another.
    pub fn resolve(&self, selection: PassSelection) -> Result<RenderJob> {
        Ok(RenderJob {
            settings: self.settings(None)?,
            plan: self.plan(selection)?,
            tone: self.tone()?,
            overrides: self.overrides()?,
            patch: self.clone(),
        })
    }
}

impl RenderJob {
    /// Loads and builds the scene at `path` for this job. Must be called from outside the rayon pool, which has as many
    /// threads as `threads` says.
    ///
    /// # Errors
    /// As [`LoadedScene::open`].
    pub fn load(&self, path: &Path, threads: usize) -> Result<LoadedScene> {
        let settings = &self.settings;
        LoadedScene::open(path, self.overrides.clone(), &settings.moment(), &settings.build_options(threads))
    }

    /// Returns the job with the height that the scene's camera decides, if none was chosen.
    ///
    /// # Errors
    /// The camera does not exist, or the crop does not fit the image.
    pub fn fitted(self, stage: &LoadedScene) -> Result<RenderJob> {
        let mut patch = self.patch;
        let settings = stage.settings(&patch)?;
        patch.size = Some(Size { width: settings.width, height: Some(settings.height) });
        Ok(RenderJob { settings, patch, ..self })
    }

    /// Returns the settings with another method, which gets its parameters from the same choices.
    ///
    /// # Errors
    /// A choice contradicts the method.
    pub fn settings_of(&self, method: Method) -> Result<RenderSettings> {
        let replicates = Some(self.settings.replicates);
        let patch = SettingsPatch { method: Some(method), replicates, ..self.patch.clone() };
        Ok(RenderSettings { lens: self.settings.lens, ..patch.settings(None)? })
    }

    /// Returns the provenance of a film of this job that begins now. The job is fitted to the scene.
    pub fn provenance(self, stage: &LoadedScene) -> Provenance {
        Provenance::new(stage, self.settings, self.plan, self.tone)
    }
}
