//! Groups of flags shared by several subcommands.

use super::settings_args::SettingsArgs;
use crate::error::{Error, Result};
use crate::session::{Budget, Bytes, LoadedScene, Outputs, PassPlan, PassSelection, RenderJob, SettingsPatch};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// The scene and the source of its settings.
#[derive(Debug, clap::Args)]
pub(super) struct SceneArgs {
    /// The scene: a .gltf or .glb file
    pub(super) scene: PathBuf,
    /// Do not read the render.toml beside the scene
    #[arg(long)]
    pub(super) no_config: bool,
    #[command(flatten)]
    pub(super) choices: SettingsArgs,
}

impl SceneArgs {
    /// Returns the choices of the command line, completed by those of `render.toml`.
    pub(super) fn choices(&self) -> Result<SettingsPatch> {
        let beside = if self.no_config { SettingsPatch::default() } else { SettingsPatch::beside(&self.scene)? };
        Ok(self.choices.0.clone().or(beside))
    }

    /// Loads and builds the scene for `choices`, and fits the job to its camera. Must be called from outside the rayon
    /// pool.
    pub(super) fn load(&self, choices: &SettingsPatch, threads: usize) -> Result<(LoadedScene, RenderJob)> {
        let job = choices.resolve(PassSelection::All)?;
        let stage = job.load(&self.scene, threads)?;
        let job = job.fitted(&stage)?;
        Ok((stage, job))
    }
}

/// Output files.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Files")]
pub(super) struct OutputArgs {
    /// Output file: an .exr or .png image, or a .film to resume and merge
    #[arg(long, short, value_name = "PATH")]
    pub(super) output: Option<PathBuf>,
    /// Write a PNG beside the output as well
    #[arg(long)]
    pub(super) png: bool,
    /// Keep the film here as well; saved once a minute while rendering
    #[arg(long, value_name = "PATH")]
    pub(super) film: Option<PathBuf>,
    /// Write the report to this file, as JSON
    #[arg(long, value_name = "PATH")]
    pub(super) report: Option<PathBuf>,
}

/// Protection against interruptions.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
#[command(next_help_heading = "Files")]
pub(super) struct KeepArgs {
    /// Save the film at this interval, so that a kill costs no more; without --film beside the image, until that is
    /// written
    #[arg(long, value_name = "TIME")]
    pub(super) checkpoint: Option<Budget>,
    /// Reuse the output of an earlier run of the same render: end at once if it is complete, else continue its film
    #[arg(long)]
    pub(super) skip_complete: bool,
}

impl OutputArgs {
    /// Returns the output files of a run over `selection` of the picture `name`.
    pub(super) fn outputs(&self, name: &OsStr, selection: PassSelection) -> Result<Outputs> {
        let outputs = match &self.output {
            Some(path) => Outputs::of(path)?,
            None => Outputs::default_for(name, selection),
        };
        let outputs = if self.png { outputs.with_png() } else { outputs };
        Ok(outputs.with_film(self.film.clone(), selection))
    }

    /// Checks that all outputs can be written, before the work begins.
    pub(super) fn check(&self, outputs: &Outputs) -> Result<()> {
        let paths = outputs.paths().map(Path::to_owned).chain(self.report.clone());
        paths.into_iter().try_for_each(|path| crate::session::writable(&path))
    }
}

/// Warnings that are treated as errors.
#[derive(Debug, Clone, Copy, clap::Args)]
#[command(next_help_heading = "Strictness")]
pub(super) struct StrictArgs {
    /// Refuse scenes that use features ignored by étendue
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
    /// Rejects --require-target without a target.
    pub(super) fn check(self, plan: &PassPlan) -> Result<()> {
        if self.require_target && plan.stop.target_error.is_none() {
            return Err(Error::usage("--require-target: there is no --target-error to reach"));
        }
        Ok(())
    }
}

/// Thread count and memory limit.
#[derive(Debug, Clone, Copy, clap::Args)]
#[command(next_help_heading = "Machine")]
pub(super) struct ThreadArgs {
    /// Number of threads [default: what Slurm, OpenCue or cgroups grant, else all cores]
    #[arg(long, short = 'j')]
    pub(super) threads: Option<usize>,
    /// Memory limit of the process, e.g. 4G: requests beyond it are refused with exit code 33 [default: what is free,
    /// within cgroup limits]
    #[arg(long, value_name = "SIZE")]
    pub(super) memory: Option<Bytes>,
}
