//! `etendue verify`: tests whether all methods and backends agree on a scene.

use super::args::{SceneArgs, ThreadArgs};
use super::named_value::named;
use super::progress::Meter;
use super::signals::Signals;
use super::{Console, startup};
use crate::accel::Backend;
use crate::error::{Error, Kind, Result};
use crate::film::pyramid::Pyramid;
use crate::integrator::Method;
use crate::lab::same_mean::{Outcome, TestedPicture, judge};
use crate::lab::verify::{
    Candidate, Effort, Ran, VerifyReport, VerifyRequest, affordable, run as render, write_pictures,
};
use crate::session::{Budget, LoadedScene, SettingsPatch, round_spp, writable};
use std::path::PathBuf;
use std::time::Duration;

pub(super) const LONG: &str = "\
Compares all methods and backends on a scene

Every method that sees all of the scene renders it with every backend, each with its own random numbers in 32 independent
replicates and with equal time. Then the means of all pairs are compared, of the whole image and of tiles of 8x8 pixels and
upwards, so that all right candidates are found to agree with a probability of at least 1 - level. What all of them do wrong
cannot be seen. The picture is that of render.toml (camera, depth, filter, environment) but small, whole and unclamped unless
--size or --crop say otherwise.";

pub(super) const AFTER: &str = "\
Examples:
  etendue verify cup.glb                           all there are, for two minutes
  etendue verify cup.glb --methods path,path-nee --backends obvhs --budget 30s
  etendue verify cup.glb --spp 1024 -o pictures    equal samples; every picture and where the worst pair differs

Exit codes:
  0 no difference found, or none that can be told: the last line says which
  7 a difference found   2 usage, or fewer than two candidates   3 scene invalid
  4 output cannot be written   33 out of memory   75 stopped by a signal: nothing was verified";

/// Arguments of `verify`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    who: Who,
    #[command(flatten)]
    threads: ThreadArgs,
    #[command(flatten)]
    console: Console,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Comparison")]
struct Who {
    /// Methods to compare, separated by commas [default: all that see the whole scene]
    #[arg(long, value_parser = named::<Method>(), value_delimiter = ',')]
    methods: Option<Vec<Method>>,
    /// Backends to compare, separated by commas [default: all there are]
    #[arg(long, value_parser = named::<Backend>(), value_delimiter = ',')]
    backends: Option<Vec<Backend>>,
    /// Time for rendering, split evenly [default: 120s, unless --spp says how many samples each takes]
    #[arg(long, value_name = "TIME", conflicts_with = "spp")]
    budget: Option<Budget>,
    /// Maximum probability of finding any difference where there is none
    #[arg(long, default_value_t = LEVEL, value_parser = level)]
    level: f64,
    /// Write every picture, and the differences of the worst pair, into this folder
    #[arg(long, short, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

fn level(text: &str) -> std::result::Result<f64, String> {
    let level = text.parse().ok().filter(|l| (MIN_LEVEL..=0.5).contains(l));
    level.ok_or_else(|| format!("'{text}' is not a level: write a probability from {MIN_LEVEL} to 0.5"))
}

/// Minimum level. The tails of t are unreliable below it for 32 replicates.
const MIN_LEVEL: f64 = 1e-9;

/// Default of --level: at most one false alarm in a thousand runs on unbiased renderers.
const LEVEL: f64 = 1e-3;

/// Default of --budget.
const BUDGET: Duration = Duration::from_secs(120);

/// Verifies a scene.
pub(super) fn run(args: Args) -> Result<()> {
    let console = args.console;
    refuse_senseless(&args.scene.choices.0)?;
    let choices = choices(&args.scene)?;
    choices.settings(None)?;
    if let Some(folder) = &args.who.output {
        writable(&folder.with_extension("exr"))?;
    }
    let request = VerifyRequest { methods: args.who.methods.clone(), backends: args.who.backends.clone() };
    let threads = startup::start_threads(args.threads)?;
    let stages =
        request.backends().into_iter().map(|b| stage(&args.scene, &choices, b, threads)).collect::<Result<Vec<_>>>()?;
    let lineup = request.lineup(&stages[0].scene)?;
    let mut candidates = candidates(&stages, &lineup.methods, &choices)?;
    render_all(&mut candidates, effort(&args.who, &args.scene.choices.0), console)?;
    let pyramids = candidates.iter().map(Candidate::pyramid).collect::<Result<Vec<Pyramid>>>()?;
    let pictures: Vec<TestedPicture<'_, Method>> = candidates
        .iter()
        .zip(&pyramids)
        .map(|(c, pyramid)| TestedPicture { pyramid, method: c.method(), doubt: c.doubt(args.who.level) })
        .collect();
    let judgement = judge(&pictures, args.who.level);
    if let Some(folder) = &args.who.output {
        write_pictures(folder, &candidates, &judgement)?;
    }
    tell(&VerifyReport::new(&candidates, &pictures, lineup, judgement), console)
}

/// Adapts the command for clap: flags of `render` without a meaning here are hidden, and those with another meaning get
/// their own help.
pub(super) fn command(mut command: clap::Command) -> clap::Command {
    for flag in ["method", "backend", "time", "target-error", "replicates", "clamp", "aov"] {
        command = command.mut_arg(flag, |arg| arg.hide(true));
    }
    let spp = "Samples per pixel of each candidate instead of a time, rounded up to 32 times a power of two";
    let size = "Image size; without a height the camera's aspect decides [default: 128 on the longer side]";
    command.mut_arg("spp", |arg| arg.help(spp)).mut_arg("size", |arg| arg.help(size))
}

/// Rejects flags of `render` without a meaning here.
fn refuse_senseless(line: &SettingsPatch) -> Result<()> {
    let given = [
        ("--method", line.method.is_some(), "choose with --methods"),
        ("--backend", line.backend.is_some(), "choose with --backends"),
        ("--time", line.time.is_some(), "give a --budget"),
        ("--target-error", line.target_error.is_some(), "give a --budget"),
        ("--replicates", line.replicates.is_some(), "there are always 32"),
        ("--clamp", line.clamp.is_some(), "clamping biases each method differently"),
        ("--clamp-vpl", line.clamp_vpl.is_some(), "it biases vpl and lightcuts"),
        ("--aov", line.aovs.is_some(), "only colour is compared"),
    ];
    match given.into_iter().find(|(_, is_given, _)| *is_given) {
        Some((flag, _, instead)) => Err(Error::usage(format!("verify does not take {flag}: {instead}"))),
        None => Ok(()),
    }
}

/// Returns the picture's choices: those of `render.toml`, except for its size and its stopping criteria.
fn choices(scene: &SceneArgs) -> Result<SettingsPatch> {
    let (size, crop) = (scene.choices.0.size, scene.choices.0.crop);
    Ok(SettingsPatch { size, crop, spp: None, time: None, target_error: None, ..scene.choices()? })
}

fn effort(who: &Who, line: &SettingsPatch) -> Effort {
    match line.spp {
        Some(spp) => Effort::Spp(round_spp(u64::from(spp), crate::lab::verify::REPLICATES)),
        None => Effort::Time(who.budget.map_or(BUDGET, |Budget(time)| time)),
    }
}

fn stage(scene: &SceneArgs, choices: &SettingsPatch, backend: Backend, threads: usize) -> Result<LoadedScene> {
    Ok(scene.load(&SettingsPatch { backend: Some(backend), ..choices.clone() }, threads)?.0)
}

fn candidates<'a>(
    stages: &'a [LoadedScene],
    methods: &[Method],
    choices: &SettingsPatch,
) -> Result<Vec<Candidate<'a>>> {
    let count = stages.len() * methods.len();
    let all = methods.iter().flat_map(|&method| stages.iter().map(move |stage| (stage, method)));
    let mut candidates: Vec<Candidate<'a>> = Vec::new();
    for (stage, method) in all {
        let candidate = Candidate::new(stage, choices, method)?;
        if candidates.is_empty() {
            affordable(candidate.film().layout(), count)?;
        }
        candidates.push(candidate);
    }
    Ok(candidates)
}

fn render_all(candidates: &mut [Candidate<'_>], effort: Effort, console: Console) -> Result<()> {
    let signals = Signals::heed()?;
    signals.hold();
    let amount = match effort {
        Effort::Time(budget) => format!("for {}", humantime::format_duration(budget)),
        Effort::Spp(spp) => format!("with {spp} samples per pixel"),
    };
    console.note(&format!("rendering {} candidates {amount}", candidates.len()));
    let mut meter = Meter::new(console);
    match render(candidates, effort, &signals.cancel, &mut |done, left| meter.show(done, left, String::new)) {
        Ran::Complete => Ok(()),
        Ran::Interrupted => Err(Error::new(Kind::Interrupted, "stopped by a signal: nothing was verified")),
    }
}

/// Prints the result. A difference is an error, so that scripts notice it.
fn tell(report: &VerifyReport, console: Console) -> Result<()> {
    console.document(report)?;
    report.lines().iter().try_for_each(|line| console.line(line))?;
    if report.outcome != Outcome::Differ {
        return Ok(());
    }
    Err(Error::new(Kind::Differ, format!("{}: {}", report.scene, report.verdict())))
}
