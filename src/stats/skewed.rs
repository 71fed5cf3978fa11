//! Intervals of a mean and Welch's test of two where the samples behind them may be skewed: few large contributions in many small
//! ones, as in pictures with fireflies.
//!
//! The t statistic of a right-skewed sample is skewed to the left, the more the further out one looks: where the large
//! contributions are missing, mean and standard error are too small together. To first order P(T ≤ x) = Φ(x) + λ/6 (2x² + 1) φ(x)
//! with λ the skewness of the difference of the means [Zhou05], and Hall's monotone cubic takes that out [Hall92]. A test takes only
//! the direction that makes it more careful: a λ that would make it bolder counts as 0.
//!
//! Limits: λ comes from the caller, who must know of contributions that the sample may have missed. Beyond a statistic of 3/λ the
//! cubic of a test is flat, so that nothing above 1/λ − λ/6 can come out, and a mean of fewer than some 40 contributions convicts
//! nobody.

use super::{Estimate, TestResult, student_p_value, student_quantile, welch_test};

/// How skewed the difference a − b of two means may be: its third cumulant over the cube of its standard deviation.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Skewness {
    /// By the right tail of a (a may be too low): at least 0.
    pub of_a: f64,
    /// By the right tail of b (b may be too low): at least 0.
    pub of_b: f64,
}

/// Whether two independent estimates, whose difference may have that skewness, have the same expectation; differences up to
/// `slack` count as none.
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

/// The statistic that Hall's cubic makes of t ≥ 0 on the tail that the skewness λ ≥ 0 makes heavy.
fn straightened(t: f64, lambda: f64) -> f64 {
    let x = lambda * t;
    let cubic = if x < SERIES_BELOW { t * (1.0 - x / 3.0) } else { (1.0 - (1.0 - x / 3.0).max(0.0).powi(3)) / lambda };
    (cubic - lambda / 6.0).max(0.0)
}

/// Below this λt the next term, (λt)²/27, is lost in rounding, and the cubic would cancel.
const SERIES_BELOW: f64 = 1e-7;

/// The difference of two means that [`skewed_welch_test`] at the two-sided level `level` finds with probability `power`,
/// whichever mean is the larger; infinite where the skewness keeps it from ever finding one. Exact for normal estimates and large
/// degrees of freedom.
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

/// The inverse of [`straightened`]; infinite beyond its reach.
fn bent(statistic: f64, lambda: f64) -> f64 {
    let is_in_reach = lambda * (statistic + lambda / 6.0) < 1.0;
    if is_in_reach { -skewed_quantile(-statistic, lambda) } else { f64::INFINITY }
}

/// The quantile of a studentised mean of skewness λ of which the unskewed one is `quantile`: Hall's cubic backwards [Hall92].
/// The mean's expectation lies below mean − standard error × this with the probability of its lying below.
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
