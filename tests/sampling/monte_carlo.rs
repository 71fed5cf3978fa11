//! The estimators of examples/monte_carlo: their means are the closed forms, and their errors fall as theory says.

use etendue::stats::Estimate;
use etendue_testing::chi_square::sidak;
use etendue_testing::estimators::{Example, pi, power_of_four, products};
use etendue_testing::slope::slope;
use statrs::distribution::{ContinuousCDF, Normal};

const DRAWS: u32 = 1 << 19;
const REPLICATES: u32 = 32;

fn all() -> Vec<Example> {
    let [narrow, wide] = products().map(|product| product.estimators());
    [pi(), power_of_four()].into_iter().chain(narrow).chain(wide).collect()
}

fn name(example: &Example) -> String {
    format!("{}, {}", example.integral, example.estimator)
}

/// Whether an estimate is compatible with `exact` at the family's level over `tests` tests. Independent draws have 2¹⁹
/// degrees of freedom. Sobol' estimates have 31; their intervals are t intervals of that level.
fn compatible(estimate: &Estimate, exact: f64, tests: usize) -> bool {
    const ROUNDING: f64 = 1e-12; // f64 sums and the error function, where an estimator has no error
    let [low, high] = estimate.interval(1.0 - sidak(tests));
    (low - ROUNDING..=high + ROUNDING).contains(&exact)
}

/// Planted: an integral that is a tenth off (the worst estimator has a relative standard error of 2 %).
#[test]
fn every_estimator_has_the_exact_integral_for_its_mean() {
    let examples = all();
    for example in &examples {
        let draws = DRAWS / example.samples;
        let [a, b] = [example.independent(1, draws), example.sobol(1, draws, REPLICATES)];
        for (estimate, way) in [(a, "independent"), (b, "Sobol")] {
            let what = format!("{}, {way}: {estimate:?} for {}", name(example), example.exact);
            assert!(compatible(&estimate, example.exact, 2 * examples.len()), "{what}");
            assert!(!compatible(&estimate, 1.1 * example.exact, 2 * examples.len()), "not convicted: {what}");
        }
    }
}

/// The numbers that the tutorial gives, or that follow from its text.
#[test]
fn exact_values_are_those_of_the_tutorial() {
    let exact: Vec<f64> = all().iter().map(|e| e.exact).collect();
    let normal = Normal::standard();
    let narrow = (normal.cdf(2.0) - normal.cdf(1.9)) * 10.0;
    let expected =
        [std::f64::consts::PI, 1.0, narrow, narrow, narrow, narrow, 1.0 / 6.0, 1.0 / 6.0, 1.0 / 6.0, 1.0 / 6.0];
    assert!(exact.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{exact:?}"); // erf's own error
}

/// Each density is good for one of the products and bad for the other; both heuristics are good for both, and the
/// balance heuristic is no worse than any other combination by more than (1 / min nᵢ − 1 / Σ nᵢ) I² = I² / 2 [Veach97
/// §9.2.2].
#[test]
fn a_combination_is_good_where_one_of_its_densities_is() {
    for (product, good) in products().into_iter().zip([1, 0]) {
        let examples = product.estimators();
        let squared = examples[0].exact.powi(2);
        // of one sample, relative to the integral
        let variance =
            |e: &Example| e.independent(3, DRAWS / 8).standard_error.powi(2) * f64::from(DRAWS / 8) / squared;
        let [gaussian, uniform, balance, power] = examples.each_ref().map(variance);
        let (good, bad) = if good == 1 { (uniform, gaussian) } else { (gaussian, uniform) };
        println!("relative variances: {good:.2e} alone, {bad:.2e} alone, balance {balance:.2e}, power {power:.2e}");
        assert!(good < 0.01 * bad && balance < 0.01 * bad && power < 0.01 * bad, "{good} {bad} {balance} {power}"); // the claim
        assert!(balance < power + 0.5, "{balance} {power}");
    }
}

/// Mean squared error over 64 runs at 2⁴ to 2¹² draws. The logarithm of each mean deviates by √(2/64) = 0.18 for normal
/// errors, so that the slope over these nine doublings deviates by 0.18 / (ln 2 √60) = 0.033.
fn mean_squares(example: &Example, run: impl Fn(u64, u32) -> f64) -> f64 {
    let mse = |n: u32| (0..64).map(|i| (run(100 + i, n) - example.exact).powi(2)).sum::<f64>() / 64.0;
    let points: Vec<(f64, f64)> = (4..=12).map(|k| 1 << k).map(|n: u32| (f64::from(n), mse(n))).collect();
    slope(&points)
}

/// Independent: −1 within four deviations, level 6e-5 each. Sobol': −3 for the smooth integral in one dimension, −3/2
/// for the circle's edge in two [Owen97]; four deviations and what the first few points are off the asymptote.
#[test]
fn errors_fall_as_theory_says() {
    let deviations = 4.0 * 0.033;
    for (example, sobol) in [(pi(), -1.5), (power_of_four(), -3.0)] {
        let independent = mean_squares(&example, |seed, n| example.independent(seed, n).value);
        let scrambled = mean_squares(&example, |seed, n| example.sobol(seed, n, 2).value);
        println!("{}: slopes {independent:.3} and {scrambled:.3}", name(&example));
        assert!((independent + 1.0).abs() < deviations, "{}: {independent}", name(&example));
        assert!((scrambled - sobol).abs() < deviations + 0.1, "{}: {scrambled}, not {sobol}", name(&example));
    }
}
