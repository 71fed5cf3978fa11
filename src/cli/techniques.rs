//! `--techniques` of `etendue render`: what each technique of bidirectional path tracing finds on its own, from the passes that the
//! image has been made of.

use super::Console;
use super::progress::Meter;
use crate::error::{Error, Result};
use crate::integrator::Method;
use crate::parallel::Cancel;
use crate::render::techniques::{self, TechniqueFiles};
use crate::render::{Ended, Outputs, Session};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Scattering events of the longest paths where nothing is said: 13 images, of which all are worth looking at.
const DEFAULT_DEPTH: u32 = 3;

/// Which images of techniques are written.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Files")]
pub(super) struct TechniqueArgs {
    /// Write what each technique of bdpt finds on its own, weighted and not, as layers of this .exr, and a sheet of them as .png
    /// beside it; takes about as long as the image
    #[arg(long, value_name = "PATH", conflicts_with_all = ["shard", "passes"])]
    techniques: Option<PathBuf>,
    /// Longest paths in there, in scattering events [default: 3]
    #[arg(long, value_name = "EVENTS", requires = "techniques", value_parser = clap::value_parser!(u32).range(0..=16))]
    techniques_depth: Option<u32>,
}

impl TechniqueArgs {
    /// The files to write beside `outputs` for a render by `method`, if any.
    pub(super) fn files(&self, method: Method, outputs: &Outputs) -> Result<Option<TechniqueFiles>> {
        let Some(path) = &self.techniques else { return Ok(None) };
        if method != Method::Bdpt {
            return Err(Error::usage("--techniques: only bidirectional path tracing has them: use --method bdpt"));
        }
        let files = TechniqueFiles::of(path)?;
        if let Some(both) = files.paths().find(|path| outputs.paths().any(|output| output == *path)) {
            return Err(Error::usage(format!("--techniques: {} is the render's own output", both.display())));
        }
        files.paths().try_for_each(crate::render::writable)?;
        Ok(Some(files))
    }

    /// Renders and writes them.
    pub(super) fn write(
        &self,
        files: &TechniqueFiles,
        session: &Session<'_>,
        cancel: &Cancel,
        console: Console,
    ) -> Result<Ended> {
        let deepest = self.techniques_depth.unwrap_or(DEFAULT_DEPTH);
        console.note(&format!("rendering the techniques of paths of up to {deepest} scattering events"));
        let (mut meter, begun) = (Meter::new(console), Instant::now());
        let watch = |done: f64| {
            let left = Duration::try_from_secs_f64(begun.elapsed().as_secs_f64() * (1.0 - done) / done).unwrap_or_default();
            meter.show(done, left, || "techniques, ".into());
        };
        let Some(images) = session.techniques(deepest, cancel, watch)? else { return Ok(Ended::Interrupted) };
        techniques::write(files, session.provenance(), &images)?;
        drop(meter);
        if images.report.guards.nonfinite > 0 {
            console.warn(&format!("{} samples of techniques were not finite", images.report.guards.nonfinite));
        }
        let [exr, png] = [&files.exr, &files.png].map(|path| path.display());
        console.line(&format!("techniques: {exr}, {png}"))?;
        Ok(Ended::Complete)
    }
}
