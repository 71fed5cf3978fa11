//! `etendue status` and `etendue watch`: describe a film once, or write its picture repeatedly.

use super::args::ThreadArgs;
use super::{Console, startup};
use crate::error::{Error, Result};
use crate::film::Film;
use crate::named::Named;
use crate::session::{Budget, Provenance, checkpoint, images};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Arguments of `status`.
#[derive(Debug, clap::Args)]
pub(super) struct StatusArgs {
    /// The film
    film_file: PathBuf,
    #[command(flatten)]
    threads: ThreadArgs,
    #[command(flatten)]
    console: Console,
}

/// Arguments of `watch`.
#[derive(Debug, clap::Args)]
pub(super) struct WatchArgs {
    /// The film, which may not exist yet
    film_file: PathBuf,
    /// The picture, .png [default: beside the film]
    #[arg(long, short, value_name = "PATH")]
    output: Option<PathBuf>,
    /// Interval between looks at the film
    #[arg(long, value_name = "TIME", default_value = "2s")]
    every: Budget,
    #[command(flatten)]
    threads: ThreadArgs,
    #[command(flatten)]
    console: Console,
}

/// Description of a film.
#[derive(Serialize)]
struct Document {
    film: String,
    scene: String,
    method: &'static str,
    size: [u32; 2],
    frame: Option<String>,
    passes: String,
    held: u64,
    /// `None` if a time budget or an error target decides.
    wanted: Option<u64>,
    complete: bool,
    relmse: Option<f64>,
    relmse_interval: Option<[f64; 2]>,
    /// Whether the interval is trusted.
    trusted: Option<bool>,
    wall_seconds: f64,
    sessions: u64,
    finished: String,
}

/// Describes a film.
pub(super) fn status(args: &StatusArgs) -> Result<()> {
    startup::start_threads(args.threads)?;
    let (provenance, film) = checkpoint::restore(&args.film_file)?;
    let document = Document::of(&args.film_file, &provenance, &film);
    args.console.document(&document)?;
    document.lines().iter().try_for_each(|line| args.console.line(line))
}

/// Writes the film's picture whenever the film changes, until it is complete.
pub(super) fn watch(args: &WatchArgs) -> Result<()> {
    startup::start_threads(args.threads)?;
    let path = args.output.clone().unwrap_or_else(|| args.film_file.with_extension("png"));
    if path.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("png")) {
        return Err(Error::usage(format!("{}: watch writes .png images", path.display())));
    }
    crate::session::writable(&path)?;
    let mut seen = None;
    loop {
        let changed = changed(&args.film_file);
        if changed.is_some() && changed != seen {
            let (provenance, film) = checkpoint::restore(&args.film_file)?;
            seen = changed;
            images::write_png(&path, &provenance, &film, &[])?;
            args.console.note(&format!("{} samples per pixel: {}", film.passes().len(), path.display()));
            if provenance.plan.is_met_by(film.passes()) {
                return args.console.line(&format!("image: {}", path.display()));
            }
        }
        std::thread::sleep(args.every.0.max(Duration::from_millis(10)));
    }
}

fn changed(path: &Path) -> Option<SystemTime> {
    std::fs::metadata(path).and_then(|file| file.modified()).ok()
}

impl Document {
    fn of(path: &Path, provenance: &Provenance, film: &Film) -> Self {
        let Provenance { settings, plan, work, .. } = provenance;
        let error = provenance.error_of(film);
        Document {
            film: path.display().to_string(),
            scene: provenance.scene.path.display().to_string(),
            method: settings.method.kind().name(),
            size: [settings.width, settings.height],
            frame: settings.frame.map(|frame| frame.to_string()),
            passes: film.passes().to_string(),
            held: film.passes().len(),
            wanted: plan.count(),
            complete: plan.is_met_by(film.passes()),
            relmse: error.as_ref().map(|e| e.relmse.value),
            relmse_interval: error.as_ref().map(|e| [e.relmse.low, e.relmse.high]),
            trusted: error.as_ref().map(|e| e.trust.trusted),
            wall_seconds: work.wall_seconds,
            sessions: work.sessions,
            finished: work.finished.clone(),
        }
    }

    fn lines(&self) -> Vec<String> {
        let [width, height] = self.size;
        let wanted = self.wanted.map_or_else(String::new, |wanted| {
            format!(" of {wanted}, {} %", 100 * self.held.min(wanted) / wanted.max(1))
        });
        let mut lines = vec![
            format!("film      {}", self.film),
            format!("scene     {}", self.scene),
            format!("picture   {width}x{height}, {}", self.method),
            format!("passes    {}: {}{wanted}", self.passes, self.held),
            format!("rendered  {:.1} s in {} sessions, until {}", self.wall_seconds, self.sessions, self.finished),
        ];
        lines.extend(self.frame.iter().map(|frame| format!("frame     {frame}")));
        if let (Some(relmse), Some([low, high])) = (self.relmse, self.relmse_interval) {
            lines.push(format!("relMSE    {relmse:.3e}, 95% [{low:.3e}, {high:.3e}]"));
        }
        lines
    }
}
