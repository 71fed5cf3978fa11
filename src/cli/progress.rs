//! Runs a session with signal handling and progress display: a bar on a terminal, periodic lines elsewhere.

use super::status::{Event, Status, StatusFormat};
use super::view::{self, View};
use super::{Console, console};
use crate::error::{Error, Result};
use crate::film::ImageError;
use crate::parallel::Cancel;
use crate::session::{Checkpoint, Ended, Observer, Progress, Session};
use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::net::SocketAddr;
use std::time::{Duration, Instant};

/// Progress display and status output.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
#[command(next_help_heading = "Messages")]
pub(super) struct ProgressArgs {
    /// Style of the progress display [default: bar on a terminal, else plain]
    #[arg(long, value_enum, value_name = "STYLE")]
    progress: Option<Style>,
    /// Print the state of the render on stdout, one object per line
    #[arg(long, value_enum, value_name = "FORMAT")]
    status: Option<StatusFormat>,
    /// Show the picture in progress in tev, which listens there, e.g. localhost:14158
    #[arg(long, value_name = "HOST:PORT", value_parser = view::address)]
    view: Option<SocketAddr>,
}

/// Styles of the progress display.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Style {
    /// A bar on stderr
    Bar,
    /// Periodic lines on stderr
    Plain,
    /// Lines on stdout for Open Job Description sessions
    Openjd,
    /// Lines on stdout for Tractor blades
    Alf,
    /// Nothing
    None,
}

/// Runs the session and saves its film as `checkpoint` says.
pub(super) fn run(
    session: &mut Session<'_>,
    console: Console,
    told: ProgressArgs,
    cancel: &Cancel,
    checkpoint: Option<Checkpoint>,
) -> Result<Ended> {
    let (settings, plan) = (&session.provenance().settings, session.provenance().plan);
    let amount = plan.count().map_or_else(String::new, |passes| format!(", {passes} samples per pixel"));
    console.note(&format!("rendering {}x{}{amount}", settings.width, settings.height));
    let status = told.status.map(|format| Status::new(format, session.provenance()));
    let error = ErrorSoFar::default();
    let view = told.view.and_then(|address| View::open(address, session.provenance(), session.film(), console));
    let mut watcher = Watcher { meter: Meter::styled(told.progress, console), error, status, view, console };
    watcher.tell(Event::Begin, session);
    let ended = session.run(cancel, &mut watcher, checkpoint)?;
    watcher.end(session, ended);
    Ok(ended)
}

/// Observer that displays a session.
struct Watcher {
    meter: Meter,
    error: ErrorSoFar,
    status: Option<Status>,
    view: Option<View>,
    console: Console,
}

impl Watcher {
    /// Prints an event of the session to the status output.
    fn tell(&self, event: Event, session: &Session<'_>) {
        let Some(status) = &self.status else { return };
        let error = session.provenance().error_of(session.film());
        status.tell_of(event, session.film(), session.provenance(), error.as_ref());
    }

    fn end(&mut self, session: &Session<'_>, ended: Ended) {
        let event = if ended == Ended::Complete { Event::Complete } else { Event::Stopped };
        if event == Event::Complete {
            self.meter.show(1.0, Duration::ZERO, String::new);
        }
        self.view.iter_mut().for_each(|view| {
            view.show(session.film());
        });
        self.tell(event, session);
    }
}

impl Observer for Watcher {
    fn unsaved(&mut self, error: &Error) {
        self.console.warn(&format!("{}; the render goes on", error.chain()));
    }

    fn pass(&mut self, progress: &Progress<'_>) {
        let Watcher { meter, error, status, view, .. } = self;
        // A viewer that has closed is dropped.
        *view = view.take().and_then(|mut view| (!view.is_due() || view.show(progress.film)).then_some(view));
        if let Some(status) = status.as_mut().filter(|status| status.is_due()) {
            status.tell(progress, error.update(progress));
        }
        let what = || {
            let relmse = error.update(progress).map(|e| format!(", relMSE {:.2e}", e.relmse.value)).unwrap_or_default();
            format!("{} spp{relmse}, ", progress.film.passes().len())
        };
        meter.show(progress.pace.fraction(), progress.pace.remaining(), what);
    }
}

/// The error of the film. It is updated only when the number of samples has doubled, since each update visits all
/// pixels.
#[derive(Default)]
struct ErrorSoFar {
    looked_at: u64,
    error: Option<ImageError>,
}

impl ErrorSoFar {
    fn update(&mut self, progress: &Progress<'_>) -> Option<&ImageError> {
        let held = progress.film.passes().len();
        if held >= 2 * self.looked_at.max(1) {
            self.looked_at = held;
            self.error = progress.provenance.error_of(progress.film);
        }
        self.error.as_ref()
    }
}

/// Interval between lines of progress without a terminal.
const LINE_INTERVAL: Duration = Duration::from_secs(10);

/// Steps of the bar: fine enough for the widest terminal.
const STEPS: u64 = 10_000;

/// Display of the progress of an operation.
pub(super) enum Meter {
    /// No display.
    Silence,
    /// Periodic lines.
    Lines {
        /// Time of the next line.
        next: Instant,
    },
    /// A bar on a terminal, removed at the end.
    Bar(ProgressBar),
    /// Lines on stdout for another program, one per per cent.
    Percents {
        /// Text before and after the number.
        around: [&'static str; 2],
        /// The last number printed.
        told: Option<u64>,
    },
}

impl Meter {
    /// Returns the default display of the console.
    pub(super) fn new(console: Console) -> Self {
        Self::styled(None, console)
    }

    /// Returns the requested display, or the console's default.
    fn styled(style: Option<Style>, console: Console) -> Self {
        let usual = || match (console.quiet, std::io::stderr().is_terminal()) {
            (true, _) => Style::None,
            (false, true) => Style::Bar,
            (false, false) => Style::Plain,
        };
        match style.unwrap_or_else(usual) {
            Style::None => Meter::Silence,
            Style::Plain => Meter::Lines { next: Instant::now() + LINE_INTERVAL },
            Style::Openjd => Meter::Percents { around: ["openjd_progress: ", ""], told: None },
            Style::Alf => Meter::Percents { around: ["ALF_PROGRESS ", "%"], told: None },
            Style::Bar => Self::bar(),
        }
    }

    fn bar() -> Self {
        let bar = ProgressBar::new(STEPS);
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} {msg}") {
            bar.set_style(style);
        }
        console::share_terminal(Some(bar.clone()));
        Meter::Bar(bar)
    }

    /// Shows the completed fraction, further text, and the remaining time.
    pub(super) fn show(&mut self, done: f64, left: Duration, mut what: impl FnMut() -> String) {
        // Rounded down, so that 100 means complete.
        let percent = (done * 100.0).floor();
        match self {
            Meter::Silence => {}
            Meter::Lines { next } if Instant::now() < *next => {}
            Meter::Lines { next } => {
                *next = Instant::now() + LINE_INTERVAL;
                console::stderr(&format!("etendue: {percent}%, {}{:#} left", what(), HumanDuration(left)));
            }
            Meter::Percents { told, .. } if *told == Some(percent as u64) => {}
            Meter::Percents { around: [before, after], told } => {
                *told = Some(percent as u64);
                // If stdout is closed, the render continues.
                let _ = console::print(&format!("{before}{percent}{after}"));
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
            console::share_terminal(None);
            bar.finish_and_clear();
        }
    }
}
