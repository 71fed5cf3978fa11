//! `etendue batch`: many pictures, one process. The next scene is loaded while the present one renders, and what fails does not stop
//! the others.

use super::args::{StrictArgs, ThreadArgs};
use super::progress::ProgressArgs;
use super::signals::Signals;
use super::task::{Task, warn};
use super::{Console, console, startup};
use crate::error::{Error, Kind, Result};
use crate::render::checkpoint::INTERVAL;
use crate::render::job::{Job, Picture};
use crate::render::{Choices, Ended, Frame, Outputs, Provenance, Rendered, Report, Selection, Stage, Surroundings};
use crate::scene::BuildOptions;
use serde::Serialize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;
use std::time::Instant;

/// What the help says at its end.
pub(super) const AFTER: &str = r#"A batch file:
  output = "out/{scene}.{camera}.{method}.exr"   # also {frame:04}, {seed}; seen from the file's folder
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
    /// The batch file, .toml: which scenes, cameras and methods, and where the pictures go
    job: PathBuf,
    #[command(flatten)]
    choices: Choices,
    /// Render again what is complete
    #[arg(long)]
    again: bool,
    /// Say what would be rendered, and render nothing
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

/// What became of a picture.
#[derive(Debug, Clone, Serialize)]
struct Row {
    output: String,
    scene: String,
    /// `rendered`, `complete` (before this run), `failed`, `stopped` or `not-begun`.
    outcome: &'static str,
    /// Its exit code, had it been rendered alone.
    exit_code: u8,
    seconds: f64,
    /// Of its scene, which other pictures may share.
    load_seconds: f64,
    relmse: Option<f64>,
    pixel_hash: Option<String>,
    problem: Option<String>,
}

impl Row {
    fn line(&self) -> String {
        let error = self.relmse.map_or_else(String::new, |relmse| format!("relMSE {relmse:.3e}"));
        let what = self.problem.as_deref().unwrap_or(&error);
        format!("{:<9} {:>9.2} s  {}  {what}", self.outcome, self.seconds, self.output)
    }
}

/// What all pictures came to.
#[derive(Debug, Serialize)]
struct Summary {
    pictures: Vec<Row>,
    seconds: f64,
    exit_code: u8,
}

/// A stage and all that it was made of: pictures with the same share one.
#[derive(Debug, Clone, PartialEq)]
struct Wanted {
    scene: PathBuf,
    surroundings: Option<Surroundings>,
    frame: Option<Frame>,
    options: BuildOptions,
}

/// A stage being loaded on a thread of its own.
struct Loading {
    wanted: Wanted,
    thread: JoinHandle<Result<Stage>>,
}

/// How the pictures of a batch are rendered.
#[derive(Debug, Clone, Copy)]
pub(super) struct Means {
    /// Whether what is complete is rendered again.
    pub(super) again: bool,
    /// What is an error.
    pub(super) strict: StrictArgs,
    /// On how many threads.
    pub(super) threads: ThreadArgs,
    /// How progress is told.
    pub(super) progress: ProgressArgs,
    /// How talkative it is.
    pub(super) console: Console,
}

/// Renders what the file says.
pub(super) fn run(args: Args) -> Result<()> {
    let job = Job::read(&args.job)?;
    let pictures = job.pictures(args.job.parent().unwrap_or(Path::new("")), &args.choices)?;
    if args.dry_run {
        return pictures.iter().try_for_each(|picture| args.console.line(&picture.output.display().to_string()));
    }
    let Args { again, strict, threads, progress, console, .. } = args;
    render_all(&pictures, Means { again, strict, threads, progress, console })
}

/// Renders them all.
pub(super) fn render_all(pictures: &[Picture], means: Means) -> Result<()> {
    // Mistakes of any picture are told before the first.
    let threads = startup::start_threads(means.threads)?;
    let wanted = pictures.iter().map(|picture| wanted(picture, threads)).collect::<Result<Vec<_>>>()?;
    for picture in pictures {
        means.strict.check(&picture.choices.plan(Selection::All)?)?;
        Outputs::of(&picture.output)?;
    }
    let signals = Signals::heed()?;
    let begun = Instant::now();
    let mut batch = Batch { means, signals: &signals, stage: None, loading: None, written: Written::default() };
    for (index, picture) in pictures.iter().enumerate() {
        let next = wanted[index + 1..].iter().find(|next| **next != wanted[index]);
        means.console.note(&format!("{} of {}: {}", index + 1, pictures.len(), picture.output.display()));
        batch.picture(picture, &wanted[index], next);
    }
    batch.written.wait();
    let rows = batch.written.rows;
    let exit_code = worst(&rows).map_or(0, Kind::exit_code);
    let summary = Summary { exit_code, pictures: rows, seconds: begun.elapsed().as_secs_f64() };
    tell(&summary, means.console)
}

/// What a picture needs loaded.
fn wanted(picture: &Picture, threads: usize) -> Result<Wanted> {
    let named = |e: Error| e.context(picture.output.display());
    let (choices, scene) = (&picture.choices, picture.scene.clone());
    let settings = choices.settings(None).map_err(named)?;
    let (frame, options) = (settings.frame, settings.build_options(threads));
    Ok(Wanted { scene, surroundings: choices.surroundings().map_err(named)?, frame, options })
}

/// A batch in work.
struct Batch<'a> {
    means: Means,
    signals: &'a Signals,
    /// What is loaded, and what for.
    stage: Option<(Wanted, Result<Stage>)>,
    loading: Option<Loading>,
    written: Written,
}

/// What is written, and what is being written.
#[derive(Default)]
struct Written {
    rows: Vec<Row>,
    next: Option<JoinHandle<Row>>,
}

impl Written {
    /// Waits for the picture that is being written; whether there was one.
    fn wait(&mut self) -> bool {
        let row = self.next.take().and_then(|next| next.join().ok());
        let waited = row.is_some();
        self.rows.extend(row);
        waited
    }
}

/// What rendering a picture comes to.
enum Made {
    /// It was stopped before.
    Nothing,
    /// It was there.
    Complete,
    /// It is to be written.
    Rendered(Task, Box<Rendered>, Ended),
}

impl Batch<'_> {
    /// Renders a picture, whatever may happen, while the one before it is written and `next` is loaded.
    fn picture(&mut self, picture: &Picture, wanted: &Wanted, next: Option<&Wanted>) {
        let mut entry = Entry { picture: picture.clone(), begun: Instant::now(), load_seconds: 0.0, console: self.means.console };
        let stopped = self.signals.cancel.requested();
        let made = if stopped { Ok(Made::Nothing) } else { surviving(|| self.render(picture, wanted, next)) };
        let preparation = self.stage.as_ref().and_then(|(_, stage)| stage.as_ref().ok()).map(|stage| stage.preparation);
        entry.load_seconds = preparation.map_or(0.0, |p| p.load_seconds + p.build_seconds);
        self.written.wait();
        let row = match made {
            Ok(Made::Rendered(task, rendered, ended)) => {
                self.written.next = Some(std::thread::spawn(move || match surviving(|| task.finish(&rendered, ended)) {
                    Ok(report) => entry.row(Outcome::Rendered(&report)),
                    Err(error) => entry.row(Outcome::Failed(&error)),
                }));
                return;
            }
            Ok(Made::Complete) => entry.row(Outcome::Complete),
            Ok(Made::Nothing) => entry.row(Outcome::NotBegun),
            Err(error) => entry.row(Outcome::Failed(&error)),
        };
        self.written.rows.push(row);
    }

    fn render(&mut self, picture: &Picture, wanted: &Wanted, next: Option<&Wanted>) -> Result<Made> {
        self.load(wanted)?;
        self.load_ahead(next);
        let task = self.task(picture)?;
        let Some((_, Ok(stage))) = &self.stage else {
            return Err(Error::new(Kind::Internal, "the scene is gone"));
        };
        let (choices, strict) = (&picture.choices, self.means.strict);
        let settings = stage.settings(choices)?;
        if strict.strict {
            stage.refuse_ignored()?;
        }
        let provenance = Provenance::new(stage, settings, choices.plan(Selection::All)?, choices.look()?);
        warn(task.console, &provenance);
        let begun = match task.begin(stage, provenance.clone()) {
            // The picture before takes memory until it is written.
            Err(error) if error.kind == Kind::Memory && self.written.wait() => task.begin(stage, provenance),
            begun => begun,
        };
        let Some(mut session) = begun? else { return Ok(Made::Complete) };
        let ended = task.render(&mut session, self.signals)?;
        Ok(Made::Rendered(task, Box::new(session.end()?), ended))
    }

    fn task(&self, picture: &Picture) -> Result<Task> {
        let outputs = Outputs::of(&picture.output)?;
        for path in outputs.paths().chain(picture.report.as_deref()) {
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
            folder.map_or(Ok(()), std::fs::create_dir_all).map_err(|cause| Error::write(path, cause))?;
            crate::render::writable(path)?;
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

    /// Has what is wanted in `stage`: kept from before, loaded ahead, or loaded now.
    fn load(&mut self, wanted: &Wanted) -> Result<()> {
        if self.stage.as_ref().is_none_or(|(of, _)| of != wanted) {
            // Two scenes are enough at a time: the old one goes before another is begun.
            self.stage = None;
            let ahead = self.loading.take().filter(|loading| loading.wanted == *wanted);
            let was_ahead = ahead.is_some();
            let loaded = match ahead.unwrap_or_else(|| Loading::begin(wanted.clone())).end() {
                // The picture before took memory while it was rendered or written.
                Err(error) if error.kind == Kind::Memory && (self.written.wait() || was_ahead) => {
                    Loading::begin(wanted.clone()).end()
                }
                loaded => loaded,
            };
            self.stage = Some((wanted.clone(), loaded));
        }
        match &self.stage {
            Some((_, Err(error))) => Err(Error::new(error.kind, error.chain())),
            _ => Ok(()),
        }
    }

    fn load_ahead(&mut self, next: Option<&Wanted>) {
        if let (None, Some(next)) = (&self.loading, next) {
            self.loading = Some(Loading::begin(next.clone()));
        }
    }
}

impl Loading {
    fn begin(wanted: Wanted) -> Self {
        let Wanted { scene, surroundings, frame, options } = wanted.clone();
        Loading { wanted, thread: std::thread::spawn(move || Stage::open(&scene, surroundings, frame, &options)) }
    }

    fn end(self) -> Result<Stage> {
        self.thread.join().unwrap_or_else(|_| Err(Error::new(Kind::Internal, "internal error while loading, told above")))
    }
}

/// A panic as an error.
fn surviving<T>(work: impl FnOnce() -> Result<T>) -> Result<T> {
    let done = catch_unwind(AssertUnwindSafe(work));
    done.unwrap_or_else(|_| Err(Error::new(Kind::Internal, "internal error, told above")))
}

/// A picture whose row is not known yet.
struct Entry {
    picture: Picture,
    begun: Instant,
    load_seconds: f64,
    console: Console,
}

/// What became of a picture.
enum Outcome<'a> {
    Rendered(&'a Report),
    Complete,
    NotBegun,
    Failed(&'a Error),
}

impl Outcome<'_> {
    fn word(&self) -> &'static str {
        match self {
            Outcome::Rendered(_) => "rendered",
            Outcome::Complete => "complete",
            Outcome::NotBegun => "not-begun",
            Outcome::Failed(error) if error.kind == Kind::Interrupted => "stopped",
            Outcome::Failed(_) => "failed",
        }
    }
}

impl Entry {
    /// The row, which is told at once.
    fn row(self, outcome: Outcome<'_>) -> Row {
        let (output, seconds) = (self.picture.output.display().to_string(), self.begun.elapsed().as_secs_f64());
        let report = if let Outcome::Rendered(report) = outcome { Some(report) } else { None };
        let error = match outcome {
            Outcome::Failed(error) => Some((error.kind, error.chain())),
            Outcome::NotBegun => Some((Kind::Interrupted, "stopped by a signal".into())),
            Outcome::Rendered(_) | Outcome::Complete => None,
        };
        if let (Outcome::Failed(_), Some((_, why))) = (&outcome, &error) {
            console::error(&format!("{output}: {why}"));
        }
        let row = Row {
            output,
            scene: self.picture.scene.display().to_string(),
            outcome: outcome.word(),
            exit_code: error.as_ref().map_or(0, |(kind, _)| kind.exit_code()),
            seconds,
            load_seconds: self.load_seconds,
            relmse: report.and_then(|r| r.error()).map(|e| e.relmse.value),
            pixel_hash: report.map(|r| r.pixel_hash().to_owned()),
            problem: error.map(|(_, why)| why),
        };
        // Whoever reads it may be gone; the others are rendered all the same, and the summary says so.
        let _ = self.console.line(&row.line());
        row
    }
}

/// What a picture may fail of, the worst first: a stop above all, since another run goes on; then what another run does not mend.
const KINDS: [Kind; 8] = [
    Kind::Interrupted,
    Kind::Internal,
    Kind::Usage,
    Kind::Scene,
    Kind::Memory,
    Kind::Output,
    Kind::NonFinite,
    Kind::TargetMissed,
];

/// The worst that any picture failed of.
fn worst(rows: &[Row]) -> Option<Kind> {
    KINDS.into_iter().find(|kind| rows.iter().any(|row| row.exit_code == kind.exit_code()))
}

/// How it all ended.
fn tell(summary: &Summary, console: Console) -> Result<()> {
    console.document(summary)?;
    let count = |outcome: &str| summary.pictures.iter().filter(|row| row.outcome == outcome).count();
    let all = summary.pictures.len();
    let [rendered, complete] = ["rendered", "complete"].map(count);
    let bad = all - rendered - complete;
    console.line(&format!("{rendered} rendered, {complete} complete before, {bad} not, in {:.2} s", summary.seconds))?;
    worst(&summary.pictures)
        .map_or(Ok(()), |kind| Err(Error::new(kind, format!("{bad} of {all} pictures were not rendered as wanted"))))
}
