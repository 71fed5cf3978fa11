//! The end of a render: files, report, final output and exit code.

use super::args::StrictArgs;
use super::{Console, console};
use crate::error::{Error, Kind, Result};
use crate::film::ImageError;
use crate::io::atomic::write_atomically;
use crate::session::{Ended, Outputs, RenderReport, Rendered, checkpoint, picture_name};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Paths of the results.
#[derive(Debug, Clone, Copy)]
pub(super) struct Files<'a> {
    /// Images and film.
    pub(super) outputs: &'a Outputs,
    /// The report.
    pub(super) report: Option<&'a Path>,
}

/// Ends a session. A complete one writes its images, a stopped one a film to resume.
pub(super) fn session(
    rendered: &Rendered,
    ended: Ended,
    files: Files<'_>,
    strict: StrictArgs,
    console: Console,
) -> Result<RenderReport> {
    if ended == Ended::Interrupted {
        return Err(stopped(rendered, files.outputs));
    }
    let report = rendered.write(files.outputs).map_err(|error| rescued(rendered, files.outputs, error))?;
    complain(&report, files.outputs, console);
    tell(&report, files, console)?;
    if strict.require_target && !report.target().is_some_and(|target| target.reached) {
        return Err(Error::new(Kind::TargetMissed, report.target_missed().unwrap_or_default()));
    }
    if strict.fail_on_nonfinite && report.guards().nonfinite > 0 {
        let replay = report.first_replay().unwrap_or_default();
        let what =
            format!("{} samples were not finite; trace the first again with {replay}", report.guards().nonfinite);
        return Err(Error::new(Kind::NonFinite, what));
    }
    Ok(report)
}

/// Writes the report and prints the result. The image's path is the last line.
pub(super) fn tell(report: &RenderReport, files: Files<'_>, console: Console) -> Result<()> {
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

/// Saves the film of a stopped render. The error tells how to continue.
fn stopped(rendered: &Rendered, outputs: &Outputs) -> Error {
    let done = rendered.film.passes().len();
    let Some(path) = outputs.checkpoint() else {
        return Error::new(Kind::Internal, "stopped by a signal, with nowhere to save the film");
    };
    if let Err(error) = rendered.save(&path) {
        return rescued(rendered, outputs, error);
    }
    let (path, image) = (path.display(), outputs.image().map(|i| format!(" -o {}", i.display())).unwrap_or_default());
    let what = format!("stopped by a signal after {done} samples per pixel; go on with: etendue resume {path}{image}");
    Error::new(Kind::Interrupted, what)
}

/// Saves the film elsewhere if its folder is gone or full. The error tells where.
fn rescued(rendered: &Rendered, outputs: &Outputs, error: Error) -> Error {
    let (Kind::Output, Some(beside)) = (error.kind, outputs.checkpoint()) else { return error };
    let is_there = |path: &PathBuf| checkpoint::open(path).is_ok_and(|(_, film)| film.head() == rendered.film.head());
    let mut name = picture_name(&beside);
    name.push(format!(".{}.film", &rendered.provenance.identity()[..8]));
    let elsewhere = [std::env::current_dir().ok(), Some(std::env::temp_dir())]
        .into_iter()
        .flatten()
        .map(|folder| folder.join(&name));
    let kept = Some(beside).filter(is_there).or_else(|| elsewhere.into_iter().find(|path| rendered.save(path).is_ok()));
    match kept {
        Some(path) => {
            let image = outputs.image().map(|image| format!(" -o {}", image.display())).unwrap_or_default();
            let what = format!("{}; nothing is lost: etendue resume {}{image}", error.chain(), path.display());
            Error::new(Kind::Output, what)
        }
        None => error,
    }
}

/// Warns about everything unexpected in the picture. Warnings name the picture, since others may be rendered by now.
fn complain(report: &RenderReport, outputs: &Outputs, console: Console) {
    let which =
        outputs.image().or(outputs.film.as_deref()).map(|path| format!("{}: ", path.display())).unwrap_or_default();
    let warn = |text: &str| console.warn(&format!("{which}{text}"));
    let guards = report.guards();
    if guards.nonfinite > 0 {
        let replay = report.first_replay().unwrap_or_default();
        warn(&format!("{} samples were not finite and count as black; the first: {replay}", guards.nonfinite));
    }
    if guards.overlong_paths > 0 {
        warn(&format!("{} paths reached the emergency length limit and were cut", guards.overlong_paths));
    }
    if let Some(why) = report.error().and_then(ImageError::distrust) {
        warn(&format!("{why}: the interval of relMSE is not to be trusted"));
    }
    report.doubts_of_chains().iter().for_each(|doubt| warn(doubt));
    if let Some(missed) = report.target_missed() {
        warn(&missed);
    }
    if let Some(clamp) = report.clamp() {
        let (limit, samples, share) = (clamp.limit, clamp.samples, clamp.share_removed * 100.0);
        let setting = clamp.setting;
        warn(&format!("biased: --{setting} {limit} changed {samples} samples and took {share:.3} % of the light"));
    }
}
