//! A scene loaded and built, with what that took.

use super::machine::{self, Stopwatch};
use super::{Choices, Frame, Moment, Settings, Surroundings};
use crate::error::{Error, Result};
use crate::io::gltf;
use crate::scene::{BuildOptions, Scene, SceneInfo};
use std::path::{Path, PathBuf};

/// A scene that is ready to be rendered.
pub struct Stage {
    /// The scene.
    pub scene: Scene,
    /// Where it came from.
    pub path: PathBuf,
    /// What was put around it.
    pub surroundings: Option<Surroundings>,
    /// What is in it.
    pub info: SceneInfo,
    /// What it took.
    pub preparation: Preparation,
}

/// What it took until a scene was ready.
#[derive(Debug, Clone, Copy)]
pub struct Preparation {
    /// Seconds that reading and decoding took.
    pub load_seconds: f64,
    /// Seconds that building took, the acceleration structure included.
    pub build_seconds: f64,
    /// Threads that the machine grants.
    pub threads: usize,
}

impl Stage {
    /// Loads and builds the scene at `path`, at that `moment` of its animations and with `surroundings` instead of its own if given.
    /// Call it from outside the rayon pool, which the caller has set up with as many threads as `options` say.
    ///
    /// # Errors
    /// A scene or an environment that cannot be read or is invalid.
    pub fn open(path: &Path, surroundings: Option<Surroundings>, moment: &Moment, options: &BuildOptions) -> Result<Stage> {
        let loading = Stopwatch::start();
        let (seconds, animation) = (moment.frame.map(Frame::seconds), moment.animation.as_deref());
        let memory = machine::available_memory().unwrap_or(u64::MAX);
        let mut description = gltf::load_with(path, &gltf::Reading { seconds, animation, memory })?;
        let doubt = moment.frame.and_then(|frame| frame.doubt(description.animation_end));
        description.warnings.extend(doubt);
        if let Some(surroundings) = &surroundings {
            surroundings.surround(&mut description)?;
        }
        let triangles =
            description.meshes.iter().flat_map(|mesh| &mesh.primitives).map(|p| p.triangles.len() as u64).sum::<u64>();
        let need = triangles * options.backend.building_bytes();
        machine::affordable("building the scene", need, "give it more with --memory, or use embree")
            .map_err(|e| e.context(path.display()))?;
        let building = Stopwatch::start();
        let load_seconds = loading.wall().as_secs_f64();
        let scene = Scene::build(description, options).map_err(|e| e.context(path.display()))?;
        let info = scene.info().clone();
        Ok(Stage {
            info,
            path: path.to_owned(),
            surroundings,
            preparation: Preparation { load_seconds, build_seconds: building.wall().as_secs_f64(), threads: options.threads },
            scene,
        })
    }

    /// The settings that were chosen, with what the scene's camera decides.
    ///
    /// # Errors
    /// A camera that is not there, values out of range.
    pub fn settings(&self, choices: &Choices) -> Result<Settings> {
        choices.settings(self.scene.aspect(choices.camera.as_deref())?)
    }

    /// Refuses a scene that uses what étendue ignores.
    ///
    /// # Errors
    /// Names everything ignored.
    pub fn refuse_ignored(&self) -> Result<()> {
        if self.info.ignored.is_empty() {
            return Ok(());
        }
        Err(Error::scene(format!("{}: --strict: {}", self.path.display(), self.info.ignored.join("; "))))
    }
}
