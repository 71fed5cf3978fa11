//! `etendue bench`: measurements, one file each.

mod rays;

use crate::error::Result;

/// What is measured.
#[derive(Debug, clap::Subcommand)]
pub(super) enum Command {
    /// Rays per second inside a render, beside the same rays replayed raw
    Rays(Box<rays::Args>),
}

/// Measures.
pub(super) fn run(command: Command) -> Result<()> {
    match command {
        Command::Rays(args) => rays::run(*args),
    }
}
