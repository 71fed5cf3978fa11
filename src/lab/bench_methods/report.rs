//! Measured results as one JSON document and as a table of all points.

use super::contestant::BenchCase;
use super::curve::{ErrorCurve, Interval, efficiency};
use super::make_reference::SHARE;
use super::reference::{Record, Reference};
use super::{BenchScene, MethodsRequest};
use crate::error::Result;
use crate::lab::{Conditions, report_files};
use serde::Serialize;

/// All measured results.
#[derive(Debug, Clone, Serialize)]
pub struct MethodsReport {
    /// The program, the machine and the command.
    #[serde(flatten)]
    pub conditions: Conditions,
    /// Number of threads.
    pub threads: usize,
    /// Time budget for all repetitions of a curve, in seconds.
    pub budget_seconds: f64,
    /// Repetitions of each curve.
    pub repetitions: u32,
    /// Results by scene.
    pub scenes: Vec<SceneReport>,
    /// Ratios of the geometric means over scenes, if there are several.
    pub over_scenes: Vec<Ratio>,
}

/// Results on one scene.
#[derive(Debug, Clone, Serialize)]
pub struct SceneReport {
    /// Its name.
    pub name: String,
    /// Hash of its content.
    pub hash: String,
    /// Size of the images.
    pub size: [u32; 2],
    /// Settings that all curves share, in words.
    pub settings: String,
    /// The reference of the errors.
    pub reference: Record,
    /// The reference's own error over the smallest error of a last point. Above a tenth the measured errors are
    /// unreliable.
    pub reference_share: Option<f64>,
    /// Curves, grouped by method, one per backend.
    pub curves: Vec<ErrorCurve>,
    /// Ratios of all pairs of curves without blind spots.
    pub ratios: Vec<Ratio>,
}

/// Ratio of the efficiencies 1 / (relMSE × processor seconds) of two curves, paired by repetition.
#[derive(Debug, Clone, Serialize)]
pub struct Ratio {
    /// Curve in the numerator.
    pub of: String,
    /// Curve in the denominator.
    pub to: String,
    /// The geometric mean over repetitions with its 95 % interval; `None` where an error is lost in the reference's
    /// noise.
    pub efficiency: Option<Interval>,
}

/// A line of `points.csv`.
#[derive(Serialize)]
struct Row<'a> {
    scene: &'a str,
    curve: &'a str,
    is_blind: bool,
    repetition: usize,
    spp: u64,
    cpu_seconds: f64,
    wall_seconds: f64,
    relmse: f64,
    rays: u64,
}

pub(super) fn report(
    request: &MethodsRequest,
    repetitions: u32,
    subjects: &[BenchScene],
    fields: &[Vec<BenchCase<'_>>],
    references: &[Reference],
) -> MethodsReport {
    let all: Vec<&[BenchCase<'_>]> = fields.iter().map(Vec::as_slice).collect();
    let scene = |((subject, field), reference): ((&BenchScene, &Vec<BenchCase<'_>>), &Reference)| {
        scene(subject, field, reference)
    };
    MethodsReport {
        conditions: Conditions::now(&request.command),
        threads: subjects.iter().flat_map(|s| &s.stages).map(|(stage, _)| stage.preparation.threads).max().unwrap_or(1),
        budget_seconds: request.budget.as_secs_f64(),
        repetitions,
        scenes: subjects.iter().zip(fields).zip(references).map(scene).collect(),
        over_scenes: if fields.len() > 1 { ratios(&all) } else { Vec::new() },
    }
}

fn scene(subject: &BenchScene, field: &[BenchCase<'_>], reference: &Reference) -> SceneReport {
    let noise = reference.record.noise.unwrap_or(0.0);
    let settings = field.first().map(|c| &c.settings);
    let word = |value: serde_json::Value| value.as_str().map(str::to_owned).unwrap_or_default();
    let words = settings.map(|s| {
        let depth = s.depth.map_or("unlimited depth".into(), |d| format!("depth {d}"));
        let (filter, sampler) = (word(serde_json::json!(s.filter)), word(serde_json::json!(s.sampler)));
        format!("{filter} filter, {depth}, {sampler} sampler in {} replicates", s.replicates)
    });
    let curves: Vec<ErrorCurve> = field.iter().map(|contestant| ErrorCurve::of(contestant, noise)).collect();
    SceneReport {
        name: subject.name.clone(),
        hash: field.first().map(|c| c.stage.scene.hash().to_owned()).unwrap_or_default(),
        size: settings.map_or([0; 2], |s| [s.width, s.height]),
        settings: words.unwrap_or_default(),
        reference: reference.record.clone(),
        reference_share: reference.record.noise.map(|noise| noise / least_error(&curves)),
        curves,
        ratios: ratios(&[field]),
    }
}

/// The smallest error of the last points of curves without blind spots; 0 if one is lost in the reference's noise.
fn least_error(curves: &[ErrorCurve]) -> f64 {
    let seeing = curves.iter().filter(|c| c.blind_spots.is_empty());
    let last = seeing.filter_map(|c| c.points.last()).map(|p| p.relmse.map_or(0.0, |e| e.value));
    last.fold(f64::INFINITY, f64::min)
}

impl SceneReport {
    /// Whether the reference is too noisy for the errors measured against it.
    pub fn is_reference_poor(&self) -> bool {
        self.reference_share.is_some_and(|share| share > SHARE)
    }
}

/// Ratios of all pairs, over the scenes in which neither has a blind spot. Pairs are matched by position, which has the
/// same meaning in every scene.
fn ratios(fields: &[&[BenchCase<'_>]]) -> Vec<Ratio> {
    let count = fields.iter().map(|field| field.len()).min().unwrap_or(0);
    let pairs = (0..count).flat_map(|a| (0..count).filter(move |&b| a != b).map(move |b| (a, b)));
    pairs.filter_map(|(a, b)| ratio(fields, a, b)).collect()
}

fn ratio(fields: &[&[BenchCase<'_>]], a: usize, b: usize) -> Option<Ratio> {
    let seeing: Vec<_> = fields.iter().map(|f| (&f[a], &f[b])).filter(|(a, b)| a.counts() && b.counts()).collect();
    let (one, other) = seeing.first()?;
    let repetition = |r: usize| {
        let log = |(a, b): &(&BenchCase<'_>, &BenchCase<'_>)| (efficiency(&a.runs[r]) / efficiency(&b.runs[r])).ln();
        (seeing.iter().map(log).sum::<f64>() / seeing.len() as f64).exp()
    };
    let repetitions = seeing.iter().map(|(a, b)| a.runs.len().min(b.runs.len())).min().unwrap_or(0);
    // The ratio of two non-positive errors may be positive, so that each error is checked.
    let is_lost = seeing.iter().flat_map(|(a, b)| a.runs.iter().chain(&b.runs)).any(|run| efficiency(run) <= 0.0);
    let efficiency = if is_lost { None } else { Interval::geometric((0..repetitions).map(repetition)) };
    Some(Ratio { of: one.label(), to: other.label(), efficiency })
}

/// Writes `report.json` and `points.csv`.
pub(super) fn write(request: &MethodsRequest, report: &MethodsReport) -> Result<()> {
    report_files::json(&request.folder.join("report.json"), report)?;
    report_files::csv(&request.folder.join("points.csv"), rows(report))
}

fn rows(report: &MethodsReport) -> impl Iterator<Item = Row<'_>> {
    let curves = report.scenes.iter().flat_map(|scene| scene.curves.iter().map(move |curve| (&scene.name, curve)));
    let runs =
        curves.flat_map(|(name, curve)| curve.runs.iter().enumerate().map(move |(r, run)| (name, curve, r, run)));
    runs.flat_map(|(scene, curve, repetition, run)| {
        run.iter().map(move |m| Row {
            scene,
            curve: &curve.label,
            is_blind: !curve.blind_spots.is_empty(),
            repetition,
            spp: m.spp,
            cpu_seconds: m.cpu_seconds,
            wall_seconds: m.wall_seconds,
            relmse: m.relmse,
            rays: m.rays,
        })
    })
}
