//! `--techniques` of `etendue render`: writes the contribution of each technique of bidirectional path tracing, from
//! the passes of the image.

use super::Console;
use super::progress::Meter;
use crate::error::{Error, Result};
use crate::integrator::Method;
use crate::lab::techniques::{self, TechniqueFiles};
use crate::parallel::Cancel;
use crate::session::{Ended, Outputs, Session};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Default of the longest paths, in scattering events. It gives 13 images, all of them informative.
const DEFAULT_DEPTH: u32 = 3;

/// Output of technique images.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Files")]
pub(super) struct TechniqueArgs {
    /// Write the contribution of each technique of bdpt, weighted and unweighted, as layers of this .exr, and a sheet
    /// of them as .png beside it; takes about as long as the image
    #[arg(long, value_name = "PATH", conflicts_with_all = ["shard", "passes"])]
    techniques: Option<PathBuf>,
    /// Longest paths of these techniques, in scattering events [default: 3]
    #[arg(long, value_name = "EVENTS", requires = "techniques", value_parser = clap::value_parser!(u32).range(0..=16))]
    techniques_depth: Option<u32>,
}

impl TechniqueArgs {
    /// Returns the files to write beside `outputs` for a render by `method`, if any.
    pub(super) fn files(&self, method: Method, outputs: &Outputs) -> Result<Option<TechniqueFiles>> {
        let Some(path) = &self.techniques else { return Ok(None) };
        if method != Method::Bdpt {
            return Err(Error::usage("--techniques: only bidirectional path tracing has them: use --method bdpt"));
        }
        let files = TechniqueFiles::of(path)?;
        if let Some(both) = files.paths().find(|path| outputs.paths().any(|output| output == *path)) {
            return Err(Error::usage(format!("--techniques: {} is the render's own output", both.display())));
        }
        files.paths().try_for_each(crate::session::writable)?;
        Ok(Some(files))
    }

    /// Renders and writes the technique images.
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
            let left =
                Duration::try_from_secs_f64(begun.elapsed().as_secs_f64() * (1.0 - done) / done).unwrap_or_default();
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
