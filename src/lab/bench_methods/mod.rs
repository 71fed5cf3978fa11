//! Error against time: methods × backends × scenes. Repetitions are interleaved, so that background load affects all of
//! them alike. Each repetition is an independent render with its own seed. Its image is compared with a reference at
//! doubling sample counts. The clock runs from the pilot on and excludes the comparisons. An untimed warm-up precedes
//! the measurement.
//!
//! Repetition r uses the same seed for every method and backend. Different backends then render almost the same
//! picture, so that their ratio reflects render times only. Confidence intervals are Student's t over the logarithms of
//! the repetitions, so that they hold for the geometric mean.

mod contestant;
mod curve;
mod make_reference;
mod mark;
mod page;
mod reference;
mod report;

pub use curve::{CurvePoint, ErrorCurve, Interval, Slope};
pub use mark::Mark;
pub use reference::Record as ReferenceRecord;
pub use report::{MethodsReport, Ratio, SceneReport};

use crate::error::{Error, Kind, Result};
use crate::integrator::Method;
use crate::session::{LoadedScene, RenderJob, writable};
use contestant::BenchCase;
use reference::Reference;
use std::path::PathBuf;
use std::time::Duration;

/// Minimum number of points of a curve, at doubling sample counts from one sample in each replicate.
const FEWEST_POINTS: u32 = 5;
/// Default number of repetitions, if the budget allows.
const REPETITIONS: u32 = 5;
/// Minimum number of repetitions: an interval needs two.
const FEWEST_REPETITIONS: u32 = 2;
/// Maximum number of doublings: more do not make a curve clearer.
const MOST_DOUBLINGS: u32 = 24;

/// A scene to measure, built for each backend.
pub struct BenchScene {
    /// Name in reports and file names.
    pub name: String,
    /// Built once for each backend, with the job that [`RenderJob::settings_of`] asks for each method.
    pub stages: Vec<(LoadedScene, RenderJob)>,
    /// A reference image, with its own relMSE if the file does not carry one.
    pub reference: Option<(PathBuf, Option<f64>)>,
}

/// A requested measurement.
pub struct MethodsRequest {
    /// The methods to compare.
    pub methods: Vec<Method>,
    /// Time for all repetitions of each curve.
    pub budget: Duration,
    /// Number of repetitions; `None` for five, or as many as fit into the budget.
    pub repetitions: Option<u32>,
    /// Time for rendering a reference.
    pub reference_budget: Duration,
    /// Folder of the reports.
    pub folder: PathBuf,
    /// The command line, shown in the report.
    pub command: String,
}

/// Runs the measurement. Writes `report.json`, `points.csv` and `index.html` into the folder, and rendered references
/// beside them.
///
/// # Errors
/// The folder cannot be written, a reference does not fit its scene, or a camera does not exist.
pub fn run(request: &MethodsRequest, subjects: &[BenchScene], note: &mut dyn FnMut(&str)) -> Result<MethodsReport> {
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
            None => make_reference::make(request, subject, field, note)?,
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
fn field<'a>(request: &MethodsRequest, subject: &'a BenchScene) -> Result<Vec<BenchCase<'a>>> {
    let pairs = request.methods.iter().flat_map(|&method| subject.stages.iter().map(move |stage| (method, stage)));
    pairs.map(|(method, (stage, job))| BenchCase::warmed_up(stage, job.settings_of(method)?)).collect()
}

/// Returns the number of repetitions asked for. The default is five, or fewer if the slowest curve would not get its
/// minimum of points within the budget.
fn repetitions<'a, 'b: 'a>(request: &MethodsRequest, contestants: impl Iterator<Item = &'a BenchCase<'b>>) -> u32 {
    let slowest = contestants.map(|c| c.seconds(FEWEST_POINTS - 1)).fold(0.0, f64::max);
    let fitting = (request.budget.as_secs_f64() / slowest).clamp(f64::from(FEWEST_REPETITIONS), f64::from(REPETITIONS));
    request.repetitions.unwrap_or(fitting as u32)
}

/// Returns the number of doublings of a curve: as many as the budget allows, but at least the minimum number of points.
fn doublings(budget: Duration, repetitions: u32, contestant: &BenchCase<'_>) -> u32 {
    let each = budget.as_secs_f64() / f64::from(repetitions);
    (FEWEST_POINTS..=MOST_DOUBLINGS).take_while(|&k| contestant.seconds(k) <= each).last().unwrap_or(FEWEST_POINTS - 1)
}

/// An internal error for a violated invariant.
fn defect(what: &str) -> Error {
    Error::new(Kind::Internal, what)
}
