//! What the runs say: false alarms, the matrix, the verdict.

use crate::binaries::Located;
use crate::mutations::Mutation;
use crate::run::{Ending, LIMIT, Outcome};

/// Every killer must pass where no mutation is on.
pub(crate) fn check_healthy(killers: &[Located], healthy: &[Outcome]) -> Result<(), String> {
    complain(killers.iter().zip(healthy).filter_map(|(located, outcome)| {
        let name = located.killer.name();
        match &outcome.ending {
            Ending::Passed => None,
            Ending::Failed => Some(format!("{name} fails without a mutation: a false alarm")),
            Ending::Unclear(what) => Some(format!("{name}: {what}")),
            Ending::NotRun => Some(format!("{name} did not run")),
        }
    }))
}

/// Every killer must keep within [`LIMIT`].
pub(crate) fn check_budget(killers: &[Located], healthy: &[Outcome]) -> Result<(), String> {
    let slow = killers.iter().zip(healthy).filter(|(_, outcome)| outcome.seconds > LIMIT);
    complain(slow.map(|(located, outcome)| {
        format!("{} takes {:.1} s of a processor, at most {LIMIT}", located.killer.name(), outcome.seconds)
    }))
}

fn complain(complaints: impl Iterator<Item = String>) -> Result<(), String> {
    let complaints: Vec<String> = complaints.collect();
    if complaints.is_empty() { Ok(()) } else { Err(complaints.join("\n       ")) }
}

/// The heads of the columns, which are killers by number: hundreds, tens, ones.
pub(crate) fn print_head(killers: &[Located]) {
    println!();
    for place in [100, 10, 1] {
        let digits: String = (0..killers.len()).map(|i| char::from(b'0' + (i / place % 10) as u8)).collect();
        println!("{:28} {digits}", "");
    }
}

/// A row: `x` killed, `.` survived, `?` no verdict, a blank did not run. Then how many killed, and
/// which was the fastest.
pub(crate) fn print_row(mutation: &Mutation, killers: &[Located], row: &[Outcome]) {
    let marks: String = row.iter().map(mark).collect();
    let kills = || row.iter().enumerate().filter(|(_, outcome)| outcome.is_kill());
    let fastest = kills().min_by(|a, b| a.1.seconds.total_cmp(&b.1.seconds));
    let fastest = fastest.map_or("SURVIVES".into(), |(i, outcome)| {
        format!("{:3} killers, {:.2} s by {i:3} {}", kills().count(), outcome.seconds, killers[i].killer.test)
    });
    println!("{:28} {marks} {fastest}", mutation.name);
}

/// The killers by number: seconds without a mutation, and how many of the mutations each kills.
pub(crate) fn print_killers(killers: &[Located], healthy: &[Outcome], rows: &[Vec<Outcome>]) {
    println!("\n    seconds  kills  killer");
    for (i, (located, outcome)) in killers.iter().zip(healthy).enumerate() {
        let kills = rows.iter().filter(|row| row[i].is_kill()).count();
        println!("{i:3} {:7.2} {kills:6}  {}", outcome.seconds, located.killer.name());
    }
}

fn mark(outcome: &Outcome) -> char {
    match outcome.ending {
        Ending::Failed => 'x',
        Ending::Passed => '.',
        Ending::Unclear(_) => '?',
        Ending::NotRun => ' ',
    }
}

/// All that was spent on killers.
pub(crate) fn processor_seconds(healthy: &[Outcome], rows: &[Vec<Outcome>]) -> f64 {
    rows.iter().flatten().chain(healthy).map(|outcome| outcome.seconds).sum()
}

/// `killed N/N`, or who survived.
pub(crate) fn verdict(mutations: &[&Mutation], rows: &[Vec<Outcome>]) -> Result<(), String> {
    let survives = |row: &[Outcome]| !row.iter().any(Outcome::is_kill);
    let survivors: Vec<_> = mutations.iter().zip(rows).filter(|(_, row)| survives(row)).map(|(m, _)| m).collect();
    let report = survivors.iter().map(|m| format!("\n       {} survives: {}", m.name, m.wrong)).collect::<String>();
    println!("killed {}/{}", mutations.len() - survivors.len(), mutations.len());
    if survivors.is_empty() { Ok(()) } else { Err(format!("{} survived{report}", survivors.len())) }
}
