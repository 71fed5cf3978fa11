//! `etendue bench rays`: the ray throughput of the backends, and the agreement of their hits.

use super::{command, scene_name};
use crate::accel::{Backend, Build};
use crate::cli::args::SceneArgs;
use crate::cli::args::ThreadArgs;
use crate::cli::named_value::named;
use crate::cli::settings_args::SettingsArgs;
use crate::cli::{Console, startup};
use crate::error::{Error, Result};
use crate::lab::bench_rays::{
    self, CategoryRow, PaceRates, Rate, RayAddress, RayBenchRequest, RayBenchSubject, RaysReport, SceneRates,
};
use crate::lab::equivalence::DifferenceCounts;
use crate::lab::unique;
use crate::named::Named;
use crate::session::SettingsPatch;
use crate::session::machine;
use std::path::PathBuf;

/// Maximum number of addresses on a line; reports list more.
const MOST_SHOWN: usize = 3;

/// Arguments of `bench rays`.
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// The scenes: .gltf or .glb files
    #[arg(value_name = "SCENES", required_unless_present_any = ["hard_cases", "replay"])]
    scenes: Vec<PathBuf>,
    /// Do not read the render.toml beside a scene
    #[arg(long)]
    no_config: bool,
    /// Folder of report.json, rates.csv, categories.csv and index.html [default: nowhere]
    #[arg(long, short, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Backends to compare, separated by commas [default: all there are]
    #[arg(long, value_parser = named::<Backend>(), value_delimiter = ',')]
    backends: Option<Vec<Backend>>,
    /// Builds of each backend, separated by commas
    #[arg(long, value_parser = named::<Build>(), value_delimiter = ',', default_value = "robust")]
    builds: Vec<Build>,
    /// Thread counts, separated by commas [default: 1 and all cores]
    #[arg(long, short = 'j', value_name = "N", value_delimiter = ',')]
    threads: Vec<usize>,
    /// Number of rounds, each of which measures everything once; 0 only compares hits
    #[arg(long, default_value_t = 9, value_name = "N")]
    rounds: u32,
    /// Approximate maximum of recorded rays, 200 bytes each: a pass that would trace more is rendered with fewer pixels
    /// of the same view
    #[arg(long, default_value_t = 2_000_000, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    rays: u64,
    /// Keep the recorded rays of the scene in this file
    #[arg(long, value_name = "FILE", conflicts_with = "load")]
    save: Option<PathBuf>,
    /// Load the rays of the scene from a file that --save wrote, instead of recording them
    #[arg(long, value_name = "FILE")]
    load: Option<PathBuf>,
    /// Also compare hits in hard cases: seams, slivers, instances, scales (see src/lab/hard_cases)
    #[arg(long)]
    hard_cases: bool,
    /// Number of rays of each hard case
    #[arg(long, default_value_t = 100_000, value_name = "N", requires = "hard_cases")]
    rays_per_case: u64,
    /// Print one ray and the answer of every row, by the ray's address in a report; measures nothing
    #[arg(long, value_name = "ADDRESS", conflicts_with_all = ["output", "save", "hard_cases"])]
    replay: Option<RayAddress>,
    #[command(flatten)]
    choices: SettingsArgs,
    #[command(flatten)]
    console: Console,
}

/// Runs the measurement.
pub(super) fn run(args: &Args) -> Result<()> {
    check(args)?;
    let request = request(args)?;
    let most = request.threads.iter().copied().max();
    let threads = startup::start_threads(ThreadArgs { threads: most, memory: None })?;
    if let Some(address) = &args.replay {
        return replay(args, &request, address, threads);
    }
    let subjects = (0..args.scenes.len()).map(|at| subject(args, at, threads)).collect::<Result<Vec<_>>>()?;
    let report = bench_rays::run(&request, subjects, &mut |text| args.console.note(text))?;
    args.console.document(&report)?;
    lines(&report).iter().try_for_each(|line| args.console.line(line))?;
    match &args.output {
        Some(folder) => args.console.line(&format!("report: {}", folder.join("index.html").display())),
        None => Ok(()),
    }
}

/// Reports errors in the arguments before anything is loaded.
fn check(args: &Args) -> Result<()> {
    let choices = &args.choices.0;
    if choices.spp.is_some() || choices.time.is_some() || choices.target_error.is_some() {
        return Err(Error::usage("bench rays takes --rounds instead of --spp, --time and --target-error"));
    }
    if choices.backend.is_some() || choices.build.is_some() {
        return Err(Error::usage("bench rays takes --backends and --builds instead of --backend and --build"));
    }
    if (args.save.is_some() || args.load.is_some()) && args.scenes.len() != 1 {
        return Err(Error::usage("--save and --load take one scene"));
    }
    Ok(())
}

fn request(args: &Args) -> Result<RayBenchRequest> {
    let backends = unique(args.backends.as_deref().unwrap_or(Backend::AVAILABLE));
    let builds = unique(&args.builds);
    let count = |asked| machine::threads(asked, |name| std::env::var(name).ok());
    let threads = match &args.threads[..] {
        [] => vec![1, count(None)?],
        asked => asked.iter().map(|&n| count(Some(n))).collect::<Result<_>>()?,
    };
    Ok(RayBenchRequest {
        setups: backends.iter().flat_map(|&backend| builds.iter().map(move |&build| (backend, build))).collect(),
        threads: unique(&threads),
        rounds: args.rounds,
        rays: args.rays,
        hard_case_rays: args.hard_cases.then_some(args.rays_per_case),
        load: args.load.clone(),
        save: args.save.clone(),
        folder: args.output.clone(),
        command: command(),
    })
}

/// Loads a scene with the default backend and the robust build. The recorded rays thus do not depend on the measured
/// backends.
fn subject(args: &Args, at: usize, threads: usize) -> Result<RayBenchSubject> {
    let scene = SceneArgs { scene: args.scenes[at].clone(), no_config: args.no_config, choices: args.choices.clone() };
    let (backend, build) = (Some(Backend::default()), Some(Build::Robust));
    let (stage, job) = scene.load(&SettingsPatch { backend, build, ..scene.choices()? }, threads)?;
    Ok(RayBenchSubject { name: scene_name(&args.scenes, at), stage, settings: job.settings })
}

fn replay(args: &Args, request: &RayBenchRequest, address: &RayAddress, threads: usize) -> Result<()> {
    let names: Vec<String> = (0..args.scenes.len()).map(|at| scene_name(&args.scenes, at)).collect();
    let subject = match &address.scene {
        None => None,
        Some(name) => {
            let at = names.iter().position(|other| other == name);
            let at =
                at.ok_or_else(|| Error::usage(format!("--replay {address}: no scene given is called '{name}'")))?;
            Some(subject(args, at, threads)?)
        }
    };
    let replay = bench_rays::replay(request, subject, address)?;
    args.console.document(&replay)?;
    replay.lines().iter().try_for_each(|line| args.console.line(line))
}

fn lines(report: &RaysReport) -> Vec<String> {
    let mut lines = Vec::new();
    for scene in &report.scenes {
        lines.extend(rate_lines(scene, report.rounds));
        let found: Vec<_> = report.categories.iter().filter(|row| row.scene.as_ref() == Some(&scene.name)).collect();
        lines.push(format!("{}: what is hit, all classes together", scene.name));
        lines.extend(scene.rows.iter().map(|row| scene_hits(&row.backend, width(scene), &found)));
    }
    let hard: Vec<_> = report.categories.iter().filter(|row| row.scene.is_none()).collect();
    if !hard.is_empty() {
        let wrong: Vec<String> =
            hard.iter().filter(|row| !row.addresses.is_empty()).map(|row| hard_hits(row)).collect();
        lines.push(format!("hard cases: {} of {} rows have true differences or leaks", wrong.len(), hard.len()));
        lines.extend(wrong);
    }
    lines
}

/// Returns the length of the longest name of a row.
fn width(scene: &SceneRates) -> usize {
    scene.rows.iter().map(|row| row.backend.len()).max().unwrap_or(0)
}

fn rate_lines(scene: &SceneRates, rounds: u32) -> Vec<String> {
    let classes: Vec<String> = scene.classes.iter().map(|class| format!("{} {}", class.rays, class.name)).collect();
    let execution = scene.execution.map_or(String::new(), |e| format!(", {} execution", e.name()));
    let mut lines = vec![format!("{}: {} rays ({}){execution}", scene.name, scene.rays, classes.join(", "))];
    if rounds > 0 {
        lines.push(format!("million rays per second, median of {rounds} rounds (least to most)"));
    }
    let width = width(scene);
    for row in &scene.rows {
        // Batches are traced by the structure of the row above.
        if row.batch.is_none() {
            let (name, seconds, bytes) = (&row.backend, row.build_seconds, row.bytes_per_triangle);
            lines.push(format!("  {name:width$} built in {seconds:.3} s, {bytes:.0} bytes a triangle"));
        }
        lines.extend(row.paces.iter().flat_map(|pace| pace_lines(&row.backend, width, pace)));
    }
    lines.extend(scene.left_out.iter().map(|reason| format!("  left out: {reason}")));
    lines
}

fn pace_lines(name: &str, width: usize, pace: &PaceRates) -> [String; 2] {
    let spread =
        |r: Rate, digits: usize| format!("{:.digits$} ({:.digits$} to {:.digits$})", r.median, r.least, r.most);
    let optional = |name: &str, rate: Option<Rate>, digits| {
        rate.map_or(String::new(), |r| format!("  {name} {}", spread(r, digits)))
    };
    let (render, share) = (optional("in the render", pace.render, 2), optional("share", pace.share, 3));
    let threads = if pace.threads == 1 { "1 thread".into() } else { format!("{} threads", pace.threads) };
    let classes: Vec<String> =
        pace.classes.iter().map(|class| format!("{} {:.2}", class.name, class.rate.median)).collect();
    [
        format!("  {name:width$} {threads:10} raw {}{render}{share}", spread(pace.raw, 2)),
        format!("  {name:width$} {threads:10} by class: {}", classes.join("  ")),
    ]
}

/// Summarises the hits of a row in a scene, over all classes. The report has them by class.
fn scene_hits(backend: &str, width: usize, found: &[&CategoryRow]) -> String {
    let rows: Vec<_> = found.iter().filter(|row| row.category.backend == backend).collect();
    let sum = |of: fn(&DifferenceCounts) -> u64| rows.iter().map(|row| of(&row.category.tally)).sum::<u64>();
    let [rays, hits, ties, grazes, differences] =
        [sum(|t| t.rays), sum(|t| t.hits), sum(|t| t.ties), sum(|t| t.grazes), sum(|t| t.true_differences)];
    let beside = rows.first().map_or("", |row| &row.category.reference);
    let addresses: Vec<&str> = rows.iter().flat_map(|row| &row.addresses).map(String::as_str).collect();
    let counts = format!("{hits} hits of {rays} rays, {ties} ties, {grazes} grazes, {differences} true differences");
    format!("  {backend:width$} beside {beside}: {counts}{}", again(&addresses))
}

fn hard_hits(row: &CategoryRow) -> String {
    let (category, tally) = (&row.category, &row.category.tally);
    let counts = format!("{} true differences, {} leaks of {} rays", tally.true_differences, tally.leaks, tally.rays);
    let addresses: Vec<&str> = row.addresses.iter().map(String::as_str).collect();
    format!("  {:20} {:15} {counts}{}", category.name, category.backend, again(&addresses))
}

/// Returns the arguments that replay the rays at `addresses`, if there are any.
fn again(addresses: &[&str]) -> String {
    let (shown, more) = addresses.split_at(addresses.len().min(MOST_SHOWN));
    let more = if more.is_empty() { "" } else { " …" };
    if shown.is_empty() { String::new() } else { format!(": --replay {}{more}", shown.join(" or ")) }
}
