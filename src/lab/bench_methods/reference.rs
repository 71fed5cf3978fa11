//! Reference images: given as a file, or rendered for the benchmark.

use super::contestant::{self, BenchCase, label};
use super::{BenchScene, MethodsRequest, defect};
use crate::error::{Error, Result};
use crate::film::{Film, Plane};
use crate::integrator::{self, Method};
use crate::io::exr;
use crate::named::Named;
use crate::parallel::Cancel;
use crate::session::{Outputs, Program, RenderSettings};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// ε is the square of this fraction of the reference's mean, as in the error estimate of films.
const FLOOR: f64 = 0.1;
/// Maximum error of a rendered reference, as a fraction of the errors measured against it.
pub(super) const SHARE: f64 = 0.1;
/// Safety factor on the predicted errors. Predictions assume independent samples; low-discrepancy points mostly beat
/// them by less than this factor at the sample counts of a curve. The report states the ratio achieved.
const MARGIN: f64 = 2.0;
/// Repetition number for the seeds of rendered references, used by no repetition.
const SEED: u32 = u32::MAX;

/// A reference image.
pub(super) struct Reference {
    /// Its pixels, 3 values each.
    pub(super) rgb: Vec<f32>,
    /// Origin and quality of the image.
    pub(super) record: Record,
}

/// Origin and quality of a reference.
#[derive(Debug, Clone, Serialize)]
pub struct Record {
    /// Its file.
    pub file: PathBuf,
    /// The program or method that made it.
    pub origin: String,
    /// The ε of relMSE, (0.1 × its mean)².
    pub epsilon: f64,
    /// Its own relMSE, which is subtracted from measured errors; `None` if unknown and not subtracted.
    pub noise: Option<f64>,
    /// Whether the time limit ended the rendering before its relMSE was a tenth of the predicted errors.
    pub is_cut_short: bool,
}

impl Reference {
    /// Reads the reference given for a subject, if any.
    pub(super) fn given(subject: &BenchScene) -> Result<Option<Reference>> {
        let Some((path, noise)) = &subject.reference else { return Ok(None) };
        let (_, job) = subject.stages.first().ok_or_else(|| defect("a scene without a backend"))?;
        let mut reference = Reference::read(path, &job.settings)?;
        reference.record.noise = noise.or(reference.record.noise);
        Ok(Some(reference))
    }

    fn read(path: &Path, settings: &RenderSettings) -> Result<Reference> {
        let image = exr::read(path)?;
        let crop = image.crop;
        let size = [image.width, image.height];
        if size != [settings.width, settings.height] || settings.layout().crop != crop {
            let (w, h) = (settings.width, settings.height);
            let what =
                format!("the reference {} is {}×{} and the images are {w}×{h}", path.display(), size[0], size[1]);
            return Err(Error::usage(format!("{what}: use --size {}x{}", size[0], size[1])));
        }
        let channels = |names: [&str; 3]| {
            let [r, g, b] = names.map(|name| image.channel(name));
            let (r, g, b) = (r?, g?, b?);
            Some(r.iter().zip(g).zip(b).flat_map(|((&r, &g), &b)| [r, g, b]).collect::<Vec<f32>>())
        };
        let missing = || Error::usage(format!("the reference {} has no channels R, G and B", path.display()));
        let rgb = channels(["R", "G", "B"]).ok_or_else(missing)?;
        let epsilon = epsilon(&rgb);
        let noise = channels(["stderr.R", "stderr.G", "stderr.B"]).map(|stderr| noise(&rgb, &stderr, epsilon));
        let origin = if noise.is_some() { "given, with its standard error" } else { "given" };
        let record = Record { file: path.into(), origin: origin.into(), epsilon, noise, is_cut_short: false };
        Ok(Reference { rgb, record })
    }
}

fn epsilon(rgb: &[f32]) -> f64 {
    let finite = rgb.iter().copied().map(f64::from).filter(|v| v.is_finite());
    let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
    // A black image has no scale: any ε will do.
    let mean: f64 = if sum > 0.0 { sum / count } else { 1.0 };
    (FLOOR * mean).powi(2)
}

/// relMSE of an image according to its standard error.
fn noise(rgb: &[f32], stderr: &[f32], epsilon: f64) -> f64 {
    let terms = rgb.iter().zip(stderr).map(|(&v, &s)| f64::from(s).powi(2) / (f64::from(v).powi(2) + epsilon));
    let (sum, count) = terms.filter(|t| t.is_finite()).fold((0.0, 0.0), |(sum, count), t| (sum + t, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}

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
    // From the simplest method to the best. Methods with chains are excluded, since their error estimate may be in
    // doubt.
    let seeing: Vec<Method> = Method::all()
        .iter()
        .copied()
        .filter(|&m| !m.has_chains() && integrator::blind_spots(m, &host.stage.scene).is_empty())
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
        let epsilon = epsilon(&rgb);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_what_the_standard_error_says() {
        // (0.1² / (1 + ε) + 0 + 0.2² / (4 + ε)) / 3 with ε = (0.1 × 1)².
        let (rgb, stderr) = ([1.0, 0.0, 2.0], [0.1, 0.0, 0.2]);
        let epsilon = epsilon(&rgb);
        assert!((epsilon - 0.01).abs() < 1e-15, "rounding");
        let exact = (0.01 / 1.01 + 0.04 / 4.01) / 3.0;
        assert!((noise(&rgb, &stderr, epsilon) / exact - 1.0).abs() < 1e-6, "0.1 and 0.2 as f32");
        assert_eq!(noise(&[f32::NAN; 3], &stderr, epsilon).to_bits(), 0);
    }
}
