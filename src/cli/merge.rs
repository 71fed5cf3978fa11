//! `etendue merge`: films of one picture become one image or film.

use super::args::{OutputArgs, ThreadArgs};
use super::{Console, finish, startup};
use crate::error::{Error, Result};
use crate::render::merge::{Gaps, merge};
use crate::render::{Provenance, Rendered, Selection, Stage, images, picture_name};
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
    threads: ThreadArgs,
    #[command(flatten)]
    console: Console,
}

/// Merges.
pub(super) fn run(args: Args) -> Result<()> {
    startup::start_threads(args.threads)?;
    let gaps = if args.allow_gaps { Gaps::Allow } else { Gaps::Refuse };
    let (provenance, film) = merge(&args.films, gaps)?;
    let outputs = args.output.outputs(&picture_name(&provenance.scene.path), Selection::All)?;
    args.output.check(&outputs)?;
    let ids = if outputs.exr.is_some() { ids(&provenance)? } else { None };
    let report = Rendered { provenance, film, ids, preparation: None, check: None }.write(&outputs)?;
    finish::tell(&report, finish::Files { outputs: &outputs, report: args.output.report.as_deref() }, args.console)
}

/// Instance and material numbers are not in films: they come from the scene, which must be the same.
fn ids(provenance: &Provenance) -> Result<Option<images::Ids>> {
    let (path, surroundings, settings) = (&provenance.scene.path, provenance.scene.surroundings.clone(), &provenance.settings);
    if !images::needs_ids(&settings.aovs) {
        return Ok(None);
    }
    let options = settings.build_options(rayon::current_num_threads());
    let stage = Stage::open(path, surroundings, &settings.moment(), &options)?;
    if stage.scene.hash() != provenance.scene.hash {
        return Err(Error::usage(format!("{} is not the scene of these films any more", path.display())));
    }
    images::ids(&stage, settings)
}
