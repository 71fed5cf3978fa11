//! Rendering of references for the benchmark.

use super::contestant::{self, BenchCase, label};
use super::reference::{Record, Reference, noise};
use super::{BenchScene, MethodsRequest};
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
    let (host, method) = chosen(request, field)?;
    let seed = contestant::seed(host.settings.seed, SEED);
    let settings = RenderSettings { method: method.into(), seed, aovs: Vec::new(), ..host.settings.clone() };
    let name = label(&settings);
    let same = if request.methods.contains(&method) { ", also compared, with another seed" } else { "" };
    let origin = format!("made by {name}{same}");
    let suffices = |r: &Reference| r.record.noise.is_some_and(|noise| suffices(field, &r.rgb, noise, r.record.epsilon));
    if let Some(kept) = kept(&path, &settings, host).filter(suffices) {
        note(&format!("{}: taking {}", subject.name, path.display()));
        return Ok(Reference { record: Record { origin, ..kept.record }, ..kept });
    }
    note(&format!("{}: making a reference by {name}{same}", subject.name));
    render(request, &settings, host, field, &path)?;
    let made = Reference::read(&path, &settings)?;
    let is_cut_short = !suffices(&made);
    if is_cut_short {
        note(&format!("warning: {}: time was over before the reference was good enough", subject.name));
    }
    Ok(Reference { record: Record { origin, is_cut_short, ..made.record }, ..made })
}

/// Whether a reference with error `noise` is accurate enough for the predicted errors of the images.
fn suffices(field: &[BenchCase<'_>], rgb: &[f32], noise: f64, epsilon: f64) -> bool {
    let least =
        field.iter().filter(|c| c.counts()).map(|c| c.foretold(rgb, noise, epsilon)).fold(f64::INFINITY, f64::min);
    noise <= SHARE * least / MARGIN
}

/// Chooses the method of the reference: one without blind spots that is not compared, else the last without blind
/// spots.
fn chosen<'a, 'b>(request: &MethodsRequest, field: &'a [BenchCase<'b>]) -> Result<(&'a BenchCase<'b>, Method)> {
    let host = field.first().ok_or_else(|| Error::usage("nothing to compare: name a method and a backend"))?;
    // From the simplest method to the best. Methods whose pixels share their noise are excluded, since their error
    // estimate may be in doubt.
    let seeing: Vec<Method> = Method::all()
        .iter()
        .copied()
        .filter(|&m| {
            m.independent() != Independent::Replicates && integrator::blind_spots(m, &host.stage.scene).is_empty()
        })
        .collect();
    let other = seeing.iter().rev().find(|m| !request.methods.contains(m));
    let method =
        other.or(seeing.last()).ok_or_else(|| Error::usage("no method sees all of the scene: give a --reference"))?;
    Ok((host, *method))
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
        let epsilon = relmse_epsilon(&rgb);
        let noise = film.standard_error().map_or(f64::INFINITY, |stderr| noise(&rgb, &stderr, epsilon));
        // Another doubling takes as long as all samples so far.
        if suffices(field, &rgb, noise, epsilon) || 2 * start.elapsed() > request.reference_budget {
            cancel.request();
        }
        0.0
    };
    let (session, _) = contestant::render(host.stage, settings, super::MOST_DOUBLINGS, &cancel, judge)?;
    session.end()?.write(&Outputs { exr: Some(path.into()), ..Outputs::default() }).map(drop)
}
