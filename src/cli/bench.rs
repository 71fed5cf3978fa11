//! `etendue bench`: measurements, one file each.

mod diffusion;
mod methods;
mod rays;

use crate::error::Result;
use crate::session::picture_name;
use std::path::PathBuf;

/// Available measurements.
#[derive(Debug, clap::Subcommand)]
pub(super) enum Command {
    /// Measure error against time, methods and backends side by side, and write a page about it
    Methods(Box<methods::Args>),
    /// Measure the errors of the diffusion models of --subsurface in a medium, against a random walk
    Diffusion(diffusion::Args),
    /// Measure ray throughput of backends and builds, raw, in packets and inside a render, and compare their hits
    Rays(Box<rays::Args>),
}

/// Runs a measurement.
pub(super) fn run(command: Command) -> Result<()> {
    match command {
        Command::Methods(args) => methods::run(&args),
        Command::Diffusion(args) => diffusion::run(&args),
        Command::Rays(args) => rays::run(&args),
    }
}

/// Returns the name of scene `at` in reports: its picture's name, with a number if earlier scenes have the same.
fn scene_name(scenes: &[PathBuf], at: usize) -> String {
    let own = picture_name(&scenes[at]);
    let twins = scenes[..at].iter().filter(|other| picture_name(other) == own).count();
    let name = own.to_string_lossy().into_owned();
    if twins > 0 { format!("{name}-{}", twins + 1) } else { name }
}

/// Returns this process's command line, quoted for a shell.
fn command() -> String {
    typed(std::env::args().skip(1))
}

fn typed(arguments: impl Iterator<Item = String>) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_-+=./:,@%".contains(c);
    let quoted = |a: String| {
        if !a.is_empty() && a.chars().all(is_plain) { a } else { format!("'{}'", a.replace('\'', r"'\''")) }
    };
    std::iter::once("etendue".to_owned()).chain(arguments.map(quoted)).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quoted_command_lines_round_trip() {
        let line = ["bench", "my scene.gltf", "--size", "64x64", "it's", ""].map(String::from);
        assert_eq!(typed(line.into_iter()), r"etendue bench 'my scene.gltf' --size 64x64 'it'\''s' ''");
    }
}
