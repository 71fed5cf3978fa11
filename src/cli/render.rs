//! `etendue render`: scene in, image out.

use super::args::{KeepArgs, OutputArgs, SceneArgs, StrictArgs, ThreadArgs};
use super::batch::{self, BatchOptions};
use super::progress::ProgressArgs;
use super::signals::Signals;
use super::techniques::TechniqueArgs;
use super::{Console, startup, task};
use crate::batch::{Frames, Job, JobRequest};
use crate::error::Result;
use crate::session::{Ended, PassSelection, SettingsPatch, picture_name};
use std::path::Path;

/// Arguments of `render`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    share: Share,
    /// Render these frames of the scene's animations, e.g. 1-240, 1-240x2 or 1,3,7-9, each into its own file:
    /// {frame:04} in the output's name is the frame number. Complete frames are not rendered again
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

/// Share of the passes to render.
#[derive(Debug, Clone, Copy, clap::Args)]
#[command(next_help_heading = "Share of the work")]
struct Share {
    /// Render shard I of N, from 0: merge the films of all shards afterwards
    #[arg(long, value_name = "I/N", value_parser = shard, conflicts_with = "passes")]
    shard: Option<PassSelection>,
    /// Render the passes A to B-1, one sample per pixel each, regardless of --spp
    #[arg(long, value_name = "A..B", value_parser = range)]
    passes: Option<PassSelection>,
}

fn shard(text: &str) -> std::result::Result<PassSelection, String> {
    let selection = text.parse()?;
    if matches!(selection, PassSelection::Shard { .. }) { Ok(selection) } else { Err("write a shard as I/N".into()) }
}

fn range(text: &str) -> std::result::Result<PassSelection, String> {
    let selection = text.parse()?;
    if matches!(selection, PassSelection::Range { .. }) {
        Ok(selection)
    } else {
        Err("write a range of passes as A..B".into())
    }
}

/// Renders the scene.
pub(super) fn run(args: Args) -> Result<()> {
    if let Some(frames) = args.frames.clone() {
        return run_frames(frames, args);
    }
    let console = args.console;
    let choices = args.scene.choices()?;
    let selection = args.share.shard.or(args.share.passes).unwrap_or_default();
    // Errors that do not depend on the scene are reported before it is loaded.
    let job = choices.resolve(selection)?;
    args.strict.check(&job.plan)?;
    let outputs = args.output.outputs(&picture_name(&args.scene.scene), selection)?;
    args.output.check(&outputs)?;
    let techniques = args.techniques.files(job.settings.method.kind(), &outputs)?;
    task::note_rounding(console, choices.spp, job.plan, job.settings.replicates);
    let signals = Signals::heed()?;
    let threads = startup::start_threads(args.threads)?;
    let stage = job.load(&args.scene.scene, threads)?;
    let provenance = job.fitted(&stage)?.provenance(&stage);
    task::warnings(&provenance).iter().for_each(|text| console.warn(text));
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
    let request =
        JobRequest { scenes: vec![scene], frames: Some(frames), settings: choices.0, ..JobRequest::default() };
    let job = Job {
        output: Some(output.output.unwrap_or_else(|| "{scene}.{frame:04}.exr".into())),
        report: output.report,
        render: vec![request],
        no_config,
        ..Job::default()
    };
    let pictures = job.pictures(Path::new(""), &SettingsPatch::default())?;
    batch::render_all(&pictures, BatchOptions { again: false, strict, threads, progress, console })
}
