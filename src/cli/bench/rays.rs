//! `etendue bench rays`: how fast rays are traced, by backend.

use crate::accel::Backend;
use crate::cli::args::{SceneArgs, ThreadArgs};
use crate::cli::{Console, startup};
use crate::error::Result;
use crate::render::{Choices, RayBench, RayRates};
use serde::Serialize;

/// Arguments of `bench rays`.
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Backends to compare, separated by commas [default: all there are]
    #[arg(long, value_enum, value_delimiter = ',')]
    backends: Option<Vec<Backend>>,
    /// Rounds, each a pass and a replay with every backend
    #[arg(long, default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    #[command(flatten)]
    threads: ThreadArgs,
    #[command(flatten)]
    console: Console,
}

#[derive(Serialize)]
struct Document {
    threads: usize,
    rates: Vec<RayRates>,
}

/// Measures.
pub(super) fn run(args: Args) -> Result<()> {
    let choices = args.scene.choices()?;
    let threads = startup::start_threads(args.threads.threads)?;
    let backends = args.backends.as_deref().unwrap_or(Backend::AVAILABLE);
    let subject = |&backend: &Backend| {
        let (stage, settings) = args.scene.stage(&Choices { backend: Some(backend), ..choices.clone() }, threads)?;
        RayBench::new(stage, settings)
    };
    let mut subjects = backends.iter().map(subject).collect::<Result<Vec<_>>>()?;
    for _ in 0..args.rounds {
        subjects.iter_mut().for_each(RayBench::round);
    }
    let document = Document { threads, rates: subjects.iter().map(RayBench::rates).collect() };
    args.console.document(&document)?;
    args.console
        .line(&format!("million rays per second, {threads} threads, median of {} rounds (least to most)", args.rounds))?;
    document.rates.iter().try_for_each(|rates| args.console.line(&line(rates)))
}

fn line(rates: &RayRates) -> String {
    let RayRates { raw, render, share, .. } = rates;
    format!(
        "{:7} raw {:6.2} ({:.2} to {:.2})  in the render {:6.2} ({:.2} to {:.2})  share {:.3} ({:.3} to {:.3})  built in {:.3} s, {:.0} bytes a triangle",
        rates.backend,
        raw.median,
        raw.least,
        raw.most,
        render.median,
        render.least,
        render.most,
        share.median,
        share.least,
        share.most,
        rates.accel_seconds,
        rates.bytes_per_triangle
    )
}
