//! Student's t distribution [Student08]: two-sided p-values and quantiles, with the usual 95 % quantiles cached.
//!
//! Quantiles are computed by bisection on the p-value. The inverse incomplete beta function of `statrs` 0.18 does not
//! terminate for some arguments, and its forward evaluation uses too few terms beyond some 10⁴ degrees of freedom.

use statrs::function::{beta::beta_reg, erf::erfc};
use std::f64::consts::SQRT_2;
use std::sync::LazyLock;

/// From here on t is converted to the equivalent z by a series in 1/dof. The relative truncation error is below z⁶ / (8
/// dof³) [Hill70].
const SERIES_FROM: f64 = 1e4;

/// 97.5 % quantiles for 1 ..= 128 degrees of freedom.
static UPPER_95: LazyLock<[f64; 128]> = LazyLock::new(|| std::array::from_fn(|i| upper(0.05, (i + 1) as f64)));

/// Returns the quantile t with P(T ≤ t) = `p` at `dof` degrees of freedom; infinite `dof` gives the normal
/// distribution.
///
/// # Panics
/// Unless 0 < p < 1 and dof > 0.
pub fn student_quantile(p: f64, dof: f64) -> f64 {
    assert!(p > 0.0 && p < 1.0 && dof > 0.0, "quantile {p} at {dof} degrees of freedom");
    let is_cached = p.to_bits() == 0.975_f64.to_bits() && dof.fract().to_bits() == 0 && dof <= UPPER_95.len() as f64;
    if is_cached { UPPER_95[dof as usize - 1] } else { upper(2.0 * p.min(1.0 - p), dof).copysign(p - 0.5) }
}

/// Returns the t ≥ 0 with two-sided p-value `tails`.
fn upper(tails: f64, dof: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    while student_p_value(high, dof) > tails && high < 1e300 {
        (low, high) = (high, 2.0 * high);
    }
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return high;
        }
        if student_p_value(middle, dof) > tails { low = middle } else { high = middle }
    }
}

/// Returns P(|T| ≥ |t|) at `dof` degrees of freedom; infinite `dof` gives the normal distribution.
///
/// # Panics
/// Unless dof > 0.
pub fn student_p_value(t: f64, dof: f64) -> f64 {
    assert!(dof > 0.0, "{dof} degrees of freedom");
    match t.abs() {
        t if t.is_nan() => f64::NAN,
        t if t.is_infinite() => 0.0,
        t if dof >= SERIES_FROM => erfc(equivalent_normal(t, dof) / SQRT_2),
        // The incomplete beta form keeps its relative precision in the tail, where 1 − CDF would cancel [DLMF 8.17].
        t => beta_reg(0.5 * dof, 0.5, dof / (dof + t * t)),
    }
}

/// Returns the z with the same tail probability as t: z² = (dof − ½ + …) ln(1 + t²/dof), accurate for every t [Hill70].
fn equivalent_normal(t: f64, dof: f64) -> f64 {
    if dof.is_infinite() {
        return t;
    }
    let a = dof - 0.5;
    let w = (a * (t * t / dof).ln_1p()).sqrt();
    w + (w * w * w + 3.0 * w) / (48.0 * a * a)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quantiles and tails from printed tables, to all their digits.
    #[test]
    fn agrees_with_tables() {
        for (p, dof, t) in [
            (0.975, 1.0, 12.7062),
            (0.975, 3.0, 3.18245),
            (0.975, 30.0, 2.04227),
            (0.95, 10.0, 1.81246),
            (0.975, f64::INFINITY, 1.95996),
        ] {
            assert!((student_quantile(p, dof) - t).abs() < 5.1e-5, "{p} {dof}: {}", student_quantile(p, dof));
            assert!((student_quantile(1.0 - p, dof) + t).abs() < 5.1e-5);
            assert!((student_p_value(t, dof) - 2.0 * (1.0 - p)).abs() < 1e-5);
        }
        assert!((student_p_value(6.0, f64::INFINITY) / 1.973_175e-9 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn quantile_and_p_value_are_inverse() {
        for dof in [1.0, 2.5, 7.0, 63.0, 4095.0, 1e8, 1e11] {
            for p in [0.6, 0.9, 0.975, 0.999_9] {
                let back = student_p_value(student_quantile(p, dof), dof);
                // Bisection ends between neighbouring floats; beyond that, errors of ln Γ grow with dof ln(dof) ε.
                assert!((back / (2.0 * (1.0 - p)) - 1.0).abs() < 1e-9, "{dof} {p} {back}");
            }
        }
    }

    /// The series joins the incomplete beta function where it takes over.
    #[test]
    fn series_agrees_with_the_exact_tail() {
        for t in [0.5, 1.0, 2.0, 4.0, 6.0] {
            let (exact, series) =
                (student_p_value(t, SERIES_FROM * 0.999_999), student_p_value(t, SERIES_FROM * 1.000_001));
            // Moving dof by 2e-6 relative changes ln p by about t⁴/(4 dof) × 2e-6 < 1e-7; ln Γ adds 1e-10.
            assert!((series / exact - 1.0).abs() < 2e-7, "{t}: {exact} {series}");
        }
    }

    /// The iteration of the inverse incomplete beta function in `statrs` 0.18 hangs for some of these.
    #[test]
    fn student_quantile_terminates_for_all_arguments() {
        for dof in [0.1, 1.0, 2.5, 300.0, 9_999.0, 1e5, 1e15, f64::INFINITY] {
            for p in [1e-12, 0.3, 0.5, 0.75, 1.0 - 1e-12] {
                let t = student_quantile(p, dof);
                assert!(t.is_finite() && (t >= 0.0) == (p >= 0.5), "{p} {dof}: {t}");
            }
        }
    }
}
