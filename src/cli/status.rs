//! `--status json`: the state of a render as JSON objects, one per line, for monitoring programs.

use super::console;
use crate::film::{Film, ImageError};
use crate::integrator::Guards;
use crate::named::Named;
use crate::session::{PassSelection, Progress, Provenance, machine};
use serde::Serialize;
use std::time::{Duration, Instant};

/// Minimum interval between lines.
const INTERVAL: Duration = Duration::from_secs(1);

/// Formats of the status output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum StatusFormat {
    /// JSON objects, one per line
    Json,
}

/// Events of a render.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Event {
    /// The first pass is about to begin.
    Begin,
    /// Some passes are complete.
    Progress,
    /// All passes are complete.
    Complete,
    /// A signal was received; the film is saved next.
    Stopped,
}

/// One line of status output.
#[derive(Serialize)]
struct Line<'a> {
    event: Event,
    scene: &'a str,
    camera: &'a str,
    method: &'static str,
    shard: Option<String>,
    /// Number of passes in the film.
    passes: u64,
    /// Completed share of the wanted passes, rounded down.
    percent: Option<u64>,
    /// Time of this session.
    seconds: f64,
    eta_seconds: Option<f64>,
    error: Option<Interval>,
    rays_per_second: f64,
    rss_bytes: Option<u64>,
    guards: Guards,
}

/// A relative mean squared error with its 95 % interval.
#[derive(Serialize)]
struct Interval {
    relmse: f64,
    low: f64,
    high: f64,
    trusted: bool,
}

/// Status output of one render.
pub(super) struct Status {
    scene: String,
    camera: String,
    method: &'static str,
    shard: Option<String>,
    begun: Instant,
    next: Instant,
    /// Number of rays of earlier sessions.
    earlier: u64,
}

impl Status {
    pub(super) fn new(format: StatusFormat, provenance: &Provenance) -> Self {
        let StatusFormat::Json = format;
        let settings = &provenance.settings;
        let shard = match provenance.plan.selection {
            PassSelection::All => None,
            PassSelection::Shard { index, count } => Some(format!("{index}/{count}")),
            PassSelection::Range { start, end } => Some(format!("{start}..{end}")),
        };
        Status {
            scene: crate::session::picture_name(&provenance.scene.path).to_string_lossy().into_owned(),
            camera: settings.camera.clone().unwrap_or_else(|| "0".into()),
            method: settings.method.kind().name(),
            shard,
            begun: Instant::now(),
            next: Instant::now(),
            earlier: provenance.work.passes.rays.total(),
        }
    }

    /// Whether a line is due.
    pub(super) fn is_due(&self) -> bool {
        Instant::now() >= self.next
    }

    /// Prints the progress of a render.
    pub(super) fn tell(&mut self, progress: &Progress<'_>, error: Option<&ImageError>) {
        self.next = Instant::now() + INTERVAL;
        let pace = progress.pace;
        let line = self.line(Event::Progress, progress.film, progress.provenance, error);
        print(&Line { percent: Some(pace.percent()), eta_seconds: Some(pace.remaining().as_secs_f64()), ..line });
    }

    /// Prints the start or the end of a render.
    pub(super) fn tell_of(&self, event: Event, film: &Film, provenance: &Provenance, error: Option<&ImageError>) {
        let line = self.line(event, film, provenance, error);
        print(&Line { percent: (event == Event::Complete).then_some(100), ..line });
    }

    fn line<'a>(&'a self, event: Event, film: &Film, provenance: &Provenance, error: Option<&ImageError>) -> Line<'a> {
        let seconds = self.begun.elapsed().as_secs_f64();
        let work = &provenance.work.passes;
        let rays = work.rays.total().saturating_sub(self.earlier);
        Line {
            event,
            scene: &self.scene,
            camera: &self.camera,
            method: self.method,
            shard: self.shard.clone(),
            passes: film.passes().len(),
            percent: None,
            seconds,
            eta_seconds: None,
            error: error.map(|e| Interval {
                relmse: e.relmse.value,
                low: e.relmse.low,
                high: e.relmse.high,
                trusted: e.trust.trusted,
            }),
            rays_per_second: if seconds > 0.0 { rays as f64 / seconds } else { 0.0 },
            rss_bytes: machine::resident_memory(),
            guards: work.guards,
        }
    }
}

/// Prints a line. If stdout is closed, the render continues.
fn print(line: &Line<'_>) {
    let _ = serde_json::to_string(line).map(|text| console::print(&text));
}
