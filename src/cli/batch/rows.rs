//! Results of the pictures of a batch: one row each, printed as soon as it is known, and a summary.

use crate::batch::JobPicture;
use crate::cli::{Console, console};
use crate::error::{Error, Kind, Result};
use crate::session::RenderReport;
use serde::Serialize;
use std::thread::JoinHandle;
use std::time::Instant;

/// Result of a picture.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Row {
    output: String,
    scene: String,
    /// `rendered`, `complete` (before this run), `failed`, `stopped` or `not-begun`.
    outcome: &'static str,
    /// The exit code of rendering this picture alone.
    exit_code: u8,
    seconds: f64,
    /// Loading time of its scene, which other pictures may share.
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

/// A picture in progress, without a row yet.
pub(super) struct Entry {
    picture: JobPicture,
    begun: Instant,
    console: Console,
}

/// Outcome of a picture.
pub(super) enum Outcome<'a> {
    /// It was rendered and written.
    Rendered(&'a RenderReport),
    /// It was already complete.
    Complete,
    /// The batch was stopped before it began.
    NotBegun,
    /// It was stopped, or it failed.
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
    /// Begins the entry of a picture.
    pub(super) fn begin(picture: &JobPicture, console: Console) -> Self {
        Entry { picture: picture.clone(), begun: Instant::now(), console }
    }

    /// Creates the row and prints it at once. The scene took `load_seconds` to load.
    pub(super) fn row(self, outcome: &Outcome<'_>, load_seconds: f64) -> Row {
        let (output, seconds) = (self.picture.output.display().to_string(), self.begun.elapsed().as_secs_f64());
        let report = if let Outcome::Rendered(report) = outcome { Some(*report) } else { None };
        let error = match outcome {
            Outcome::Failed(error) => Some((error.kind, error.chain())),
            Outcome::NotBegun => Some((Kind::Interrupted, "stopped by a signal".into())),
            Outcome::Rendered(_) | Outcome::Complete => None,
        };
        if let (Outcome::Failed(_), Some((_, why))) = (outcome, &error) {
            console::error(&format!("{output}: {why}"));
        }
        let row = Row {
            output,
            scene: self.picture.scene.display().to_string(),
            outcome: outcome.word(),
            exit_code: error.as_ref().map_or(0, |(kind, _)| kind.exit_code()),
            seconds,
            load_seconds,
            relmse: report.and_then(|r| r.error()).map(|e| e.relmse.value),
            pixel_hash: report.map(|r| r.pixel_hash().to_owned()),
            problem: error.map(|(_, why)| why),
        };
        // If stdout is closed, the other pictures are rendered nevertheless. The summary reports the error.
        let _ = self.console.line(&row.line());
        row
    }
}

/// Rows of finished pictures, and the picture being written.
#[derive(Default)]
pub(super) struct WriterQueue {
    rows: Vec<Row>,
    next: Option<JoinHandle<Row>>,
}

impl WriterQueue {
    /// Adds a row.
    pub(super) fn push(&mut self, row: Row) {
        self.rows.push(row);
    }

    /// Adds the row of a picture that another thread is writing. The previous one must have been waited for.
    pub(super) fn expect(&mut self, next: JoinHandle<Row>) {
        self.next = Some(next);
    }

    /// Waits for the picture being written. Returns whether there was one.
    pub(super) fn wait(&mut self) -> bool {
        let row = self.next.take().and_then(|next| next.join().ok());
        let waited = row.is_some();
        self.rows.extend(row);
        waited
    }
}

/// Kinds of failure by severity. A stop comes first, since another run continues; then the failures that another run
/// does not cure.
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

/// Returns the most severe failure of any picture.
fn worst(rows: &[Row]) -> Option<Kind> {
    KINDS.into_iter().find(|kind| rows.iter().any(|row| row.exit_code == kind.exit_code()))
}

/// Results of all pictures.
#[derive(Debug, Serialize)]
struct Summary {
    pictures: Vec<Row>,
    seconds: f64,
    exit_code: u8,
}

impl WriterQueue {
    /// Prints the summary of the batch that began at `begun`.
    ///
    /// # Errors
    /// The most severe failure of any picture.
    pub(super) fn tell(mut self, begun: Instant, console: Console) -> Result<()> {
        self.wait();
        let worst = worst(&self.rows);
        let count = |outcome: &str| self.rows.iter().filter(|row| row.outcome == outcome).count();
        let ([rendered, complete], all) = (["rendered", "complete"].map(count), self.rows.len());
        let (bad, seconds) = (all - rendered - complete, begun.elapsed().as_secs_f64());
        console.document(&Summary { pictures: self.rows, seconds, exit_code: worst.map_or(0, Kind::exit_code) })?;
        console.line(&format!("{rendered} rendered, {complete} complete before, {bad} not, in {seconds:.2} s"))?;
        let failed = |kind| Error::new(kind, format!("{bad} of {all} pictures were not rendered as wanted"));
        worst.map_or(Ok(()), |kind| Err(failed(kind)))
    }
}
