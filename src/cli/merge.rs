//! `etendue merge`: merges films of one picture into one image or film.

use super::args::{OutputArgs, ThreadArgs};
use super::{Console, finish, startup};
use crate::error::{Error, Result};
use crate::session::merge::{Gaps, merge};
use crate::session::{LoadedScene, PassSelection, Provenance, Rendered, images, picture_name};
use std::path::PathBuf;

/// Arguments of `merge`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The films, in any order
    #[arg(required = true)]
    films: Vec<PathBuf>,
    /// Accept missing passes: the picture is noisier than planned
    #[arg(long)]
    allow_gaps: bool,
    #[command(flatten)]
    output: OutputArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    #[command(flatten)]
    console: Console,
}

/// Merges films.
pub(super) fn run(args: Args) -> Result<()> {
    startup::start_threads(args.threads)?;
    let gaps = if args.allow_gaps { Gaps::Allow } else { Gaps::Refuse };
    let (provenance, film) = merge(&args.films, gaps)?;
    let outputs = args.output.outputs(&picture_name(&provenance.scene.path), PassSelection::All)?;
    args.output.check(&outputs)?;
    let ids = if outputs.exr.is_some() { ids(&provenance)? } else { None };
    let report = Rendered { provenance, film, ids, preparation: None, check: None }.write(&outputs)?;
    finish::tell(&report, finish::Files { outputs: &outputs, report: args.output.report.as_deref() }, args.console)
}

/// Computes the instance and material indices. They are not in films and come from the scene, which must be the same.
fn ids(provenance: &Provenance) -> Result<Option<images::Ids>> {
    let (path, overrides, settings) = (&provenance.scene.path, provenance.scene.overrides(), &provenance.settings);
    if !images::needs_ids(&settings.aovs) {
        return Ok(None);
    }
    let options = settings.build_options(rayon::current_num_threads());
    let stage = LoadedScene::open(path, overrides, &settings.moment(), &options)?;
    if stage.scene.hash() != provenance.scene.hash {
        return Err(Error::usage(format!("{} is not the scene of these films any more", path.display())));
    }
    images::ids(&stage, settings)
}
