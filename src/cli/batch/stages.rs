//! The scenes of a batch: one that is rendered, and the next one, which is loaded on a thread of its own meanwhile.

use crate::error::{Error, Kind, Result};
use crate::render::job::Picture;
use crate::render::{Moment, Stage, Surroundings};
use crate::scene::BuildOptions;
use std::path::PathBuf;
use std::thread::JoinHandle;

/// A stage and all that it was made of: pictures with the same share one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Wanted {
    scene: PathBuf,
    surroundings: Option<Surroundings>,
    moment: Moment,
    options: BuildOptions,
}

impl Wanted {
    /// What a picture needs loaded.
    pub(super) fn of(picture: &Picture, threads: usize) -> Result<Self> {
        let named = |e: Error| e.context(picture.output.display());
        let (choices, scene) = (&picture.choices, picture.scene.clone());
        let settings = choices.settings(None).map_err(named)?;
        let (moment, options) = (settings.moment(), settings.build_options(threads));
        Ok(Wanted { scene, surroundings: choices.surroundings().map_err(named)?, moment, options })
    }
}

/// The stages of a batch.
#[derive(Default)]
pub(super) struct Stages {
    /// What is loaded, and what for.
    here: Option<(Wanted, Result<Stage>)>,
    ahead: Option<Loading>,
}

impl Stages {
    /// Has what is wanted here: kept from before, loaded ahead, or loaded now. If memory is short `make_room` is asked whether it could
    /// make some.
    pub(super) fn load(&mut self, wanted: &Wanted, make_room: impl FnOnce() -> bool) {
        if self.here.as_ref().is_some_and(|(of, _)| of == wanted) {
            return;
        }
        // Two scenes are enough at a time: the old one goes before another is begun.
        self.here = None;
        let ahead = self.ahead.take().filter(|loading| loading.wanted == *wanted);
        let was_ahead = ahead.is_some();
        let loaded = match ahead.unwrap_or_else(|| Loading::begin(wanted.clone())).end() {
            // The picture before took memory while it was rendered or written.
            Err(error) if error.kind == Kind::Memory && (make_room() || was_ahead) => Loading::begin(wanted.clone()).end(),
            loaded => loaded,
        };
        self.here = Some((wanted.clone(), loaded));
    }

    /// Begins to load `next`, unless something is being loaded.
    pub(super) fn load_ahead(&mut self, next: Option<&Wanted>) {
        if let (None, Some(next)) = (&self.ahead, next) {
            self.ahead = Some(Loading::begin(next.clone()));
        }
    }

    /// What was loaded last.
    ///
    /// # Errors
    /// Why it could not be.
    pub(super) fn here(&self) -> Result<&Stage> {
        match &self.here {
            Some((_, Ok(stage))) => Ok(stage),
            Some((_, Err(error))) => Err(Error::new(error.kind, error.chain())),
            None => Err(Error::new(Kind::Internal, "no scene was loaded")),
        }
    }

    /// Seconds that the present stage took, 0 if there is none.
    pub(super) fn seconds(&self) -> f64 {
        self.here().map_or(0.0, |stage| stage.preparation.load_seconds + stage.preparation.build_seconds)
    }
}

/// A stage being loaded on a thread of its own.
struct Loading {
    wanted: Wanted,
    thread: JoinHandle<Result<Stage>>,
}

impl Loading {
    fn begin(wanted: Wanted) -> Self {
        let Wanted { scene, surroundings, moment, options } = wanted.clone();
        Loading { wanted, thread: std::thread::spawn(move || Stage::open(&scene, surroundings, &moment, &options)) }
    }

    fn end(self) -> Result<Stage> {
        self.thread.join().unwrap_or_else(|_| Err(Error::new(Kind::Internal, "internal error while loading, told above")))
    }
}
