//! The end of a render: files, report, last lines, exit class.

use super::args::StrictArgs;
use super::{Console, console};
use crate::error::{Error, Kind, Result};
use crate::film::ImageError;
use crate::io::atomic::write_atomically;
use crate::render::{Ended, Outputs, Report, Session, Stage, images};
use std::io::Write;
use std::path::Path;

/// Where results go.
#[derive(Debug, Clone, Copy)]
pub(super) struct Files<'a> {
    /// Images and film.
    pub(super) outputs: &'a Outputs,
    /// The report.
    pub(super) report: Option<&'a Path>,
}

/// Ends a session: a whole one with its images, a stopped one with a film to resume.
pub(super) fn session(
    session: &Session<'_>,
    stage: &Stage,
    ended: Ended,
    files: Files<'_>,
    strict: StrictArgs,
    console: Console,
) -> Result<Report> {
    if ended == Ended::Interrupted {
        return Err(stopped(session, files.outputs)?);
    }
    if let Some(path) = &files.outputs.film {
        session.save(path)?;
    }
    let ids = match &files.outputs.exr {
        Some(_) if images::needs_ids(&session.provenance().settings.aovs) => Some(session.ids()?),
        _ => None,
    };
    let layers = images::layers(session.provenance(), session.film(), ids.as_ref());
    let report = Report::new(session.provenance(), session.film(), &layers, files.outputs, Some(stage));
    let report = report.with_target(session.target_check());
    images::write(files.outputs, session.provenance(), session.film(), &layers, &report)?;
    complain(&report, console);
    tell(&report, files, console)?;
    if strict.require_target && !report.target().is_some_and(|target| target.reached) {
        return Err(Error::new(Kind::TargetMissed, report.target_missed().unwrap_or_default()));
    }
    if strict.fail_on_nonfinite && report.guards().nonfinite > 0 {
        let replay = report.first_replay().unwrap_or_default();
        let what = format!("{} samples were not finite; trace the first again with {replay}", report.guards().nonfinite);
        return Err(Error::new(Kind::NonFinite, what));
    }
    Ok(report)
}

/// Writes the report and prints the result; the image is the last line.
pub(super) fn tell(report: &Report, files: Files<'_>, console: Console) -> Result<()> {
    if let Some(path) = files.report {
        let text = console::pretty(report)? + "\n";
        write_atomically(path, |file| file.write_all(text.as_bytes()))?;
    }
    console.document(report)?;
    console.line(&report.summary())?;
    if let Some(film) = &files.outputs.film {
        console.line(&format!("film: {}", film.display()))?;
    }
    match files.outputs.image() {
        Some(image) => console.line(&format!("image: {}", image.display())),
        None => Ok(()),
    }
}

/// Saves what there is and says how to go on.
fn stopped(session: &Session<'_>, outputs: &Outputs) -> Result<Error> {
    let done = session.film().passes().len();
    let Some(path) = outputs.checkpoint() else {
        return Ok(Error::new(Kind::Internal, "stopped by a signal, with nowhere to save the film"));
    };
    session.save(&path)?;
    let (path, image) = (path.display(), outputs.image().map(|i| format!(" -o {}", i.display())).unwrap_or_default());
    let what = format!("stopped by a signal after {done} samples per pixel; go on with: etendue resume {path}{image}");
    Ok(Error::new(Kind::Interrupted, what))
}

/// Warns about everything that guards changed.
fn complain(report: &Report, console: Console) {
    let guards = report.guards();
    if guards.nonfinite > 0 {
        let replay = report.first_replay().unwrap_or_default();
        console.warn(&format!("{} samples were not finite and count as black; the first: {replay}", guards.nonfinite));
    }
    if guards.overlong_paths > 0 {
        console.warn(&format!("{} paths reached the emergency length limit and were cut", guards.overlong_paths));
    }
    if let Some(why) = report.error().and_then(ImageError::distrust) {
        console.warn(&format!("{why}: the interval of relMSE is not to be trusted"));
    }
    report.doubts_of_chains().iter().for_each(|doubt| console.warn(doubt));
    if let Some(missed) = report.target_missed() {
        console.warn(&missed);
    }
    if let Some(clamp) = report.clamp() {
        let (limit, samples, share) = (clamp.limit, clamp.samples, clamp.share_removed * 100.0);
        console.warn(&format!("biased: --clamp {limit} changed {samples} samples and took {share:.3} % of the light"));
    }
}
