//! `etendue doctor`: the capabilities of this machine and this build, and any problems.

use super::args::ThreadArgs;
use super::{Console, startup};
use crate::accel::{self, Backend};
use crate::error::{Error, Kind, Result};
use crate::named::Named;
use crate::session::{Program, machine, megabytes};
use serde::Serialize;

/// Arguments of `doctor`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    threads: ThreadArgs,
    #[command(flatten)]
    console: Console,
}

/// Findings.
#[derive(Serialize)]
struct Document {
    program: Program,
    processor: Option<String>,
    /// Instruction sets that the program was compiled for and the processor lacks.
    missing_instructions: Vec<&'static str>,
    threads: usize,
    available_memory_bytes: Option<u64>,
    huge_pages: Option<String>,
    backends: Vec<&'static str>,
    embree: Option<String>,
    /// Problems, one sentence each.
    problems: Vec<String>,
}

/// Examines the machine and the build.
pub(super) fn run(args: Args) -> Result<()> {
    let processor = machine::Processor::detect();
    let mut problems = Vec::new();
    let embree = accel::embree_version().and_then(|version| version.map_err(|e| problems.push(e.chain())).ok());
    let missing = processor.missing();
    if !missing.is_empty() {
        problems.push(format!("the processor lacks {}", missing.join(", ")));
    }
    if tempfile::tempfile().is_err() {
        problems.push(format!("no temporary file can be written to {}", std::env::temp_dir().display()));
    }
    let document = Document {
        program: Program::current(),
        processor: processor.model,
        missing_instructions: missing,
        threads: startup::start_threads(args.threads)?,
        available_memory_bytes: machine::available_memory(),
        huge_pages: machine::huge_pages(),
        backends: Backend::AVAILABLE.iter().map(|backend| backend.name()).collect(),
        embree,
        problems,
    };
    args.console.document(&document)?;
    document.lines().iter().try_for_each(|line| args.console.line(line))?;
    match document.problems.first() {
        None => Ok(()),
        Some(problem) => Err(Error::new(Kind::Internal, problem.clone())),
    }
}

impl Document {
    fn lines(&self) -> Vec<String> {
        let or = |value: &Option<String>, none: &str| value.clone().unwrap_or_else(|| none.into());
        let memory = self.available_memory_bytes.map(megabytes);
        let mut lines = vec![
            format!("program    {}", self.program),
            format!("processor  {}", or(&self.processor, "unknown")),
            format!("threads    {}", self.threads),
            format!("memory     {} to be had", or(&memory, "nobody says how much is")),
            format!("huge pages {}", or(&self.huge_pages, "unknown")),
            format!("backends   {}", self.backends.join(", ")),
            format!("embree     {}", or(&self.embree, "not built in")),
        ];
        lines.extend(self.problems.iter().map(|problem| format!("problem    {problem}")));
        lines
    }
}
