//! The kill matrix: every planted defect (src/defects.rs) against every killer (killers.rs). It measures the tests and
//! not the code: a defect that no test notices is a test that is missing.
//!
//! Without arguments, as `cargo test --features defects` runs it, it takes the sixth of the defects whose turn it is
//! today, or the one of `ETENDUE_KILL_PART` (0 to 5), each until one killer kills, the fastest first; `--all` takes
//! all, `--defect NAME …` those, `--list` says what they are. It fails if a defect survives, or if a killer fails
//! without a defect or is not there; `--all` also fails if one takes more than [`run::LIMIT`] seconds of a processor.

// What it prints is what it is for.
#![allow(clippy::print_stdout)]

mod binaries;
mod killers;
mod matrix;
mod run;

use etendue::defects::Defect;
use std::process::ExitCode;

/// Into how many parts the defects are dealt.
const PARTS: u64 = 6;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match arguments[..] {
        ["--list"] => list(),
        ["--all"] => judge(Defect::ALL.to_vec(), Until::All),
        ["--defect", ref names @ ..] => names
            .iter()
            .map(|name| named(name))
            .collect::<Result<_, _>>()
            .and_then(|defects| judge(defects, Until::All)),
        [] => part().and_then(|defects| judge(defects, Until::Killed)),
        // A filter or a flag that was meant for the tests of other binaries.
        _ => Ok(()),
    };
    outcome.map_or_else(
        |what| {
            println!("error: {what}");
            ExitCode::FAILURE
        },
        |()| ExitCode::SUCCESS,
    )
}

fn list() -> Result<(), String> {
    Defect::ALL.iter().for_each(|d| println!("{:28} {} ({})", d.name(), d.wrong(), d.known_from()));
    Ok(())
}

fn named(name: &str) -> Result<Defect, String> {
    Defect::ALL.iter().copied().find(|d| d.name() == name).ok_or_else(|| format!("{name} is no defect: see --list"))
}

/// The defects whose turn it is.
fn part() -> Result<Vec<Defect>, String> {
    let turn = match std::env::var("ETENDUE_KILL_PART") {
        Ok(text) => text.parse().ok().filter(|&part| part < PARTS).ok_or("ETENDUE_KILL_PART is 0 to 5")?,
        Err(_) => std::time::UNIX_EPOCH.elapsed().map_err(|e| e.to_string())?.as_secs() / 86_400 % PARTS,
    };
    println!("part {turn} of 0 to {} (ETENDUE_KILL_PART={turn} repeats it)", PARTS - 1);
    Ok((turn as usize..Defect::ALL.len()).step_by(PARTS as usize).map(|i| Defect::ALL[i]).collect())
}

/// How many killers run against a defect.
#[derive(Clone, Copy)]
enum Until {
    /// All of them.
    All,
    /// The fastest first, until one kills.
    Killed,
}

/// Runs every killer without a defect, then against each of `defects`, and says what came of it.
fn judge(defects: Vec<Defect>, until: Until) -> Result<(), String> {
    let start = std::time::Instant::now();
    let killers = binaries::locate(killers::KILLERS)?;
    println!("{} defects, {} killers", defects.len(), killers.len());
    let healthy = run::all(None, &killers);
    matrix::check_healthy(&killers, &healthy)?;
    matrix::print_head(&killers);
    let plant = |&defect: &Defect| {
        let row = match until {
            Until::All => run::all(Some(defect), &killers),
            Until::Killed => run::until_killed(defect, &killers, &healthy),
        };
        matrix::print_row(defect, &killers, &row);
        row
    };
    let rows: Vec<_> = defects.iter().map(plant).collect();
    matrix::print_killers(&killers, &healthy, &rows);
    println!(
        "{:.0} s, {:.0} s of processors",
        start.elapsed().as_secs_f64(),
        matrix::processor_seconds(&healthy, &rows)
    );
    matrix::verdict(&defects, &rows)?;
    match until {
        Until::All => matrix::check_budget(&killers, &healthy),
        Until::Killed => Ok(()),
    }
}
