//! Pearson's χ² test of counts against expectations [Pearson00].

use super::TestResult;
use statrs::function::gamma::checked_gamma_ur;

/// Least expectation of a bin; bins below it are pooled, so that the χ² distribution is accurate [Cochran54].
const LEAST_EXPECTED: f64 = 5.0;

/// Returns P(χ² ≥ statistic) at `dof` degrees of freedom; 1 at 0 degrees of freedom.
pub fn chi_squared_p_value(statistic: f64, dof: f64) -> f64 {
    if dof <= 0.0 || statistic <= 0.0 {
        return 1.0;
    }
    checked_gamma_ur(0.5 * dof, 0.5 * statistic).unwrap_or(0.0)
}

/// Tests whether `observed` counts come from a distribution with the `expected` counts (of the same total).
/// Neighbouring bins are pooled until each expects at least 5. An observation where none is expected gives p = 0.
///
/// # Panics
/// Unless both have the same length.
pub fn chi_squared_test(observed: &[u64], expected: &[f64]) -> TestResult {
    assert_eq!(observed.len(), expected.len());
    let impossible = observed.iter().zip(expected).any(|(&o, &e)| o > 0 && e <= 0.0);
    let bins = pool(observed, expected);
    let statistic: f64 = bins.iter().map(|[o, e]| (o - e) * (o - e) / e).sum();
    let dof = bins.len() as f64 - 1.0;
    if impossible {
        return TestResult { statistic: f64::INFINITY, dof, p_value: 0.0 };
    }
    TestResult { statistic, dof, p_value: chi_squared_p_value(statistic, dof) }
}

/// Pools neighbouring bins as [observed, expected]; the remainder at the end joins the last pool.
fn pool(observed: &[u64], expected: &[f64]) -> Vec<[f64; 2]> {
    let mut bins: Vec<[f64; 2]> = Vec::new();
    let mut open = [0.0, 0.0];
    for (&o, &e) in observed.iter().zip(expected) {
        open = [open[0] + o as f64, open[1] + e];
        if open[1] >= LEAST_EXPECTED {
            bins.push(std::mem::take(&mut open));
        }
    }
    match bins.last_mut() {
        Some(last) => *last = [last[0] + open[0], last[1] + open[1]],
        None => bins.push(open),
    }
    bins.retain(|bin| bin[1] > 0.0);
    bins
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::test_random::Random;

    #[test]
    fn agrees_with_tables() {
        for (statistic, dof, p) in [(3.841_459, 1.0, 0.05), (18.307_04, 10.0, 0.05), (13.276_70, 4.0, 0.01)] {
            // The tables round the statistic by up to 5e-6, and |d ln p / dχ²| < 0.7 here.
            assert!((chi_squared_p_value(statistic, dof) / p - 1.0).abs() < 3.5e-6);
        }
    }

    /// A fair die gives p < 0.05 in 5 % of trials: two-sided binomial test at level 1e-6 (4.9 σ); at 600 throws the χ²
    /// approximation is off by less than 0.2 % absolute [Cochran54].
    #[test]
    fn holds_its_level_and_sees_a_loaded_die() {
        let mut random = Random::new(4);
        let (trials, mut rejected) = (4000, 0);
        for _ in 0..trials {
            let mut counts = [0; 6];
            (0..600).for_each(|_| counts[(random.uniform() * 6.0) as usize] += 1);
            rejected += u32::from(chi_squared_test(&counts, &[100.0; 6]).p_value < 0.05);
        }
        let n = f64::from(trials);
        assert!((f64::from(rejected) - 0.05 * n).abs() < 4.9 * (n * 0.05 * 0.95).sqrt() + 0.002 * n, "{rejected}");
        assert!(chi_squared_test(&[200, 80, 80, 80, 80, 80], &[100.0; 6]).p_value < 1e-9);
    }

    #[test]
    fn small_bins_are_pooled_and_impossible_ones_refused() {
        let test = chi_squared_test(&[1, 2, 3, 4, 0], &[1.0, 2.0, 3.0, 4.0, 0.0]);
        assert!((test.dof - 0.0).abs() < f64::EPSILON && test.statistic < 1e-12);
        assert!(chi_squared_test(&[10, 1], &[11.0, 0.0]).p_value < f64::MIN_POSITIVE);
    }
}
