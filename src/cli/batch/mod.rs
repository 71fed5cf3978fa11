//! `etendue batch`: many pictures in one process. The next scene is loaded while the present one renders. A failure
//! does not stop the remaining pictures.

mod rows;

use super::args::{StrictArgs, ThreadArgs};
use super::progress::ProgressArgs;
use super::settings_args::SettingsArgs;
use super::signals::Signals;
use super::task::{Task, warnings};
use super::{Console, startup};
use crate::batch::{Job, JobPicture, SceneCache, SceneKey};
use crate::error::{Error, Kind, Result};
use crate::session::checkpoint::INTERVAL;
use crate::session::{Ended, Outputs, PassSelection, RenderJob, Rendered};
use rows::{Entry, Outcome, WriterQueue};
use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Text at the end of the help.
pub(super) const AFTER: &str = r#"A batch file:
  output = "out/{scene}.{camera}.{method}.exr"   # also {frame:04}, {seed}; relative to the file's folder
  report = "out/{scene}.{camera}.{method}.json"  # if reports are wanted

  [settings]                                     # as in render.toml, for all
  spp = 64

  [[render]]                                     # each scene by each camera and each method
  scenes = ["cup.glb", "bowl.glb"]
  cameras = ["front", "side"]
  methods = ["path", "bdpt"]
  settings.size = "640x480"

  [[render]]
  scenes = ["walk.glb"]
  frames = "1-240x2"                             # or "7", "1,3,7-9": frames of the scene's animation
  settings.fps = 24.0
  output = "out/walk.{frame:04}.exr"

What is complete is not rendered again, and what was stopped goes on. The exit code is the worst of all pictures'."#;

/// Arguments of `batch`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The batch file, .toml, with the scenes, cameras, methods and output paths
    job: PathBuf,
    #[command(flatten)]
    choices: SettingsArgs,
    /// Render complete pictures again
    #[arg(long)]
    again: bool,
    /// List the pictures to render, and render nothing
    #[arg(long)]
    dry_run: bool,
    #[command(flatten)]
    strict: StrictArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    #[command(flatten)]
    progress: ProgressArgs,
    #[command(flatten)]
    console: Console,
}

/// Options for rendering the pictures of a batch.
#[derive(Debug, Clone, Copy)]
pub(super) struct BatchOptions {
    /// Whether to render complete pictures again.
    pub(super) again: bool,
    /// Warnings treated as errors.
    pub(super) strict: StrictArgs,
    /// Thread count and memory limit.
    pub(super) threads: ThreadArgs,
    /// Progress display.
    pub(super) progress: ProgressArgs,
    /// Console output.
    pub(super) console: Console,
}

/// Renders the pictures of a batch file.
pub(super) fn run(args: Args) -> Result<()> {
    let job = Job::read(&args.job)?;
    let pictures = job.pictures(args.job.parent().unwrap_or(Path::new("")), &args.choices.0)?;
    if args.dry_run {
        return pictures.iter().try_for_each(|picture| args.console.line(&picture.output.display().to_string()));
    }
    let Args { again, strict, threads, progress, console, .. } = args;
    render_all(&pictures, BatchOptions { again, strict, threads, progress, console })
}

/// Renders all pictures.
pub(super) fn render_all(pictures: &[JobPicture], means: BatchOptions) -> Result<()> {
    // Errors in the settings of any picture are reported before the first one is rendered.
    let threads = startup::start_threads(means.threads)?;
    let resolve = |picture: &JobPicture| {
        picture.choices.resolve(PassSelection::All).map_err(|e| e.context(picture.output.display()))
    };
    let jobs = pictures.iter().map(resolve).collect::<Result<Vec<_>>>()?;
    for (picture, job) in pictures.iter().zip(&jobs) {
        means.strict.check(&job.plan)?;
        Outputs::of(&picture.output)?;
    }
    let wanted: Vec<_> =
        pictures.iter().zip(&jobs).map(|(picture, job)| SceneKey::of(&picture.scene, job, threads)).collect();
    let signals = Signals::heed()?;
    let begun = Instant::now();
    let (stages, written, told) = (SceneCache::default(), WriterQueue::default(), HashSet::new());
    let mut batch = Batch { means, signals: &signals, stages, written, told };
    for (index, (picture, job)) in pictures.iter().zip(jobs).enumerate() {
        let next = wanted[index + 1..].iter().find(|next| **next != wanted[index]);
        means.console.note(&format!("{} of {}: {}", index + 1, pictures.len(), picture.output.display()));
        batch.picture(picture, job, &wanted[index], next);
    }
    batch.written.tell(begun, means.console)
}

/// A batch in progress.
struct Batch<'a> {
    means: BatchOptions,
    signals: &'a Signals,
    stages: SceneCache,
    written: WriterQueue,
    /// Scenes and the warnings that were printed for them, which are not repeated.
    told: HashSet<(PathBuf, String)>,
}

/// Result of rendering a picture.
enum PictureResult {
    /// A stop was requested before it began.
    Nothing,
    /// It was already complete.
    Complete,
    /// It was rendered and is ready to be written.
    Rendered(Task, Box<Rendered>, Ended),
}

impl Batch<'_> {
    /// Renders a picture, catching errors and panics. Meanwhile the previous one is written and `next` is loaded.
    fn picture(&mut self, picture: &JobPicture, job: RenderJob, wanted: &SceneKey, next: Option<&SceneKey>) {
        let entry = Entry::begin(picture, self.means.console);
        let stopped = self.signals.cancel.requested();
        let made =
            if stopped { Ok(PictureResult::Nothing) } else { surviving(|| self.render(picture, job, wanted, next)) };
        let load = self.stages.seconds();
        self.written.wait();
        let row = match made {
            Ok(PictureResult::Complete) => entry.row(&Outcome::Complete, load),
            Ok(PictureResult::Nothing) => entry.row(&Outcome::NotBegun, load),
            Err(error) => entry.row(&Outcome::Failed(&error), load),
            Ok(PictureResult::Rendered(task, rendered, ended)) => {
                self.written.expect(std::thread::spawn(move || match surviving(|| task.finish(&rendered, ended)) {
                    Ok(report) => entry.row(&Outcome::Rendered(&report), load),
                    Err(error) => entry.row(&Outcome::Failed(&error), load),
                }));
                return;
            }
        };
        self.written.push(row);
    }

    fn render(
        &mut self,
        picture: &JobPicture,
        job: RenderJob,
        wanted: &SceneKey,
        next: Option<&SceneKey>,
    ) -> Result<PictureResult> {
        self.stages.load(wanted, || self.written.wait());
        self.stages.load_ahead(next);
        let (stage, task) = (self.stages.here()?, self.task(picture)?);
        let job = job.fitted(stage)?;
        if self.means.strict.strict {
            stage.refuse_ignored()?;
        }
        let provenance = job.provenance(stage);
        let is_new = |text: &String| self.told.insert((picture.scene.clone(), text.clone()));
        warnings(&provenance).into_iter().filter(is_new).for_each(|text| self.means.console.warn(&text));
        let begun = match task.begin(stage, provenance.clone()) {
            // The previous picture occupies memory until it is written.
            Err(error) if error.kind == Kind::Memory && self.written.wait() => task.begin(stage, provenance),
            begun => begun,
        };
        let Some(mut session) = begun? else { return Ok(PictureResult::Complete) };
        let ended = task.render(&mut session, self.signals)?;
        Ok(PictureResult::Rendered(task, Box::new(session.end()?), ended))
    }

    fn task(&self, picture: &JobPicture) -> Result<Task> {
        let outputs = Outputs::of(&picture.output)?;
        for path in outputs.paths().chain(picture.report.as_deref()) {
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
            folder.map_or(Ok(()), std::fs::create_dir_all).map_err(|cause| Error::write(path, cause))?;
            crate::session::writable(path)?;
        }
        let console = Console { silent: true, ..self.means.console };
        Ok(Task {
            outputs,
            report: picture.report.clone(),
            checkpoint: Some(INTERVAL),
            skip_complete: !self.means.again,
            strict: self.means.strict,
            progress: self.means.progress,
            console,
        })
    }
}

/// Converts a panic to an error.
fn surviving<T>(work: impl FnOnce() -> Result<T>) -> Result<T> {
    let done = catch_unwind(AssertUnwindSafe(work));
    done.unwrap_or_else(|_| Err(Error::new(Kind::Internal, "internal error, reported above")))
}
