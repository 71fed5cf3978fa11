//! `etendue bench methods`: error against time, methods and backends side by side.

use super::{command, scene_name};
use crate::accel::Backend;
use crate::cli::args::{SceneArgs, ThreadArgs};
use crate::cli::named_value::named;
use crate::cli::settings_args::SettingsArgs;
use crate::cli::{Console, startup};
use crate::error::{Error, Result};
use crate::integrator::Method;
use crate::lab::bench_methods::{self, BenchScene, MethodsReport, MethodsRequest, SceneReport};
use crate::lab::unique;
use crate::session::{Budget, SettingsPatch};
use std::path::PathBuf;

/// Arguments of `bench methods`.
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// The scenes: .gltf or .glb files
    #[arg(required = true, value_name = "SCENES")]
    scenes: Vec<PathBuf>,
    /// Do not read the render.toml beside a scene
    #[arg(long)]
    no_config: bool,
    /// Folder of report.json, points.csv and index.html; rendered references are kept there and reused
    #[arg(long, short, value_name = "FOLDER")]
    output: PathBuf,
    /// Methods to compare, separated by commas [default: all]
    #[arg(long, value_parser = named::<Method>(), value_delimiter = ',')]
    methods: Option<Vec<Method>>,
    /// Backends to compare, separated by commas [default: all there are]
    #[arg(long, value_parser = named::<Backend>(), value_delimiter = ',')]
    backends: Option<Vec<Backend>>,
    /// Time for each curve, all its repetitions together
    #[arg(long, default_value = "20s", value_name = "TIME")]
    budget: Budget,
    /// Independent renders of each curve [default: 5, or what fits into the budget]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=1000))]
    repetitions: Option<u32>,
    /// Reference images, separated by commas, one for each scene [default: one is made]
    #[arg(long = "reference", value_name = "EXR", value_delimiter = ',')]
    references: Vec<PathBuf>,
    /// relMSE of the reference itself, where the file has no standard error, one for each scene
    #[arg(long, value_name = "RELMSE", value_delimiter = ',', requires = "references")]
    reference_noise: Vec<f64>,
    /// Time for rendering a reference [default: four times the budget]
    #[arg(long, value_name = "TIME", conflicts_with = "references")]
    reference_budget: Option<Budget>,
    #[command(flatten)]
    choices: SettingsArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    #[command(flatten)]
    console: Console,
}

/// Runs the measurement.
pub(super) fn run(args: &Args) -> Result<()> {
    check(args)?;
    let threads = startup::start_threads(args.threads)?;
    let subjects = (0..args.scenes.len()).map(|at| subject(args, at, threads)).collect::<Result<Vec<_>>>()?;
    let report = bench_methods::run(&request(args), &subjects, &mut |text| args.console.note(text))?;
    for scene in report.scenes.iter().filter(|scene| scene.is_reference_poor()) {
        args.console
            .warn(&format!("{}: the reference's own error is above a tenth of an error compared with it", scene.name));
    }
    args.console.document(&report)?;
    report.scenes.iter().try_for_each(|scene| lines(scene).iter().try_for_each(|line| args.console.line(line)))?;
    args.console.line(&conditions(&report))?;
    args.console.line(&format!("report: {}", args.output.join("index.html").display()))
}

/// Reports errors in the arguments before anything is loaded.
fn check(args: &Args) -> Result<()> {
    let choices = &args.choices.0;
    if choices.spp.is_some() || choices.time.is_some() {
        return Err(Error::usage("bench methods takes --budget instead of --spp and --time"));
    }
    if choices.method.is_some() || choices.backend.is_some() {
        return Err(Error::usage("bench methods takes --methods and --backends instead of --method and --backend"));
    }
    for (what, count) in [("--reference", args.references.len()), ("--reference-noise", args.reference_noise.len())] {
        if count > 0 && count != args.scenes.len() {
            return Err(Error::usage(format!(
                "{what} names {count} for {} scenes: give one for each",
                args.scenes.len()
            )));
        }
    }
    if let Some(noise) = args.reference_noise.iter().find(|n| !(n.is_finite() && **n >= 0.0)) {
        return Err(Error::usage(format!("--reference-noise {noise}: must be 0 or more")));
    }
    Ok(())
}

fn request(args: &Args) -> MethodsRequest {
    MethodsRequest {
        methods: unique(args.methods.as_deref().unwrap_or(&Method::compared())),
        budget: args.budget.0,
        repetitions: args.repetitions,
        reference_budget: args.reference_budget.map_or(4 * args.budget.0, |b| b.0),
        folder: args.output.clone(),
        command: command(),
    }
}

fn subject(args: &Args, at: usize, threads: usize) -> Result<BenchScene> {
    let scene = SceneArgs { scene: args.scenes[at].clone(), no_config: args.no_config, choices: args.choices.clone() };
    let choices = scene.choices()?;
    let build = |backend| scene.load(&SettingsPatch { backend: Some(backend), ..choices.clone() }, threads);
    let backends = unique(args.backends.as_deref().unwrap_or(Backend::AVAILABLE));
    Ok(BenchScene {
        name: scene_name(&args.scenes, at),
        stages: backends.into_iter().map(build).collect::<Result<_>>()?,
        reference: args.references.get(at).map(|path| (path.clone(), args.reference_noise.get(at).copied())),
    })
}

fn lines(scene: &SceneReport) -> Vec<String> {
    let noise = scene.reference.noise.map_or("unknown".into(), |n| format!("{n:.1e}"));
    let mut lines = vec![format!("{}: reference {}, its own relMSE {noise}", scene.name, scene.reference.origin)];
    lines.extend(scene.curves.iter().filter_map(|curve| {
        let last = curve.points.last()?;
        let error =
            last.relmse.map_or("lost in noise".into(), |e| format!("{:.3e} [{:.3e}, {:.3e}]", e.value, e.low, e.high));
        let slope = curve
            .slope_in_time
            .map_or(String::new(), |s| format!(", slope {:.2} [{:.2}, {:.2}]", s.value, s.low, s.high));
        let quality = match curve.efficiency {
            _ if !curve.blind_spots.is_empty() => "blind to parts of the scene".into(),
            Some(e) => format!("efficiency {:.4} [{:.4}, {:.4}]", e.value, e.low, e.high),
            None => "no efficiency".into(),
        };
        let (label, spp, cpu, rays) = (&curve.label, last.spp, last.cpu_seconds, curve.mrays_per_second);
        Some(format!("  {label:20} {spp:6} spp {cpu:8.3} CPU s  relMSE {error}  {quality}{slope}  {rays:.2} Mrays/s"))
    }));
    lines
}

fn conditions(report: &MethodsReport) -> String {
    let processor = report.conditions.processor.as_deref().unwrap_or("unknown processor");
    format!("{} repetitions, {} threads, {processor}", report.repetitions, report.threads)
}
