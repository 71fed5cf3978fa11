//! Running a session with signals heard and progress shown: a bar on a terminal, a line now and then elsewhere.

use super::{Console, console};
use crate::error::{Error, Kind, Result};
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
    session.run(&cancel, &mut *observer(console), film.map(Checkpoint::new))
}

/// The first SIGINT or SIGTERM asks for a stop, the second kills.
fn heed_signals(cancel: &Cancel) -> Result<()> {
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

fn observer(console: Console) -> Box<dyn Observer> {
    if console.quiet {
        Box::new(Silence)
    } else if std::io::stderr().is_terminal() {
        Box::new(Bar::new())
    } else {
        Box::new(Lines { next: Instant::now() + LINE_INTERVAL, error: ErrorSoFar::default() })
    }
}

/// How often a line of progress is written where there is no terminal.
const LINE_INTERVAL: Duration = Duration::from_secs(10);

/// Shows nothing.
struct Silence;

impl Observer for Silence {
    fn pass(&mut self, _: &Progress<'_>) {}
}

/// The error of the film, looked at only whenever the number of samples has doubled: a look costs a walk over all pixels.
#[derive(Default)]
struct ErrorSoFar {
    looked_at: u64,
    text: String,
}

impl ErrorSoFar {
    fn update(&mut self, progress: &Progress<'_>) -> &str {
        let held = progress.film.passes().len();
        if held >= 2 * self.looked_at.max(1) {
            self.looked_at = held;
            let error = progress.film.image_error();
            self.text = error.map(|e| format!(", relMSE {:.2e}", e.relmse.value)).unwrap_or_default();
        }
        &self.text
    }
}

/// A line now and then.
struct Lines {
    next: Instant,
    error: ErrorSoFar,
}

impl Observer for Lines {
    fn pass(&mut self, progress: &Progress<'_>) {
        if Instant::now() < self.next {
            return;
        }
        self.next = Instant::now() + LINE_INTERVAL;
        let (percent, spp, left) = (progress.percent(), progress.film.passes().len(), HumanDuration(progress.remaining()));
        console::stderr(&format!("etendue: {percent}%, {spp} spp{}, {left:#} left", self.error.update(progress)));
    }
}

/// A bar on a terminal, gone when the render is over.
struct Bar {
    bar: ProgressBar,
    error: ErrorSoFar,
}

/// Steps of the bar: fine enough for the widest terminal.
const STEPS: u64 = 10_000;

impl Bar {
    fn new() -> Self {
        let bar = ProgressBar::new(STEPS);
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} {msg}") {
            bar.set_style(style);
        }
        Bar { bar, error: ErrorSoFar::default() }
    }
}

impl Observer for Bar {
    fn pass(&mut self, progress: &Progress<'_>) {
        self.bar.set_position((progress.fraction() * STEPS as f64).floor() as u64);
        let (percent, spp, left) = (progress.percent(), progress.film.passes().len(), HumanDuration(progress.remaining()));
        self.bar.set_message(format!("{percent}%, {spp} spp{}, {left:#} left", self.error.update(progress)));
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
