//! Measurement conditions, as reports and their pages show them.

use crate::lab::html::facts;
use crate::session::machine::{Processor, peak_memory};
use crate::session::{Program, megabytes, provenance};
use maud::{Markup, html};
use serde::Serialize;

/// Program, machine and command of a measurement.
#[derive(Debug, Clone, Serialize)]
pub struct Conditions {
    /// The program.
    pub program: Program,
    /// The processor's name, if the system reports it.
    pub processor: Option<String>,
    /// Peak memory of the whole run, in bytes, with all scenes and backends.
    pub peak_memory_bytes: Option<u64>,
    /// The command.
    pub command: String,
    /// End of the run, in UTC.
    pub finished: String,
}

impl Conditions {
    /// Returns the conditions of a run of `command` that ends now.
    pub(super) fn now(command: &str) -> Conditions {
        Conditions {
            program: Program::current(),
            processor: Processor::detect().model,
            peak_memory_bytes: peak_memory(),
            command: command.to_owned(),
            finished: provenance::now(),
        }
    }

    /// The section of a page that shows the conditions and `more`. `files` names the files with the underlying numbers.
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
