//! One picture from a loaded scene to its files: what `render` does once and `batch` many times.

use super::args::StrictArgs;
use super::progress::ProgressArgs;
use super::signals::Signals;
use super::{Console, finish, progress};
use crate::error::Result;
use crate::render::checkpoint::{self, INTERVAL};
use crate::render::{Checkpoint, Ended, Found, Outputs, Provenance, Rendered, Report, Session, Stage};
use std::path::PathBuf;
use std::time::Duration;

/// Where the results of a picture go, and how it is made.
pub(super) struct Task {
    /// Images and film.
    pub(super) outputs: Outputs,
    /// The report.
    pub(super) report: Option<PathBuf>,
    /// How often the film is saved on the way, whether or not it is an output.
    pub(super) checkpoint: Option<Duration>,
    /// Whether what an earlier run left is taken.
    pub(super) skip_complete: bool,
    /// What is an error.
    pub(super) strict: StrictArgs,
    /// How progress is told.
    pub(super) progress: ProgressArgs,
    /// How talkative it is.
    pub(super) console: Console,
}

impl Task {
    /// The session of `provenance`, with what an earlier run left of it; `None` if that is all.
    pub(super) fn begin<'a>(&self, stage: &'a Stage, provenance: Provenance) -> Result<Option<Session<'a>>> {
        let found = if self.skip_complete { Found::at(&self.outputs, &provenance) } else { Found::Nothing };
        match found {
            Found::Nothing => Session::begin(stage, provenance).map(Some),
            Found::Part(earlier, film) => {
                self.console.note(&format!("going on after {} samples per pixel of an earlier run", film.passes().len()));
                let provenance = Provenance { plan: provenance.plan, look: provenance.look, ..*earlier };
                Session::resume(stage, provenance, film).map(Some)
            }
            Found::All => {
                let path = self.outputs.image().or(self.outputs.film.as_deref());
                let path = path.map(|path| path.display().to_string()).unwrap_or_default();
                self.console.line(&format!("complete already: {path}"))?;
                Ok(None)
            }
        }
    }

    /// Renders the passes that are wanted yet.
    pub(super) fn render(&self, session: &mut Session<'_>, signals: &Signals) -> Result<Ended> {
        signals.hold();
        let path = if self.checkpoint.is_some() { self.outputs.checkpoint() } else { self.outputs.film.clone() };
        let checkpoint = path.map(|path| Checkpoint::new(&path, self.checkpoint.unwrap_or(INTERVAL)));
        progress::run(session, self.console, self.progress, &signals.cancel, checkpoint)
    }

    /// Writes the files, and removes a film that was only for a kill.
    pub(super) fn finish(&self, rendered: &Rendered, ended: Ended) -> Result<Report> {
        let files = finish::Files { outputs: &self.outputs, report: self.report.as_deref() };
        let report = finish::session(rendered, ended, files, self.strict, self.console)?;
        if self.outputs.film.is_none() && (self.checkpoint.is_some() || self.skip_complete) {
            self.forget(&rendered.provenance);
        }
        Ok(report)
    }

    /// Removes the film beside the image if it is one of this picture.
    fn forget(&self, provenance: &Provenance) {
        let Some(path) = self.outputs.checkpoint() else { return };
        let is_ours = checkpoint::open(&path).is_ok_and(|(other, _)| provenance.same_picture(&other).is_ok());
        if is_ours && std::fs::remove_file(&path).is_err() {
            self.console.warn(&format!("cannot remove {}, which the image does not need", path.display()));
        }
    }
}

/// Says what the user would not expect in the picture.
pub(super) fn warn(console: Console, provenance: &Provenance) {
    let scene = &provenance.scene;
    scene.warnings.iter().for_each(|text| console.warn(text));
    scene.ignored.iter().for_each(|text| console.warn(&format!("ignored: {text}")));
    scene.blind_spots.iter().for_each(|text| console.warn(text));
    if let Some(limit) = provenance.settings.clamp {
        console.warn(&format!("--clamp {limit}: the image is biased, and says so"));
    }
}
