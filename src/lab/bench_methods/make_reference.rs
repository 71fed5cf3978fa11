//! Rendering of references for the benchmark.

use super::contestant::{self, BenchCase, label};
use super::reference::{Record, Reference, noise};
use super::{BenchScene, MethodsRequest, defect};
use crate::error::{Error, Result};
use crate::film::{Film, Independent, Plane};
use crate::integrator::{self, Method};
use crate::io::exr;
use crate::lab::image::relmse_epsilon;
use crate::named::Named;
use crate::parallel::Cancel;
use crate::session::{Outputs, Program, RenderSettings};
use std::path::Path;
use std::time::Instant;

/// Maximum error of a rendered reference, as a fraction of the errors measured against it.
pub(super) const SHARE: f64 = 0.1;
/// Safety factor on the predicted errors. Predictions assume independent samples; low-discrepancy points mostly beat
/// them by less than this factor at the sample counts of a curve. The report states the ratio achieved.
const MARGIN: f64 = 2.0;
/// Fraction of the time for a reference that each method gets to show its pace.
const TRIAL: f64 = 1.0 / 64.0;
/// How many times longer a reference may take that is made by a method that is not compared. Such a reference shows a
/// systematic error of the compared methods.
const WORTH: f64 = 8.0;
/// Repetition number for the seeds of rendered references, used by no repetition.
const SEED: u32 = u32::MAX;

/// Returns the reference that an earlier call left in the folder if it matches, else renders a new one.
pub(super) fn make(
    request: &MethodsRequest,
    subject: &BenchScene,
    field: &[BenchCase<'_>],
    note: &mut dyn FnMut(&str),
) -> Result<Reference> {
    let path = request.folder.join(format!("reference-{}.exr", subject.name));
    let host = field.first().ok_or_else(|| Error::usage("nothing to compare: name a method and a backend"))?;
    let able = candidates(host)?;
    let suffices = |r: &Reference| r.record.noise.is_some_and(|noise| suffices(field, &r.rgb, noise, r.record.epsilon));
    let origin = |candidate: &RenderSettings| {
        let also = if is_compared(request, candidate) { ", also compared, with another seed" } else { "" };
        format!("made by {}{also}", label(candidate))
    };
    for candidate in &able {
        if let Some(kept) = kept(&path, candidate, host).filter(suffices) {
            note(&format!("{}: taking {}", subject.name, path.display()));
            return Ok(Reference { record: Record { origin: origin(candidate), ..kept.record }, ..kept });
        }
    }
    let settings = chosen(request, able, host)?;
    let origin = origin(&settings);
    note(&format!("{}: a reference is {origin}", subject.name));
    render(request, &settings, host, field, &path)?;
    let made = Reference::read(&path, &settings)?;
    let is_cut_short = !suffices(&made);
    if is_cut_short {
        note(&format!("warning: {}: time was over before the reference was good enough", subject.name));
    }
    Ok(Reference { record: Record { origin, is_cut_short, ..made.record }, ..made })
}

fn is_compared(request: &MethodsRequest, settings: &RenderSettings) -> bool {
    request.methods.contains(&settings.method.kind())
}

/// Whether a reference with error `noise` is accurate enough for the predicted errors of the images.
fn suffices(field: &[BenchCase<'_>], rgb: &[f32], noise: f64, epsilon: f64) -> bool {
    let least =
        field.iter().filter(|c| c.counts()).map(|c| c.foretold(rgb, noise, epsilon)).fold(f64::INFINITY, f64::min);
    noise <= SHARE * least / MARGIN
}

/// Returns the settings of all methods that can make a reference: those without blind spots whose pixels have errors of
/// their own. Where pixels share their noise, the error estimate may be in doubt. Methods that find lamps or pixels by
/// luck alone do it where no other can: pixels that nothing has met seem to have no error.
fn candidates(host: &BenchCase<'_>) -> Result<Vec<RenderSettings>> {
    let is_able = |m: Method| {
        let scene = &host.stage.scene;
        m.independent() != Independent::Replicates && integrator::blind_spots(m, scene).is_empty()
    };
    let seed = contestant::seed(host.settings.seed, SEED);
    let settings = |&m: &Method| RenderSettings { method: m.into(), seed, aovs: Vec::new(), ..host.settings.clone() };
    let (by_luck, able): (Vec<Method>, Vec<Method>) =
        Method::all().iter().filter(|&&m| is_able(m)).partition(|m| matches!(m, Method::Light | Method::PathNaive));
    let makers = if able.is_empty() { by_luck } else { able };
    if makers.is_empty() {
        return Err(Error::usage("no method sees all of the scene: give a --reference"));
    }
    Ok(makers.iter().map(settings).collect())
}

/// Chooses the fastest of `able`. A method that is not compared is preferred unless it takes [`WORTH`] times as long.
fn chosen(request: &MethodsRequest, able: Vec<RenderSettings>, host: &BenchCase<'_>) -> Result<RenderSettings> {
    let mut trials = Vec::new();
    for settings in able {
        let handicap = if is_compared(request, &settings) { WORTH } else { 1.0 };
        trials.push((trial(request, &settings, host)? * handicap, settings));
    }
    let fastest = trials.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    fastest.map(|(_, settings)| settings).ok_or_else(|| defect("no method to make a reference by"))
}

/// Renders for [`TRIAL`] of the time and returns relMSE × seconds.
fn trial(request: &MethodsRequest, settings: &RenderSettings, host: &BenchCase<'_>) -> Result<f64> {
    let (cancel, start) = (Cancel::new(), Instant::now());
    let judge = |film: &Film, _| {
        if 2 * start.elapsed() > request.reference_budget.mul_f64(TRIAL) {
            cancel.request();
        }
        own_error(film)
    };
    let (_, marks) = contestant::render(host.stage, settings, super::MOST_DOUBLINGS, &cancel, judge)?;
    let last = marks.last().ok_or_else(|| defect("a trial without a pass"))?;
    // A film without light knows no error.
    Ok(if last.relmse > 0.0 { last.relmse * last.cpu_seconds } else { f64::INFINITY })
}

/// relMSE of a film according to its standard error.
fn own_error(film: &Film) -> f64 {
    let rgb = film.mean(Plane::Color);
    film.standard_error().map_or(f64::INFINITY, |stderr| noise(&rgb, &stderr, relmse_epsilon(&rgb)))
}

/// Reads the reference of an earlier call, if scene, program and settings match.
fn kept(path: &Path, settings: &RenderSettings, host: &BenchCase<'_>) -> Option<Reference> {
    let image = exr::read(path).ok()?;
    let program = Program::current();
    let wanted = [
        ("etendue.settings_hash", Some(settings.hash())),
        ("etendue.scene.hash", Some(host.stage.scene.hash().to_owned())),
        ("etendue.program.version", Some(program.version)),
        ("etendue.program.revision", program.revision),
    ];
    let has = |(name, value): &(&str, Option<String>)| {
        image.attributes.get(*name) == value.clone().map(exr::Attribute::Text).as_ref()
    };
    if wanted.iter().all(has) { Reference::read(path, settings).ok() } else { None }
}

/// Renders until the reference is accurate enough or the time is over.
fn render(
    request: &MethodsRequest,
    settings: &RenderSettings,
    host: &BenchCase<'_>,
    field: &[BenchCase<'_>],
    path: &Path,
) -> Result<()> {
    let (cancel, start) = (Cancel::new(), Instant::now());
    let judge = |film: &Film, _| {
        let rgb = film.mean(Plane::Color);
        // Another doubling takes as long as all samples so far.
        if suffices(field, &rgb, own_error(film), relmse_epsilon(&rgb))
            || 2 * start.elapsed() > request.reference_budget
        {
            cancel.request();
        }
        0.0
    };
    let (session, _) = contestant::render(host.stage, settings, super::MOST_DOUBLINGS, &cancel, judge)?;
    session.end()?.write(&Outputs { exr: Some(path.into()), ..Outputs::default() }).map(drop)
}
