//! Renders one picture, from a loaded scene to its files. `render` does this once, `batch` many times.

use super::args::{KeepArgs, OutputArgs, StrictArgs};
use super::progress::ProgressArgs;
use super::signals::Signals;
use super::{Console, finish, progress};
use crate::error::Result;
use crate::session::checkpoint::{self, INTERVAL};
use crate::session::{
    Checkpoint, Ended, ExistingOutput, LoadedScene, Outputs, PassPlan, PassSelection, Provenance, RenderReport,
    Rendered, Session,
};
use std::collections::HashSet;
use std::path::PathBuf;
use std::time::Duration;

/// Outputs of a picture and options for rendering it.
pub(super) struct Task {
    /// Images and film.
    pub(super) outputs: Outputs,
    /// The report.
    pub(super) report: Option<PathBuf>,
    /// Interval between saves of the film, whether or not it is an output.
    pub(super) checkpoint: Option<Duration>,
    /// Whether to reuse the output of an earlier run.
    pub(super) skip_complete: bool,
    /// Warnings treated as errors.
    pub(super) strict: StrictArgs,
    /// Progress display.
    pub(super) progress: ProgressArgs,
    /// Console output.
    pub(super) console: Console,
}

impl OutputArgs {
    /// Combines the outputs with the other arguments to a task.
    pub(super) fn task(
        &self,
        outputs: Outputs,
        keep: KeepArgs,
        strict: StrictArgs,
        progress: ProgressArgs,
        console: Console,
    ) -> Task {
        let (report, checkpoint) = (self.report.clone(), keep.checkpoint.map(|every| every.0));
        Task { outputs, report, checkpoint, skip_complete: keep.skip_complete, strict, progress, console }
    }
}

impl Task {
    /// Begins the session of `provenance`, continuing the film of an earlier run; `None` if the output is complete.
    pub(super) fn begin<'a>(&self, stage: &'a LoadedScene, provenance: Provenance) -> Result<Option<Session<'a>>> {
        let found =
            if self.skip_complete { ExistingOutput::at(&self.outputs, &provenance) } else { ExistingOutput::Nothing };
        match found {
            ExistingOutput::Nothing => Session::begin(stage, provenance).map(Some),
            ExistingOutput::Part(earlier, film) => {
                self.console
                    .note(&format!("continuing an earlier run after {} samples per pixel", film.passes().len()));
                let provenance = Provenance { plan: provenance.plan, look: provenance.look, ..*earlier };
                Session::resume(stage, provenance, film).map(Some)
            }
            ExistingOutput::All => {
                let path = self.outputs.image().or(self.outputs.film.as_deref());
                let path = path.map(|path| path.display().to_string()).unwrap_or_default();
                self.console.line(&format!("complete already: {path}"))?;
                Ok(None)
            }
        }
    }

    /// Renders the missing passes.
    pub(super) fn render(&self, session: &mut Session<'_>, signals: &Signals) -> Result<Ended> {
        signals.hold();
        let path = if self.checkpoint.is_some() { self.outputs.checkpoint() } else { self.outputs.film.clone() };
        let checkpoint = path.map(|path| Checkpoint::new(&path, self.checkpoint.unwrap_or(INTERVAL)));
        progress::run(session, self.console, self.progress, &signals.cancel, checkpoint)
    }

    /// Writes the outputs. Removes a film that served only as a checkpoint.
    pub(super) fn finish(&self, rendered: &Rendered, ended: Ended) -> Result<RenderReport> {
        let files = finish::Files { outputs: &self.outputs, report: self.report.as_deref() };
        let report = finish::session(rendered, ended, files, self.strict, self.console)?;
        if self.outputs.film.is_none() && (self.checkpoint.is_some() || self.skip_complete) {
            self.forget(&rendered.provenance);
        }
        Ok(report)
    }

    /// Removes the film beside the image if it belongs to this picture.
    fn forget(&self, provenance: &Provenance) {
        let Some(path) = self.outputs.checkpoint() else { return };
        let is_ours = checkpoint::open(&path).is_ok_and(|(other, _)| provenance.same_picture(&other).is_ok());
        if is_ours && std::fs::remove_file(&path).is_err() {
            self.console.warn(&format!("cannot remove {}, which the image does not need", path.display()));
        }
    }
}

/// Returns warnings about everything unexpected in the picture, each once.
pub(super) fn warnings(provenance: &Provenance) -> Vec<String> {
    let scene = &provenance.scene;
    let ignored = scene.ignored.iter().map(|text| format!("ignored: {text}"));
    let clamping = provenance.settings.clamping();
    let clamped = clamping.map(|(setting, limit)| format!("--{setting} {limit}: the image is biased, and says so"));
    let approximate = provenance.settings.approximation();
    let approximate = approximate.map(|text| format!("approximate: {text}, and the image says so"));
    let mut told = HashSet::new();
    let all = scene
        .warnings
        .iter()
        .cloned()
        .chain(ignored)
        .chain(scene.blind_spots.iter().cloned())
        .chain(clamped)
        .chain(approximate);
    all.filter(|text| told.insert(text.clone())).collect()
}

/// Notes that the number of samples per pixel was rounded up from the `asked` one.
pub(super) fn note_rounding(console: Console, asked: Option<u32>, plan: PassPlan, replicates: u32) {
    let (Some(asked), Some(spp)) = (asked, plan.stop.spp) else { return };
    if u64::from(asked) != spp && !matches!(plan.selection, PassSelection::Range { .. }) {
        console
            .note(&format!("{asked} samples per pixel rounded up to {spp}: {replicates} replicates × a power of two"));
    }
}
