//! What became of the pictures of a batch: a row each, told as soon as it is known, and a summary.

use crate::cli::{Console, console};
use crate::error::{Error, Kind, Result};
use crate::render::Report;
use crate::render::job::Picture;
use serde::Serialize;
use std::thread::JoinHandle;
use std::time::Instant;

/// What became of a picture.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Row {
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

/// A picture whose row is not known yet.
pub(super) struct Entry {
    picture: Picture,
    begun: Instant,
    console: Console,
}

/// What became of a picture.
pub(super) enum Outcome<'a> {
    /// It was rendered and written.
    Rendered(&'a Report),
    /// It was there.
    Complete,
    /// The batch was stopped before.
    NotBegun,
    /// It was stopped, or failed.
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
    /// That of a picture which begins now.
    pub(super) fn begin(picture: &Picture, console: Console) -> Self {
        Entry { picture: picture.clone(), begun: Instant::now(), console }
    }

    /// The row, which is told at once; the scene took `load_seconds`.
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
        // Whoever reads it may be gone; the others are rendered all the same, and the summary says so.
        let _ = self.console.line(&row.line());
        row
    }
}

/// What is written, and what is being written.
#[derive(Default)]
pub(super) struct Written {
    rows: Vec<Row>,
    next: Option<JoinHandle<Row>>,
}

impl Written {
    /// Another row.
    pub(super) fn push(&mut self, row: Row) {
        self.rows.push(row);
    }

    /// Another row to come, from a thread that writes the picture; wait for the last one before.
    pub(super) fn expect(&mut self, next: JoinHandle<Row>) {
        self.next = Some(next);
    }

    /// Waits for the picture that is being written; whether there was one.
    pub(super) fn wait(&mut self) -> bool {
        let row = self.next.take().and_then(|next| next.join().ok());
        let waited = row.is_some();
        self.rows.extend(row);
        waited
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

/// What all pictures came to.
#[derive(Debug, Serialize)]
struct Summary {
    pictures: Vec<Row>,
    seconds: f64,
    exit_code: u8,
}

impl Written {
    /// Says how it all ended, which began at `begun`.
    ///
    /// # Errors
    /// The worst that any picture failed of.
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
