//! The kill matrix: every mutation (mutations/*.toml) against every killer (killers.rs). It measures the tests and not
//! the code: a mutation that no test notices is a test that is missing.
//!
//! Without arguments, as `cargo test` runs it, it checks that the mutations still fit the sources. `--build` writes a
//! copy of the repository with all mutations, target/kill-matrix/tree, in which `ETENDUE_MUTANT=name` turns one on.
//! The following build its tests and run the killers:
//!
//! - `--today`: the 24th of the mutations whose turn it is, or that of `ETENDUE_KILL_PART` (0 to 23), each until one
//!   killer kills, the fastest first;
//! - `--each`: all, each until one killer kills;
//! - `--all`: all, against all killers;
//! - `--mutant NAME …`: those, against all killers.
//!
//! `--list` says what they are. It fails if a mutation survives, or if a killer fails without a mutation or is not
//! there. `--all` also fails if a killer takes more than [`run::LIMIT`] seconds of a processor.

// What it prints is what it is for.
#![allow(clippy::print_stdout)]

mod binaries;
mod check;
mod killers;
mod manifest;
mod matrix;
mod mutations;
mod run;
mod schemata;
mod sites;
mod tree;

use mutations::Mutation;
use std::process::ExitCode;

/// Number of parts of the mutations, one for each day.
const PARTS: u64 = 24;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = check::mutations().and_then(|mutations| act(&arguments, &mutations));
    outcome.map_or_else(
        |what| {
            println!("error: {what}");
            ExitCode::FAILURE
        },
        |()| ExitCode::SUCCESS,
    )
}

fn act(arguments: &[&str], mutations: &[Mutation]) -> Result<(), String> {
    match arguments {
        ["--list"] => list(mutations),
        ["--build"] => tree::build(mutations).map(|tree| println!("{}", tree.display())),
        ["--today"] => judge(mutations, &today(mutations)?, Until::Killed),
        ["--each"] => judge(mutations, &mutations.iter().collect::<Vec<_>>(), Until::Killed),
        ["--all"] => judge(mutations, &mutations.iter().collect::<Vec<_>>(), Until::All),
        ["--mutant", names @ ..] => judge(mutations, &named(mutations, names)?, Until::All),
        // Nothing, or a filter or a flag that was meant for the tests of other binaries.
        _ => Ok(()),
    }
}

fn list(mutations: &[Mutation]) -> Result<(), String> {
    mutations.iter().for_each(|m| println!("{:28} {} ({})", m.name, m.wrong, m.source));
    Ok(())
}

fn named<'m>(mutations: &'m [Mutation], names: &[&str]) -> Result<Vec<&'m Mutation>, String> {
    let find = |&name: &&str| {
        mutations.iter().find(|m| m.name == name).ok_or_else(|| format!("{name} is no mutation: see --list"))
    };
    names.iter().map(find).collect()
}

/// The mutations whose turn it is.
fn today(mutations: &[Mutation]) -> Result<Vec<&Mutation>, String> {
    let turn = match std::env::var("ETENDUE_KILL_PART") {
        Ok(text) => text.parse().ok().filter(|&part| part < PARTS).ok_or("ETENDUE_KILL_PART is 0 to 11")?,
        Err(_) => std::time::UNIX_EPOCH.elapsed().map_err(|e| e.to_string())?.as_secs() / 86_400 % PARTS,
    };
    println!("part {turn} of 0 to {} (ETENDUE_KILL_PART={turn} repeats it)", PARTS - 1);
    Ok(mutations.iter().skip(turn as usize).step_by(PARTS as usize).collect())
}

/// How many killers run against a mutation.
#[derive(Clone, Copy)]
enum Until {
    /// All of them.
    All,
    /// The fastest first, until one kills.
    Killed,
}

/// Builds the copy, runs every killer without a mutation, then against each of `chosen`, and says what came of it.
fn judge(mutations: &[Mutation], chosen: &[&Mutation], until: Until) -> Result<(), String> {
    let start = std::time::Instant::now();
    let tree = tree::build(mutations)?;
    let killers = binaries::locate(killers::KILLERS, &tree)?;
    println!("{} mutations, {} killers", chosen.len(), killers.len());
    let runner = run::Runner { killers: &killers, tree: &tree };
    let healthy = runner.all(None);
    matrix::check_healthy(&killers, &healthy)?;
    matrix::print_head(&killers);
    let turn_on = |mutation: &&Mutation| {
        let row = match until {
            Until::All => runner.all(Some(mutation)),
            Until::Killed => runner.until_killed(mutation, &healthy),
        };
        matrix::print_row(mutation, &killers, &row);
        row
    };
    let rows: Vec<_> = chosen.iter().map(turn_on).collect();
    matrix::print_killers(&killers, &healthy, &rows);
    println!(
        "{:.0} s, {:.0} s of processors",
        start.elapsed().as_secs_f64(),
        matrix::processor_seconds(&healthy, &rows)
    );
    matrix::verdict(chosen, &rows)?;
    match until {
        Until::All => matrix::check_budget(&killers, &healthy),
        Until::Killed => Ok(()),
    }
}
