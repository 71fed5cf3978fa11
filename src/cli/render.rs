//! `etendue render`: scene in, image out.

use super::args::{KeepArgs, OutputArgs, SceneArgs, StrictArgs, ThreadArgs};
use super::batch::{self, Means};
use super::progress::ProgressArgs;
use super::signals::Signals;
use super::techniques::TechniqueArgs;
use super::{Console, startup, task};
use crate::error::Result;
use crate::render::job::{Job, Request};
use crate::render::{Choices, Ended, Frames, Plan, Provenance, Selection, picture_name};
use std::path::Path;

/// Arguments of `render`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    share: Share,
    /// Render these frames of the scene's animations, e.g. 1-240, 1-240x2 or 1,3,7-9, each into a file of its own: {frame:04} in the
    /// output's name is its number. What is complete is not rendered again
    #[arg(long, value_name = "LIST", conflicts_with_all = ["frame", "shard", "passes", "techniques", "film", "png", "checkpoint"])]
    frames: Option<Frames>,
    #[command(flatten)]
    output: OutputArgs,
    #[command(flatten)]
    keep: KeepArgs,
    #[command(flatten)]
    techniques: TechniqueArgs,
    #[command(flatten)]
    strict: StrictArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    #[command(flatten)]
    progress: ProgressArgs,
    #[command(flatten)]
    console: Console,
}

/// Which share of the passes is rendered.
#[derive(Debug, Clone, Copy, clap::Args)]
#[command(next_help_heading = "Share of the work")]
struct Share {
    /// Render shard I of N, from 0: merge the films of all shards afterwards
    #[arg(long, value_name = "I/N", value_parser = shard, conflicts_with = "passes")]
    shard: Option<Selection>,
    /// Render the passes A to B-1, one sample per pixel each, whatever --spp says
    #[arg(long, value_name = "A..B", value_parser = range)]
    passes: Option<Selection>,
}

fn shard(text: &str) -> std::result::Result<Selection, String> {
    let selection = text.parse()?;
    if matches!(selection, Selection::Shard { .. }) { Ok(selection) } else { Err("write a shard as I/N".into()) }
}

fn range(text: &str) -> std::result::Result<Selection, String> {
    let selection = text.parse()?;
    if matches!(selection, Selection::Range { .. }) { Ok(selection) } else { Err("write a range of passes as A..B".into()) }
}

/// Renders.
pub(super) fn run(args: Args) -> Result<()> {
    if let Some(frames) = args.frames.clone() {
        return run_frames(frames, args);
    }
    let console = args.console;
    let choices = args.scene.choices()?;
    let selection = args.share.shard.or(args.share.passes).unwrap_or_default();
    let plan = choices.plan(selection)?;
    args.strict.check(&plan)?;
    // Mistakes that do not need the scene are told before it is loaded.
    let (look, early) = (choices.look()?, choices.settings(None)?);
    choices.surroundings()?;
    let outputs = args.output.outputs(&picture_name(&args.scene.scene), selection)?;
    args.output.check(&outputs)?;
    let techniques = args.techniques.files(early.method, &outputs)?;
    say_rounding(console, &choices, plan, early.replicates);
    let signals = Signals::heed()?;
    let threads = startup::start_threads(args.threads)?;
    let (stage, settings) = args.scene.stage(&choices, threads)?;
    let provenance = Provenance::new(&stage, settings, plan, look);
    task::warn(console, &provenance);
    if args.strict.strict {
        stage.refuse_ignored()?;
    }
    let task = args.output.task(outputs, args.keep, args.strict, args.progress, console);
    let Some(mut session) = task.begin(&stage, provenance)? else { return Ok(()) };
    let mut ended = task.render(&mut session, &signals)?;
    if let (Some(files), Ended::Complete) = (&techniques, ended) {
        ended = args.techniques.write(files, &session, &signals.cancel, console)?;
    }
    task.finish(&session.end()?, ended).map(drop)
}

/// Renders frames as a batch.
fn run_frames(frames: Frames, args: Args) -> Result<()> {
    let Args { scene: SceneArgs { scene, no_config, choices }, output, strict, threads, progress, console, .. } = args;
    let request = Request { scenes: vec![scene], frames: Some(frames), settings: choices, ..Request::default() };
    let job = Job {
        output: Some(output.output.unwrap_or_else(|| "{scene}.{frame:04}.exr".into())),
        report: output.report,
        render: vec![request],
        no_config,
        ..Job::default()
    };
    let pictures = job.pictures(Path::new(""), &Choices::default())?;
    batch::render_all(&pictures, Means { again: false, strict, threads, progress, console })
}

/// Says that another number of samples is rendered than was asked for.
fn say_rounding(console: Console, choices: &Choices, plan: Plan, replicates: u32) {
    if let (Some(asked), Some(spp), false) = (choices.spp, plan.stop.spp, matches!(plan.selection, Selection::Range { .. })) {
        if u64::from(asked) != spp {
            console.note(&format!("{asked} samples per pixel rounded up to {spp}: {replicates} replicates × a power of two"));
        }
    }
}
