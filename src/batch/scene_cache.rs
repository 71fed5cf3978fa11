//! Scene cache of a batch: the current scene, and the next one, which is loaded meanwhile on its own thread.

use crate::error::{Error, Kind, Result};
use crate::scene::BuildOptions;
use crate::session::{LoadedScene, Moment, Overrides, RenderJob};
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;

/// All inputs of a loaded scene. Pictures with the same inputs share it.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneKey {
    scene: PathBuf,
    overrides: Overrides,
    moment: Moment,
    options: BuildOptions,
}

impl SceneKey {
    /// Returns the inputs of the scene in the file `scene` for `job`.
    pub fn of(scene: &Path, job: &RenderJob, threads: usize) -> Self {
        SceneKey {
            scene: scene.to_owned(),
            overrides: job.overrides.clone(),
            moment: job.settings.moment(),
            options: job.settings.build_options(threads),
        }
    }
}

/// The current scene, and the one being loaded.
#[derive(Default)]
pub struct SceneCache {
    /// The current scene with its inputs.
    here: Option<(SceneKey, Result<LoadedScene>)>,
    ahead: Option<Loading>,
}

impl SceneCache {
    /// Makes the wanted scene current: it is kept, taken from the background load, or loaded now. If memory is short,
    /// `make_room` may free some and returns whether it did.
    pub fn load(&mut self, wanted: &SceneKey, make_room: impl FnOnce() -> bool) {
        if self.here.as_ref().is_some_and(|(of, _)| of == wanted) {
            return;
        }
        // At most two scenes are in memory: the old one is dropped before another load begins.
        self.here = None;
        let ahead = self.ahead.take().filter(|loading| loading.wanted == *wanted);
        let was_ahead = ahead.is_some();
        let loaded = match ahead.unwrap_or_else(|| Loading::begin(wanted.clone())).end() {
            // Rendering or writing the previous picture took memory.
            Err(error) if error.kind == Kind::Memory && (make_room() || was_ahead) => {
                Loading::begin(wanted.clone()).end()
            }
            loaded => loaded,
        };
        self.here = Some((wanted.clone(), loaded));
    }

    /// Starts to load `next` in the background, unless a load is in progress.
    pub fn load_ahead(&mut self, next: Option<&SceneKey>) {
        if let (None, Some(next)) = (&self.ahead, next) {
            self.ahead = Some(Loading::begin(next.clone()));
        }
    }

    /// Returns the current scene.
    ///
    /// # Errors
    /// The reason why it could not be loaded.
    pub fn here(&self) -> Result<&LoadedScene> {
        match &self.here {
            Some((_, Ok(stage))) => Ok(stage),
            Some((_, Err(error))) => Err(Error::new(error.kind, error.chain())),
            None => Err(Error::new(Kind::Internal, "no scene was loaded")),
        }
    }

    /// Seconds spent on loading and building the current scene; 0 if there is none.
    pub fn seconds(&self) -> f64 {
        self.here().map_or(0.0, |stage| stage.preparation.load_seconds + stage.preparation.build_seconds)
    }
}

/// A scene being loaded on its own thread.
struct Loading {
    wanted: SceneKey,
    thread: JoinHandle<Result<LoadedScene>>,
}

impl Loading {
    fn begin(wanted: SceneKey) -> Self {
        let SceneKey { scene, overrides, moment, options } = wanted.clone();
        Loading { wanted, thread: std::thread::spawn(move || LoadedScene::open(&scene, overrides, &moment, &options)) }
    }

    fn end(self) -> Result<LoadedScene> {
        self.thread
            .join()
            .unwrap_or_else(|_| Err(Error::new(Kind::Internal, "internal error while loading, reported above")))
    }
}
