//! What people read: results on stdout, the rest on stderr.

use crate::error::{Error, Kind, Result};
use std::io::Write;

/// How talkative the program is.
#[derive(Debug, Clone, Copy, clap::Args)]
#[command(next_help_heading = "Messages")]
pub(super) struct Console {
    /// Print one JSON document on stdout instead of text
    #[arg(long)]
    pub(super) json: bool,
    /// No progress and no notes, only errors
    #[arg(long, short)]
    pub(super) quiet: bool,
    /// Results are told by whoever asked for them.
    #[arg(skip)]
    pub(super) silent: bool,
}

impl Console {
    /// Tells something in passing.
    pub(super) fn note(self, text: &str) {
        if !self.quiet {
            stderr(&format!("etendue: {text}"));
        }
    }

    /// Warns.
    pub(super) fn warn(self, text: &str) {
        self.note(&format!("warning: {text}"));
    }

    /// Prints a line of the result, unless a JSON document takes its place.
    pub(super) fn line(self, text: &str) -> Result<()> {
        if self.json || self.silent { Ok(()) } else { print(text) }
    }

    /// Prints the JSON document of the result, if that was asked for.
    pub(super) fn document(self, document: &impl serde::Serialize) -> Result<()> {
        if self.json && !self.silent { print(&pretty(document)?) } else { Ok(()) }
    }
}

/// A JSON document as text.
pub(super) fn pretty(document: &impl serde::Serialize) -> Result<String> {
    serde_json::to_string_pretty(document).map_err(|e| Error::new(Kind::Internal, "cannot write JSON").because(e))
}

/// Prints an error.
pub(super) fn error(text: &str) {
    stderr(&format!("etendue: error: {text}"));
}

/// Prints a line on stdout at once.
pub(super) fn print(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "{text}")
        .and_then(|()| out.flush())
        .map_err(|cause| Error::new(Kind::Output, "cannot write to stdout").because(cause))
}

/// If stderr is gone there is nobody left to tell.
pub(super) fn stderr(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}
