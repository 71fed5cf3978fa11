//! `etendue resume`: continues a film as if it had never stopped.

use super::args::{KeepArgs, OutputArgs, StrictArgs, ThreadArgs};
use super::progress::ProgressArgs;
use super::signals::Signals;
use super::{Console, startup, task};
use crate::error::{Error, Result};
use crate::session::{
    Budget, EnvironmentChoice, LoadedScene, Outputs, Overrides, PassPlan, PassSelection, Session, SettingsPatch,
    Surroundings, checkpoint,
};
use std::path::{Path, PathBuf};

/// Arguments of `resume`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The film to continue; it is updated
    film_file: PathBuf,
    /// Samples per pixel wanted in all [default: the film's own run says when it is done]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1 << 30))]
    spp: Option<u32>,
    /// Render for this much longer at most, e.g. 30s or 5m
    #[arg(long, value_name = "TIME")]
    time: Option<Budget>,
    /// Stop once the relative mean squared error is below this with 95 % confidence, e.g. 1e-3
    #[arg(long, value_name = "RELMSE", allow_negative_numbers = true)]
    target_error: Option<f64>,
    /// The scene, if its file has moved
    #[arg(long, value_name = "PATH")]
    scene: Option<PathBuf>,
    /// The environment's file, if it has moved
    #[arg(long, value_name = "FILE")]
    env: Option<PathBuf>,
    #[command(flatten)]
    output: OutputArgs,
    #[command(flatten)]
    strict: StrictArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    #[command(flatten)]
    progress: ProgressArgs,
    #[command(flatten)]
    console: Console,
}

/// Resumes a film.
pub(super) fn run(args: Args) -> Result<()> {
    let console = args.console;
    let threads = startup::start_threads(args.threads)?;
    let (mut provenance, film) = checkpoint::restore(&args.film_file)?;
    provenance.plan = plan(&args, provenance.plan, provenance.settings.replicates)?;
    args.strict.check(&provenance.plan)?;
    task::note_rounding(console, args.spp, provenance.plan, provenance.settings.replicates);
    let outputs = outputs(&args)?;
    args.output.check(&outputs)?;
    let signals = Signals::heed()?;
    let path = args.scene.clone().unwrap_or_else(|| provenance.scene.path.clone());
    let overrides = provenance.scene.overrides();
    let surroundings = surroundings(overrides.surroundings, args.env.clone())?;
    let stage = LoadedScene::open(
        &path,
        Overrides { surroundings, ..overrides },
        &provenance.settings.moment(),
        &provenance.settings.build_options(threads),
    )?;
    if args.strict.strict {
        stage.refuse_ignored()?;
    }
    provenance.scene.path = std::path::absolute(&path).unwrap_or(path);
    Overrides { surroundings: provenance.scene.surroundings, media: provenance.scene.media } =
        stage.overrides.absolute();
    let mut session = Session::resume(&stage, provenance, film).map_err(|e| e.context(args.film_file.display()))?;
    console.note(&format!("{} samples per pixel so far", session.film().passes().len()));
    let task = args.output.task(outputs, KeepArgs::default(), args.strict, args.progress, console);
    let ended = task.render(&mut session, &signals)?;
    task.finish(&session.end()?, ended).map(drop)
}

/// Returns the recorded surroundings, with the new path of a moved file.
fn surroundings(recorded: Option<Surroundings>, moved: Option<PathBuf>) -> Result<Option<Surroundings>> {
    match (recorded, moved) {
        (Some(Surroundings { environment: EnvironmentChoice::File(_), rotation, scale, layer }), Some(path)) => {
            Ok(Some(Surroundings { environment: EnvironmentChoice::File(path), rotation, scale, layer }))
        }
        (_, Some(_)) => {
            Err(Error::usage("the film's scene has no environment from a file: --env has nothing to replace"))
        }
        (recorded, None) => Ok(recorded),
    }
}

/// Returns the plan of this run.
fn plan(args: &Args, plan: PassPlan, replicates: u32) -> Result<PassPlan> {
    let Args { spp, time, target_error, .. } = *args;
    let choices = SettingsPatch { spp, time, target_error, replicates: Some(replicates), ..SettingsPatch::default() };
    if !choices.stops() {
        return Ok(plan);
    }
    if spp.is_some() && matches!(plan.selection, PassSelection::Range { .. }) {
        let what =
            format!("{} holds an explicit range of passes: render others with --passes", args.film_file.display());
        return Err(Error::usage(what));
    }
    choices.plan(plan.selection)
}

/// Returns the outputs: the film itself, and the image beside it unless another one was given.
fn outputs(args: &Args) -> Result<Outputs> {
    let beside = || args.film_file.with_extension("exr");
    let image = Outputs::of(args.output.output.as_deref().unwrap_or(&beside()))?;
    let film: &Path = args.output.film.as_deref().or(image.film.as_deref()).unwrap_or(&args.film_file);
    let film = Some(film.to_owned());
    let outputs = Outputs { film, ..image };
    Ok(if args.output.png { outputs.with_png() } else { outputs })
}
