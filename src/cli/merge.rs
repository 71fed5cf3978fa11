//! `etendue merge`: films of one picture become one image or film.

use super::args::OutputArgs;
use super::{Console, finish};
use crate::error::{Error, Result};
use crate::integrator;
use crate::render::merge::{Gaps, merge};
use crate::render::{Provenance, Report, Selection, Stage, checkpoint, images, picture_name};
use std::path::PathBuf;

/// Arguments of `merge`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The films, in any order
    #[arg(required = true)]
    films: Vec<PathBuf>,
    /// Accept that passes are missing: the picture is noisier than it was meant to be
    #[arg(long)]
    allow_gaps: bool,
    #[command(flatten)]
    output: OutputArgs,
    #[command(flatten)]
    console: Console,
}

/// Merges.
pub(super) fn run(args: Args) -> Result<()> {
    let gaps = if args.allow_gaps { Gaps::Allow } else { Gaps::Refuse };
    let (provenance, film) = merge(&args.films, gaps)?;
    let outputs = args.output.outputs(&picture_name(&provenance.scene.path), Selection::All)?;
    args.output.check(&outputs)?;
    let ids = match &outputs.exr {
        Some(_) if images::needs_ids(&provenance.settings.aovs) => Some(ids(&provenance)?),
        _ => None,
    };
    if let Some(path) = &outputs.film {
        checkpoint::save(path, &provenance, &film)?;
    }
    let layers = images::layers(&provenance, &film, ids.as_ref());
    let report = Report::new(&provenance, &film, &layers, &outputs, None);
    images::write(&outputs, &provenance, &film, &layers, &report)?;
    finish::tell(&report, finish::Files { outputs: &outputs, report: args.output.report.as_deref() }, args.console)
}

/// Instance and material numbers are not in films: they come from the scene, which must be the same.
fn ids(provenance: &Provenance) -> Result<images::Ids> {
    let (path, surroundings, settings) = (&provenance.scene.path, provenance.scene.surroundings.clone(), &provenance.settings);
    let options = settings.build_options(rayon::current_num_threads());
    let stage = Stage::open(path, surroundings, settings.frame, &options)?;
    if stage.scene.hash() != provenance.scene.hash {
        return Err(Error::usage(format!("{} is not the scene of these films any more", path.display())));
    }
    let camera = stage.scene.camera(settings.camera.as_deref(), settings.width, settings.height)?;
    Ok(integrator::ids(&stage.scene, &camera, &settings.layout()))
}
