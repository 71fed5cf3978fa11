//! The Monte Carlo examples of the tutorial that the renderer grew from, made of the renderer's own samplers,
//! heuristics and statistics: π by a circle, ∫ 5x⁴, and multiple importance sampling of a product of two densities.
//!
//! `cargo run --example monte_carlo -- out.svg` prints estimate, standard error, exact value and error against the
//! number of samples, and draws how the error falls: with n^-1/2 for independent numbers, faster for Owen-scrambled
//! Sobol' points where the integrand is smooth.

mod picture;

use etendue_testing::estimators::{Example, pi, power_of_four, products};
use picture::{Panel, Series};
use std::error::Error;

const SEED: u64 = 1;
/// Numbers of samples: 2⁴ to 2¹⁶ by fours.
const EXPONENTS: [u32; 7] = [4, 6, 8, 10, 12, 14, 16];
/// Scramblings whose scatter is the error of Sobol' points.
const REPLICATES: u32 = 8;
/// Independent runs whose root-mean-square error is drawn.
const RUNS: u64 = 32;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1);
    let [narrow, wide] = products().map(|product| product.estimators());
    for example in [pi(), power_of_four()].iter().chain(&narrow).chain(&wide) {
        print(example);
    }
    let Some(path) = path else { return Ok(()) };
    let panels = [panel(&[pi()]), panel(&[power_of_four()]), panel(&narrow), panel(&wide)];
    picture::draw(&path, &panels).map_err(|e| format!("{path}: {e}"))?;
    println!("picture: {path}");
    Ok(())
}

fn print(example: &Example) {
    println!("{}, {}: exact {:.9}", example.integral, example.estimator, example.exact);
    println!(
        "  {:>7} {:>12} {:>10} {:>10}   {:>12} {:>10} {:>10}",
        "n", "independent", "std error", "error", "Sobol", "std error", "error"
    );
    for n in EXPONENTS.map(|k| 1 << k) {
        let draws = n / example.samples;
        let [a, b] = [example.independent(SEED, draws), example.sobol(SEED, draws, REPLICATES.min(draws / 2))];
        let [p, q] = [a, b].map(|estimate| estimate.value - example.exact);
        let (x, y) = (a.standard_error, b.standard_error);
        println!("  {n:>7} {:>12.8} {x:>10.2e} {p:>+10.2e}   {:>12.8} {y:>10.2e} {q:>+10.2e}", a.value, b.value);
    }
    println!();
}

/// Relative root-mean-square error over the runs at each number of samples.
fn convergence(example: &Example, run: impl Fn(u64, u32) -> f64) -> Vec<(f64, f64)> {
    let error = |n: u32| {
        let squares: f64 = (0..RUNS).map(|i| (run(SEED + i, n / example.samples) / example.exact - 1.0).powi(2)).sum();
        (f64::from(n), (squares / RUNS as f64).sqrt())
    };
    EXPONENTS.map(|k| error(1 << k)).to_vec()
}

/// Every estimator with independent numbers; a single one with Sobol' points, too.
fn panel(examples: &[Example]) -> Panel {
    let of = |e: &Example| Series {
        name: e.estimator.into(),
        points: convergence(e, |seed, n| e.independent(seed, n).value),
    };
    let mut series: Vec<Series> = examples.iter().map(of).collect();
    if let [only] = examples {
        series[0].name = "independent".into();
        let points = convergence(only, |seed, n| only.sobol(seed, n, 2).value);
        series.push(Series { name: "Owen-scrambled Sobol'".into(), points });
    }
    Panel { title: examples[0].integral.clone(), series }
}
