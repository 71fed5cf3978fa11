//! Running a session with signals heard and progress shown: a bar on a terminal, a line now and then elsewhere.

use super::{Console, console};
use crate::error::{Error, Kind, Result};
use crate::integrator::Method;
use crate::parallel::Cancel;
use crate::render::{Checkpoint, Ended, Observer, Progress, Session};
use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::path::Path;
use std::time::{Duration, Instant};

/// Runs the session; `film` is where it is saved on the way, if anywhere.
pub(super) fn run(session: &mut Session<'_>, console: Console, film: Option<&Path>) -> Result<Ended> {
    let cancel = Cancel::new();
    heed_signals(&cancel)?;
    let (settings, plan) = (&session.provenance().settings, session.provenance().plan);
    let amount = plan.count().map_or_else(String::new, |passes| format!(", {passes} samples per pixel"));
    console.note(&format!("rendering {}x{}{amount}", settings.width, settings.height));
    let mut watcher = Watcher { meter: Meter::new(console), error: ErrorSoFar::of(settings.method) };
    session.run(&cancel, &mut watcher, film.map(Checkpoint::new))
}

/// The first SIGINT or SIGTERM asks for a stop, the second kills.
pub(super) fn heed_signals(cancel: &Cancel) -> Result<()> {
    use signal_hook::consts::{SIGINT, SIGTERM};
    let register = |signal| {
        // The order matters: the flag is still clear when the first signal passes the first handler.
        signal_hook::flag::register_conditional_default(signal, cancel.flag())?;
        signal_hook::flag::register(signal, cancel.flag())
    };
    for signal in [SIGINT, SIGTERM] {
        register(signal).map_err(|cause| Error::new(Kind::Internal, "cannot listen for signals").because(cause))?;
    }
    Ok(())
}

/// Shows a session.
struct Watcher {
    meter: Meter,
    error: ErrorSoFar,
}

impl Observer for Watcher {
    fn pass(&mut self, progress: &Progress<'_>) {
        let error = &mut self.error;
        let what = || format!("{} spp{}, ", progress.film.passes().len(), error.update(progress));
        self.meter.show(progress.fraction(), progress.remaining(), what);
    }
}

/// The error of the film, looked at only whenever the number of samples has doubled: a look costs a walk over all pixels.
struct ErrorSoFar {
    method: Method,
    looked_at: u64,
    text: String,
}

impl ErrorSoFar {
    fn of(method: Method) -> Self {
        ErrorSoFar { method, looked_at: 0, text: String::new() }
    }

    fn update(&mut self, progress: &Progress<'_>) -> &str {
        let held = progress.film.passes().len();
        if held >= 2 * self.looked_at.max(1) {
            self.looked_at = held;
            let error = progress.film.image_error(self.method.independent());
            self.text = error.map(|e| format!(", relMSE {:.2e}", e.relmse.value)).unwrap_or_default();
        }
        &self.text
    }
}

/// How often a line of progress is written where there is no terminal.
const LINE_INTERVAL: Duration = Duration::from_secs(10);

/// Steps of the bar: fine enough for the widest terminal.
const STEPS: u64 = 10_000;

/// Shows how far something is.
pub(super) enum Meter {
    /// Not at all.
    Silence,
    /// By a line now and then.
    Lines {
        /// When the next is due.
        next: Instant,
    },
    /// By a bar on a terminal, gone when it is over.
    Bar(ProgressBar),
}

impl Meter {
    /// What suits the console.
    pub(super) fn new(console: Console) -> Self {
        if console.quiet {
            return Meter::Silence;
        }
        if !std::io::stderr().is_terminal() {
            return Meter::Lines { next: Instant::now() + LINE_INTERVAL };
        }
        let bar = ProgressBar::new(STEPS);
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} {msg}") {
            bar.set_style(style);
        }
        Meter::Bar(bar)
    }

    /// Shows the share that is done, what else there is to say, and the time that is left.
    pub(super) fn show(&mut self, done: f64, left: Duration, mut what: impl FnMut() -> String) {
        // Floored, so that 100 means done.
        let percent = (done * 100.0).floor();
        match self {
            Meter::Silence => {}
            Meter::Lines { next } if Instant::now() < *next => {}
            Meter::Lines { next } => {
                *next = Instant::now() + LINE_INTERVAL;
                console::stderr(&format!("etendue: {percent}%, {}{:#} left", what(), HumanDuration(left)));
            }
            Meter::Bar(bar) => {
                bar.set_position((done * STEPS as f64).floor() as u64);
                bar.set_message(format!("{percent}%, {}{:#} left", what(), HumanDuration(left)));
            }
        }
    }
}

impl Drop for Meter {
    fn drop(&mut self) {
        if let Meter::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}
