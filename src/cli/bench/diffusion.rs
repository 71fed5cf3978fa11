//! `etendue bench diffusion`: errors of the diffusion models.

use crate::cli::console;
use crate::error::{Error, Result};
use crate::lab::bench_diffusion::{DiffusionBench, table};

/// Arguments of `bench diffusion`.
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// Single-scattering albedos, from 0 to 1, separated by commas
    #[arg(long, value_name = "ALBEDOS", value_delimiter = ',', default_value = "0.5,0.8,0.9,0.99")]
    albedos: Vec<f64>,
    /// Mean cosine of the phase function (Henyey and Greenstein)
    #[arg(long, value_name = "COSINE", default_value_t = 0.0, allow_negative_numbers = true)]
    mean_cosine: f64,
    /// Refractive index of the body
    #[arg(long, value_name = "INDEX", default_value_t = 1.4)]
    index: f64,
    /// Paths of the walk for each albedo
    #[arg(long, value_name = "PATHS", default_value_t = 400_000, value_parser = clap::value_parser!(u32).range(64..))]
    paths: u32,
    /// Seed of the walk
    #[arg(long, value_name = "SEED", default_value_t = 0)]
    seed: u64,
}

/// Measures and prints tables in Markdown.
pub(super) fn run(args: &Args) -> Result<()> {
    let &Args { ref albedos, mean_cosine, index, paths, seed } = args;
    if !albedos.iter().all(|albedo| (0.0..1.0).contains(albedo) && *albedo > 0.0) {
        return Err(Error::usage("albedos must be above 0 and below 1"));
    }
    if !(-0.95..=0.95).contains(&mean_cosine) {
        return Err(Error::usage("mean-cosine must be from -0.95 to 0.95"));
    }
    if !(1.0..=3.0).contains(&index) {
        return Err(Error::usage("index must be from 1 to 3"));
    }
    let bench = DiffusionBench { albedos: albedos.clone(), mean_cosine, eta: index, paths: paths as usize, seed };
    console::print(&table(&bench.run()))
}
