//! Groups of flags that several subcommands share.

use super::Console;
use super::progress::ProgressArgs;
use super::task::Task;
use crate::error::{Error, Result};
use crate::render::{Budget, Bytes, Choices, Outputs, Plan, Selection, Settings, Stage};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// The scene and where its settings come from.
#[derive(Debug, clap::Args)]
pub(super) struct SceneArgs {
    /// The scene: a .gltf or .glb file
    pub(super) scene: PathBuf,
    /// Do not read the render.toml beside the scene
    #[arg(long)]
    pub(super) no_config: bool,
    #[command(flatten)]
    pub(super) choices: Choices,
}

impl SceneArgs {
    /// The choices of the command line, then those of `render.toml`.
    pub(super) fn choices(&self) -> Result<Choices> {
        let beside = if self.no_config { Choices::default() } else { Choices::beside(&self.scene)? };
        Ok(self.choices.clone().or(beside))
    }

    /// The scene, loaded and built as `choices` say, and the settings that its camera completes. Call it from outside the rayon
    /// pool.
    pub(super) fn stage(&self, choices: &Choices, threads: usize) -> Result<(Stage, Settings)> {
        let early = choices.settings(None)?;
        let stage = Stage::open(&self.scene, choices.surroundings()?, &early.moment(), &early.build_options(threads))?;
        let settings = stage.settings(choices)?;
        Ok((stage, settings))
    }
}

/// Which files are written.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Files")]
pub(super) struct OutputArgs {
    /// Where to: an .exr or .png image, or a .film to resume and merge
    #[arg(long, short, value_name = "PATH")]
    pub(super) output: Option<PathBuf>,
    /// Write a PNG beside the output as well
    #[arg(long)]
    pub(super) png: bool,
    /// Keep the film here as well; saved once a minute while rendering
    #[arg(long, value_name = "PATH")]
    pub(super) film: Option<PathBuf>,
    /// Write the report here, as JSON
    #[arg(long, value_name = "PATH")]
    pub(super) report: Option<PathBuf>,
}

/// What is kept against interruptions.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
#[command(next_help_heading = "Files")]
pub(super) struct KeepArgs {
    /// Save the film this often, so that a kill costs no more; without --film beside the image, until that is written
    #[arg(long, value_name = "TIME")]
    pub(super) checkpoint: Option<Budget>,
    /// Take what an earlier run of the same left: end at once if all is there, else go on with its film
    #[arg(long)]
    pub(super) skip_complete: bool,
}

impl OutputArgs {
    /// The files, for a run over `selection` of the picture `name`.
    pub(super) fn outputs(&self, name: &OsStr, selection: Selection) -> Result<Outputs> {
        let outputs = match &self.output {
            Some(path) => Outputs::of(path)?,
            None => Outputs::default_for(name, selection),
        };
        let outputs = if self.png { outputs.with_png() } else { outputs };
        Ok(outputs.with_film(self.film.clone(), selection))
    }

    /// What is to be done with them.
    pub(super) fn task(
        &self,
        outputs: Outputs,
        keep: KeepArgs,
        strict: StrictArgs,
        progress: ProgressArgs,
        console: Console,
    ) -> Task {
        let (report, checkpoint) = (self.report.clone(), keep.checkpoint.map(|every| every.0));
        Task { outputs, report, checkpoint, skip_complete: keep.skip_complete, strict, progress, console }
    }

    /// Makes sure that everything can be written before the work begins.
    pub(super) fn check(&self, outputs: &Outputs) -> Result<()> {
        let paths = outputs.paths().map(Path::to_owned).chain(self.report.clone());
        paths.into_iter().try_for_each(|path| crate::render::writable(&path))
    }
}

/// What is an error where it usually is a warning.
#[derive(Debug, Clone, Copy, clap::Args)]
#[command(next_help_heading = "Strictness")]
pub(super) struct StrictArgs {
    /// Refuse scenes that use something étendue ignores
    #[arg(long)]
    pub(super) strict: bool,
    /// End with exit code 6 if a sample was not finite
    #[arg(long)]
    pub(super) fail_on_nonfinite: bool,
    /// End with exit code 5 if the --target-error was not reached
    #[arg(long)]
    pub(super) require_target: bool,
}

impl StrictArgs {
    /// Refuses to require a target where there is none.
    pub(super) fn check(self, plan: &Plan) -> Result<()> {
        if self.require_target && plan.stop.target_error.is_none() {
            return Err(Error::usage("--require-target: there is no --target-error to reach"));
        }
        Ok(())
    }
}

/// How many threads work.
#[derive(Debug, Clone, Copy, clap::Args)]
#[command(next_help_heading = "Machine")]
pub(super) struct ThreadArgs {
    /// Number of threads [default: what Slurm, OpenCue or cgroups grant, else all cores]
    #[arg(long, short = 'j')]
    pub(super) threads: Option<usize>,
    /// Memory that the process may take, e.g. 4G: what would take more is refused with exit code 33 [default: what is free, within
    /// cgroup limits]
    #[arg(long, value_name = "SIZE")]
    pub(super) memory: Option<Bytes>,
}
