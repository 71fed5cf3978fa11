//! `etendue bench`: measurements, one file each.

mod methods;
mod rays;

use crate::error::Result;

/// What is measured.
#[derive(Debug, clap::Subcommand)]
pub(super) enum Command {
    /// Measure error against time, methods and backends side by side, and write a page about it
    Methods(Box<methods::Args>),
    /// Rays per second inside a render, beside the same rays replayed raw
    Rays(Box<rays::Args>),
}

/// Measures.
pub(super) fn run(command: Command) -> Result<()> {
    match command {
        Command::Methods(args) => methods::run(&args),
        Command::Rays(args) => rays::run(*args),
    }
}
