//! Under what conditions something was measured, as reports and their pages show it.

use super::machine::{Processor, peak_memory};
use super::{Program, megabytes, provenance};
use crate::io::page::facts;
use maud::{Markup, html};
use serde::Serialize;

/// The program, the machine and the command.
#[derive(Debug, Clone, Serialize)]
pub struct Conditions {
    /// The program.
    pub program: Program,
    /// The processor's name, where the system tells it.
    pub processor: Option<String>,
    /// The most memory the whole run took, everything in it together.
    pub peak_memory_bytes: Option<u64>,
    /// The command.
    pub command: String,
    /// When it ended, in UTC.
    pub finished: String,
}

impl Conditions {
    /// Those of a run of `command` that ends now.
    pub(super) fn now(command: &str) -> Conditions {
        Conditions {
            program: Program::current(),
            processor: Processor::detect().model,
            peak_memory_bytes: peak_memory(),
            command: command.to_owned(),
            finished: provenance::now(),
        }
    }

    /// The part of a page that tells them, and `more`; `files` holds the numbers behind the page.
    pub(super) fn markup<'a>(&self, more: impl IntoIterator<Item = (&'a str, String)>, files: &str) -> Markup {
        let memory = self.peak_memory_bytes.map_or("unknown".into(), megabytes);
        let own = [
            ("Processor", self.processor.clone().unwrap_or("unknown".into())),
            ("étendue", self.program.to_string()),
            ("Finished", self.finished.clone()),
            ("Most memory", format!("{memory} for all scenes and backends together")),
        ];
        html! {
            (facts(own.into_iter().chain(more)))
            p { "To measure again:" }
            pre { code { (self.command) } }
            p.soft { "The numbers behind this page are in " (files) " beside it." }
        }
    }
}
