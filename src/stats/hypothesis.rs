//! Tests of means. Each returns its statistic and a two-sided p-value. The caller chooses the level and corrects for
//! multiple tests ([`super::holm`]).

use super::{Estimate, student_p_value};

/// Result of a hypothesis test.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TestResult {
    /// The test statistic, t.
    pub statistic: f64,
    /// Degrees of freedom of the statistic.
    pub dof: f64,
    /// Probability of a statistic at least this extreme under the null hypothesis.
    pub p_value: f64,
}

/// Tests whether `estimate` has the expectation `expected` [Student08].
///
/// # Panics
/// Unless the degrees of freedom are positive.
pub fn t_test(estimate: &Estimate, expected: f64) -> TestResult {
    difference_test(estimate.value - expected, estimate.standard_error, estimate.dof)
}

/// Tests whether two independent estimates with different variances have the same expectation [Welch47].
///
/// # Panics
/// Unless both degrees of freedom are positive.
pub fn welch_test(a: &Estimate, b: &Estimate) -> TestResult {
    let (va, vb) = (a.standard_error * a.standard_error, b.standard_error * b.standard_error);
    // Welch–Satterthwaite; the two extremes when both variances vanish are handled by the statistic.
    let spread = va * va / a.dof + vb * vb / b.dof;
    let dof = if spread > 0.0 { (va + vb) * (va + vb) / spread } else { f64::INFINITY };
    difference_test(a.value - b.value, (va + vb).sqrt(), dof)
}

fn difference_test(difference: f64, standard_error: f64, dof: f64) -> TestResult {
    let exact = difference.to_bits() << 1 == 0;
    let statistic = if exact { 0.0 } else { difference / standard_error };
    TestResult { statistic, dof, p_value: student_p_value(statistic, dof) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::Moments;
    use crate::stats::test_random::Random;

    fn sample(random: &mut Random, n: usize, mean: f64, deviation: f64) -> Estimate {
        (0..n).map(|_| mean + deviation * random.normal()).collect::<Moments>().estimate().unwrap()
    }

    /// Under the hypothesis 5 % of p-values are below 0.05: two-sided binomial test at level 1e-6 (4.9 σ). Welch's dof
    /// is an approximation; at these sizes its level error is below 0.3 % absolute [Welch47], added to the bound.
    #[test]
    fn tests_hold_their_level() {
        let mut random = Random::new(2);
        let trials = 10_000;
        let (mut t, mut welch) = (0, 0);
        for _ in 0..trials {
            let a = sample(&mut random, 8, 1.0, 1.0);
            let b = sample(&mut random, 16, 1.0, 3.0);
            t += u32::from(t_test(&a, 1.0).p_value < 0.05);
            welch += u32::from(welch_test(&a, &b).p_value < 0.05);
        }
        let n = f64::from(trials);
        let noise = 4.9 * (n * 0.05 * 0.95).sqrt();
        assert!((f64::from(t) - 0.05 * n).abs() < noise, "{t}");
        assert!((f64::from(welch) - 0.05 * n).abs() < noise + 0.003 * n, "{welch}");
    }

    #[test]
    fn a_difference_is_seen() {
        let mut random = Random::new(3);
        let a = sample(&mut random, 32, 1.0, 1.0);
        assert!(t_test(&a, 4.0).p_value < 1e-9);
        let exact = Estimate { value: 2.0, standard_error: 0.0, dof: 3.0 };
        assert!((t_test(&exact, 2.0).p_value - 1.0).abs() < f64::EPSILON);
        assert!(t_test(&exact, 2.5).p_value < f64::MIN_POSITIVE);
        assert!(welch_test(&exact, &exact).p_value > 0.5);
    }
}
