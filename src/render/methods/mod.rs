//! Error against time: methods × backends × scenes, interleaved repetition by repetition, so that whatever else the machine
//! does falls on all of them. Each repetition is an independent render (a seed of its own) whose image is compared with a
//! reference at doubling sample counts. The clock counts everything from the prelude on, but not the comparisons; a warm-up
//! comes before and is not counted.
//!
//! Repetitions use the same seeds for every method and backend: backends then render almost the same pictures and their
//! ratio is one of times alone. Intervals are Student's over repetitions, of logarithms, so they hold for the geometric mean.

mod contestant;
mod curve;
mod page;
mod reference;
mod report;

pub use curve::{Curve, Interval, Mark, Point, Slope};
pub use reference::Record as ReferenceRecord;
pub use report::{MethodsReport, Ratio, SceneReport};

use super::{Look, Settings, Stage, writable};
use crate::error::{Error, Kind, Result};
use crate::integrator::Method;
use contestant::Contestant;
use reference::Reference;
use std::path::PathBuf;
use std::time::Duration;

/// Points that a curve has at least: doublings from one sample in each replicate.
const FEWEST_POINTS: u32 = 5;
/// Repetitions where none are asked for and the budget allows.
const REPETITIONS: u32 = 5;
/// Repetitions at least: an interval needs two.
const FEWEST_REPETITIONS: u32 = 2;
/// Doublings beyond this make no curve clearer.
const MOST_DOUBLINGS: u32 = 24;

/// A scene, built for each backend.
pub struct Subject {
    /// What it is called in reports and file names.
    pub name: String,
    /// Built once for each backend, with its settings.
    pub stages: Vec<(Stage, Settings)>,
    /// How its pictures are shown.
    pub look: Look,
    /// A reference image, and its own relMSE where the file does not carry it.
    pub reference: Option<(PathBuf, Option<f64>)>,
}

/// What is asked for.
pub struct Request {
    /// The methods to compare.
    pub methods: Vec<Method>,
    /// Time for all repetitions of each curve.
    pub budget: Duration,
    /// How many repetitions; `None` for five, or what fits into the budget.
    pub repetitions: Option<u32>,
    /// Time for a reference that has to be made.
    pub reference_budget: Duration,
    /// Where reports go.
    pub folder: PathBuf,
    /// The command that asks for it, to be shown.
    pub command: String,
}

/// Measures, and writes `report.json`, `points.csv` and `index.html` into the folder, made references beside them.
///
/// # Errors
/// A folder that cannot be written, a reference that does not fit its scene, a camera that is not there.
pub fn run(request: &Request, subjects: &[Subject], note: &mut dyn FnMut(&str)) -> Result<MethodsReport> {
    std::fs::create_dir_all(&request.folder).map_err(|cause| Error::write(&request.folder, cause))?;
    writable(&request.folder.join("report.json"))?;
    let given = subjects.iter().map(Reference::given).collect::<Result<Vec<_>>>()?;
    let mut fields = subjects.iter().map(|subject| field(request, subject)).collect::<Result<Vec<_>>>()?;
    let repetitions = repetitions(request, fields.iter().flatten());
    fields.iter_mut().flatten().for_each(|c| c.plan(doublings(request.budget, repetitions, c)));
    let mut references = Vec::new();
    for ((subject, field), given) in subjects.iter().zip(&fields).zip(given) {
        references.push(match given {
            Some(reference) => reference,
            None => reference::make(request, subject, field, note)?,
        });
    }
    for repetition in 0..repetitions {
        note(&format!("repetition {} of {repetitions}", repetition + 1));
        for (field, reference) in fields.iter_mut().zip(&references) {
            field.iter_mut().try_for_each(|contestant| contestant.run(repetition, reference))?;
        }
    }
    let report = report::report(request, repetitions, subjects, &fields, &references);
    report::write(request, &report)?;
    page::write(request, &report, subjects, &fields, &references)?;
    Ok(report)
}

/// Every method with every backend on a scene, warmed up.
fn field<'a>(request: &Request, subject: &'a Subject) -> Result<Vec<Contestant<'a>>> {
    let pairs = request.methods.iter().flat_map(|&method| subject.stages.iter().map(move |stage| (method, stage)));
    pairs.map(|(method, (stage, settings))| Contestant::warmed_up(stage, Settings { method, ..settings.clone() })).collect()
}

/// As many repetitions as were asked for; else five, or fewer if the slowest curve would not get its points within the budget.
fn repetitions<'a, 'b: 'a>(request: &Request, contestants: impl Iterator<Item = &'a Contestant<'b>>) -> u32 {
    let slowest = contestants.map(|c| c.seconds(FEWEST_POINTS - 1)).fold(0.0, f64::max);
    let fitting = (request.budget.as_secs_f64() / slowest).clamp(f64::from(FEWEST_REPETITIONS), f64::from(REPETITIONS));
    request.repetitions.unwrap_or(fitting as u32)
}

/// How often a curve's sample count is doubled: as often as the budget allows, and often enough for its points.
fn doublings(budget: Duration, repetitions: u32, contestant: &Contestant<'_>) -> u32 {
    let each = budget.as_secs_f64() / f64::from(repetitions);
    (FEWEST_POINTS..=MOST_DOUBLINGS).take_while(|&k| contestant.seconds(k) <= each).last().unwrap_or(FEWEST_POINTS - 1)
}

/// An internal error for what cannot be.
fn defect(what: &str) -> Error {
    Error::new(Kind::Internal, what)
}
