//! A loaded and built scene, with the time that loading and building took.

use super::machine::{self, Stopwatch};
use super::{FrameNumber, Moment, Overrides, RenderSettings, SettingsPatch};
use crate::error::{Error, Result};
use crate::io::scene_file::{self, ReadOptions};
use crate::scene::description::Description;
use crate::scene::{BuildOptions, Scene, SceneInfo};
use std::path::{Path, PathBuf};

/// A scene that is ready to be rendered.
pub struct LoadedScene {
    /// The scene.
    pub scene: Scene,
    /// Path of its file.
    pub path: PathBuf,
    /// What is not that of its file.
    pub overrides: Overrides,
    /// Content of the scene.
    pub info: SceneInfo,
    /// Loading and building times.
    pub preparation: LoadTimings,
}

/// Loading and building times of a scene.
#[derive(Debug, Clone, Copy)]
pub struct LoadTimings {
    /// Seconds spent on reading and decoding.
    pub load_seconds: f64,
    /// Seconds spent on building, the acceleration structure included.
    pub build_seconds: f64,
    /// Number of threads available on the machine.
    pub threads: usize,
}

impl LoadedScene {
    /// Loads and builds the scene at `path`, at that `moment` of its animations, with these `overrides`. Must be called
    /// from outside the rayon pool. The caller has set up the pool with as many threads as `options` say.
    ///
    /// # Errors
    /// The scene, the environment or a medium cannot be read or is invalid.
    pub fn open(path: &Path, overrides: Overrides, moment: &Moment, options: &BuildOptions) -> Result<LoadedScene> {
        let loading = Stopwatch::start();
        let (seconds, animation) = (moment.frame.map(FrameNumber::seconds), moment.animation.as_deref());
        let memory = machine::available_memory().unwrap_or(u64::MAX);
        let mut description = scene_file::load_with(path, &ReadOptions { seconds, animation, memory })?;
        let doubt = moment.frame.and_then(|frame| frame.doubt(description.animation_end));
        description.warnings.extend(doubt);
        overrides.apply(&mut description, memory)?;
        let load_seconds = loading.wall().as_secs_f64();
        let stage = LoadedScene::build(description, path, overrides, options)?;
        Ok(LoadedScene { preparation: LoadTimings { load_seconds, ..stage.preparation }, ..stage })
    }

    /// Builds `description`, which came from `path` and has `overrides`. Must be called from outside the rayon pool.
    ///
    /// # Errors
    /// The description is invalid, or memory does not suffice.
    pub fn build(
        description: Description,
        path: &Path,
        overrides: Overrides,
        options: &BuildOptions,
    ) -> Result<LoadedScene> {
        let primitives = description.meshes.iter().flat_map(|mesh| &mesh.primitives);
        let need = primitives.map(|p| p.triangles.len() as u64).sum::<u64>() * options.backend.building_bytes();
        machine::affordable("building the scene", need, "give it more with --memory, or use embree")
            .map_err(|e| e.context(path.display()))?;
        let building = Stopwatch::start();
        let scene = Scene::build(description, options).map_err(|e| e.context(path.display()))?;
        let build_seconds = building.wall().as_secs_f64();
        let preparation = LoadTimings { load_seconds: 0.0, build_seconds, threads: options.threads };
        Ok(LoadedScene { info: scene.info().clone(), path: path.to_owned(), overrides, preparation, scene })
    }

    /// Resolves the settings with the aspect ratio of the scene's camera, and its lens.
    ///
    /// # Errors
    /// The camera does not exist or has no lens, the lens is focused on nothing, or a value is out of range.
    pub fn settings(&self, choices: &SettingsPatch) -> Result<RenderSettings> {
        let settings = choices.settings(self.scene.aspect(choices.camera.as_deref())?)?;
        let lens = choices
            .lens()?
            .map(|lens| lens.resolve(&self.scene, settings.camera.as_deref(), settings.width, settings.height));
        Ok(RenderSettings { lens: lens.transpose()?, ..settings })
    }

    /// Rejects a scene that uses features ignored by étendue.
    ///
    /// # Errors
    /// Names all ignored features.
    pub fn refuse_ignored(&self) -> Result<()> {
        if self.info.ignored.is_empty() {
            return Ok(());
        }
        Err(Error::scene(format!("{}: --strict: {}", self.path.display(), self.info.ignored.join("; "))))
    }
}
