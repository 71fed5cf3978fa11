//! Terminal output: results on stdout, everything else on stderr.

use crate::error::{Error, Kind, Result};
use indicatif::ProgressBar;
use std::io::Write;
use std::sync::{Mutex, PoisonError};

/// Console output options.
#[derive(Debug, Clone, Copy, clap::Args)]
#[command(next_help_heading = "Messages")]
pub(super) struct Console {
    /// Print one JSON document on stdout instead of text
    #[arg(long)]
    pub(super) json: bool,
    /// Print errors only, without progress and notes
    #[arg(long, short)]
    pub(super) quiet: bool,
    /// Results are printed by the caller.
    #[arg(skip)]
    pub(super) silent: bool,
}

impl Console {
    /// Prints a note.
    pub(super) fn note(self, text: &str) {
        if !self.quiet {
            stderr(&format!("etendue: {text}"));
        }
    }

    /// Prints a warning.
    pub(super) fn warn(self, text: &str) {
        self.note(&format!("warning: {text}"));
    }

    /// Prints a line of the result, unless a JSON document replaces it.
    pub(super) fn line(self, text: &str) -> Result<()> {
        if self.json || self.silent { Ok(()) } else { print(text) }
    }

    /// Prints the JSON document of the result, if requested.
    pub(super) fn document(self, document: &impl serde::Serialize) -> Result<()> {
        if self.json && !self.silent { print(&pretty(document)?) } else { Ok(()) }
    }
}

/// Formats a JSON document.
pub(super) fn pretty(document: &impl serde::Serialize) -> Result<String> {
    serde_json::to_string_pretty(document).map_err(|e| Error::new(Kind::Internal, "cannot write JSON").because(e))
}

/// Prints an error.
pub(super) fn error(text: &str) {
    stderr(&format!("etendue: error: {text}"));
}

/// The progress bar on the terminal, if there is one. Other threads write their lines above it.
static BAR: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Registers the progress bar above which lines are written, or removes it.
pub(super) fn share_terminal(bar: Option<ProgressBar>) {
    *BAR.lock().unwrap_or_else(PoisonError::into_inner) = bar;
}

fn above_bar<T>(write: impl FnOnce() -> T) -> T {
    match &*BAR.lock().unwrap_or_else(PoisonError::into_inner) {
        Some(bar) => bar.suspend(write),
        None => write(),
    }
}

/// Prints a line on stdout at once.
pub(super) fn print(text: &str) -> Result<()> {
    let write = || {
        let mut out = std::io::stdout().lock();
        writeln!(out, "{text}").and_then(|()| out.flush())
    };
    above_bar(write).map_err(|cause| Error::new(Kind::Output, "cannot write to stdout").because(cause))
}

/// Prints a line on stderr. Failure is ignored, since nobody reads it then.
pub(super) fn stderr(text: &str) {
    let _ = above_bar(|| writeln!(std::io::stderr().lock(), "{text}"));
}
