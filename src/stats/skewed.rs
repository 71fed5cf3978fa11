//! Confidence intervals of a mean and Welch's test for skewed samples: few large contributions among many small ones,
//! as in images with fireflies.
//!
//! The t statistic of a right-skewed sample is skewed to the left, increasingly so in the tail: without the large
//! contributions, mean and standard error are both too small. To first order P(T ≤ x) = Φ(x) + λ/6 (2x² + 1) φ(x) with
//! λ the skewness of the difference of the means [Zhou05]. Hall's monotone cubic removes this term [Hall92]. A test is
//! corrected in the conservative direction only: a λ that would increase its statistic counts as 0.
//!
//! Limits: λ comes from the caller, who must account for contributions that the sample may have missed. Beyond a
//! statistic of 3/λ the cubic of a test is flat, so that its result is at most 1/λ − λ/6. A test of a mean of fewer
//! than some 40 contributions never rejects.

use super::{Estimate, TestResult, student_p_value, student_quantile, welch_test};

/// Bounds on the skewness of the difference a − b of two means: its third cumulant over the cube of its standard
/// deviation.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Skewness {
    /// From the right tail of a (a may be too low): at least 0.
    pub of_a: f64,
    /// From the right tail of b (b may be too low): at least 0.
    pub of_b: f64,
}

/// Tests whether two independent estimates have the same expectation, given the skewness of their difference.
/// Differences up to `slack` are ignored.
///
/// # Panics
/// Unless both degrees of freedom are positive.
pub fn skewed_welch_test(a: &Estimate, b: &Estimate, skewness: Skewness, slack: f64) -> TestResult {
    let difference = a.value - b.value;
    let beyond = Estimate { value: b.value + (difference.abs() - slack).max(0.0).copysign(difference), ..*a };
    let plain = welch_test(&beyond, b);
    let lambda = if difference < 0.0 { skewness.of_a } else { skewness.of_b };
    let statistic = straightened(plain.statistic.abs(), lambda).copysign(plain.statistic);
    TestResult { statistic, dof: plain.dof, p_value: student_p_value(statistic, plain.dof) }
}

/// Applies Hall's cubic to t ≥ 0, on the tail that the skewness λ ≥ 0 makes heavy.
fn straightened(t: f64, lambda: f64) -> f64 {
    let x = lambda * t;
    let cubic = if x < SERIES_BELOW { t * (1.0 - x / 3.0) } else { (1.0 - (1.0 - x / 3.0).max(0.0).powi(3)) / lambda };
    (cubic - lambda / 6.0).max(0.0)
}

/// Below this λt the next term, (λt)²/27, is lost to rounding, and the cubic would cancel.
const SERIES_BELOW: f64 = 1e-7;

/// Returns the difference of two means that [`skewed_welch_test`] at the two-sided level `level` detects with
/// probability `power`, whichever mean is larger. It is infinite if the skewness prevents any detection. Exact for
/// normal estimates and large degrees of freedom.
///
/// # Panics
/// Unless 0 < level < 1, 0 < power < 1 and both degrees of freedom are positive.
pub fn detectable_difference(a: &Estimate, b: &Estimate, skewness: Skewness, level: f64, power: f64) -> f64 {
    let standard_error = a.standard_error.hypot(b.standard_error);
    let limit = student_quantile(1.0 - 0.5 * level, welch_test(a, b).dof);
    let needed = bent(limit, skewness.of_a.max(skewness.of_b));
    let spare = student_quantile(power, f64::INFINITY);
    if standard_error > 0.0 { standard_error * (needed + spare) } else { 0.0 }
}

/// Inverse of [`straightened`]; infinite outside its range.
fn bent(statistic: f64, lambda: f64) -> f64 {
    let is_in_reach = lambda * (statistic + lambda / 6.0) < 1.0;
    if is_in_reach { -skewed_quantile(-statistic, lambda) } else { f64::INFINITY }
}

/// Returns the quantile of a studentised mean of skewness λ from the unskewed `quantile`, by the inverse of Hall's
/// cubic [Hall92]. The expectation lies below mean − standard error × result with the probability that the studentised
/// mean exceeds it.
pub fn skewed_quantile(quantile: f64, lambda: f64) -> f64 {
    if lambda.abs() < SERIES_BELOW {
        return quantile;
    }
    let cube = 1.0 + lambda * (quantile - lambda / 6.0);
    3.0 / lambda * (cube.cbrt() - 1.0)
}

#[cfg(test)]
#[path = "skewed_tests.rs"]
mod tests;
