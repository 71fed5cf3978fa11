//! The command line: one file per subcommand. Each reads its inputs, calls `session`, `lab` or `batch`, and reports the
//! outcome. Results go to stdout, everything else to stderr.

mod args;
mod batch;
mod bench;
mod compare;
mod console;
mod doctor;
mod film;
mod finish;
mod info;
mod init;
mod man;
mod merge;
mod named_value;
mod progress;
mod render;
mod resume;
mod settings_args;
mod signals;
mod startup;
mod status;
mod task;
mod techniques;
mod verify;
mod view;

use crate::error::Result;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use console::Console;
use std::process::ExitCode;

/// The `etendue` command.
#[derive(Debug, Parser)]
#[command(
    name = "etendue",
    version = startup::version(),
    about = "A physically based renderer: glTF in, EXR out, and every image carries its error",
    after_help = EXAMPLES,
    max_term_width = 110
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a glTF scene to an image
    Render(Box<render::Args>),
    /// Render all pictures of a batch file
    #[command(after_help = batch::AFTER)]
    Batch(Box<batch::Args>),
    /// Write a render.toml in which every setting is explained
    Init(init::Args),
    /// Describe a scene, its ignored features and the resources that rendering it takes
    Info(Box<info::Args>),
    /// Merge several films of the same picture into one image or film
    Merge(merge::Args),
    /// Compare an image with a reference, and test whether they could have the same mean
    Compare(compare::Args),
    /// Measure ray throughput, or error against time
    #[command(subcommand)]
    Bench(bench::Command),
    /// Continue a film that was stopped, or add samples to it
    Resume(resume::Args),
    /// Describe a film, its progress and its error
    Status(film::StatusArgs),
    /// Write a film's picture whenever the film has changed, until it is complete
    Watch(film::WatchArgs),
    /// Describe the capabilities of this machine and this build, and any problems
    Doctor(doctor::Args),
    /// Print completions for a shell
    Completions(man::CompletionArgs),
    /// Write manual pages
    Man(man::ManArgs),
    /// Compare all methods and backends on a scene
    #[command(long_about = verify::LONG, after_help = verify::AFTER)]
    Verify(Box<verify::Args>),
}

const EXAMPLES: &str = "\
Examples:
  etendue render cup.glb                          64 samples per pixel, writes cup.exr
  etendue render cup.glb -o cup.png --time 30s    a picture to look at, after half a minute
  etendue render cup.glb --shard 0/4 -o 0.film    one of four shares of the work, on any machine
  etendue merge 0.film 1.film 2.film 3.film -o cup.exr
  etendue resume cup.film --spp 1024              more samples, as if asked for at once
  etendue batch job.toml                          all pictures of a batch file; run again, it goes on
  etendue verify cup.glb                          do all methods and backends agree on it?

Exit codes:
  0 done   1 internal error   2 usage   3 scene invalid   4 output cannot be written
  5 target not reached (with --require-target)   6 non-finite samples (with --fail-on-nonfinite)
  7 a difference found (compare, verify)   33 out of memory   75 stopped: run again";

/// Runs the program on the process's arguments.
pub fn run() -> ExitCode {
    startup::report_panics();
    let parsed = command().try_get_matches().and_then(|matches| Cli::from_arg_matches(&matches));
    let cli = match parsed {
        Ok(cli) => cli,
        Err(refusal) => return startup::refuse(&refusal),
    };
    let outcome = std::panic::catch_unwind(|| startup::check_processor().and_then(|()| execute(cli.command)));
    match outcome {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(error)) => {
            console::error(&error.chain());
            ExitCode::from(error.kind.exit_code())
        }
        // The panic hook has printed the message.
        Err(_) => ExitCode::from(crate::error::Kind::Internal.exit_code()),
    }
}

/// Returns the command line. Each subcommand has its own view of the shared flags.
fn command() -> clap::Command {
    Cli::command().mut_subcommand("verify", verify::command)
}

fn execute(command: Command) -> Result<()> {
    match command {
        Command::Render(args) => render::run(*args),
        Command::Batch(args) => batch::run(*args),
        Command::Init(args) => init::run(args),
        Command::Info(args) => info::run(*args),
        Command::Compare(args) => compare::run(args),
        Command::Bench(command) => bench::run(command),
        Command::Merge(args) => merge::run(args),
        Command::Resume(args) => resume::run(args),
        Command::Status(args) => film::status(&args),
        Command::Watch(args) => film::watch(&args),
        Command::Doctor(args) => doctor::run(args),
        Command::Completions(args) => man::completions(&args),
        Command::Man(args) => man::man(&args),
        Command::Verify(args) => verify::run(*args),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_command_line_is_consistent() {
        super::command().debug_assert();
    }
}
