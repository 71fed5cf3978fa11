//! Quadrature and root finding in f64 for the set-up of the models.

use std::f64::consts::FRAC_PI_2;

/// Step of the trapezoidal rule in the variable of [`integrate`].
const STEP: f64 = 1.0 / 16.0;

/// Half the number of nodes of [`integrate`]: the last weight is below 1e-18 of the first.
const HALF: i32 = 54;

/// Returns the integral of `f` over [a, b] by the double exponential rule [TakahasiMori74]. The relative error is about
/// 1e-14 for integrands that are analytic inside the interval. Singularities of integrable size may lie at its ends.
pub(super) fn integrate(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    let length = b - a;
    let mut sum = 0.0;
    for k in -HALF..=HALF {
        let t = f64::from(k) * STEP;
        let exponent = FRAC_PI_2 * t.sinh();
        // The distance from the nearer end, which keeps its digits.
        let share = 1.0 / (1.0 + (2.0 * exponent.abs()).exp());
        let x = if exponent < 0.0 { a + length * share } else { b - length * share };
        // The rule ends where rounding puts a node on the end of the interval.
        if x <= a || x >= b {
            continue;
        }
        sum += f(x) * FRAC_PI_2 * t.cosh() / exponent.cosh().powi(2);
    }
    0.5 * length * STEP * sum
}

/// Returns the integral of `f` over (0, ∞) by the trapezoidal rule in ln x, for integrands that fall at least like e⁻ˣ
/// and are bounded near 0. Features may have any scale from 1e-8 to 10. The relative error is about e^(−π² / step),
/// 1e-12, for integrands that are analytic within |arg x| < π / 2 [TrefethenWeideman14].
pub(super) fn integrate_to_infinity(f: impl Fn(f64) -> f64) -> f64 {
    const STEP: f64 = 0.35;
    /// ln of the smallest node: the part below it is 3e-17 of the bound of the integrand.
    const FIRST: f64 = -38.0;
    /// Nodes up to x = e^3.65 = 38, beyond which e⁻ˣ is below 1e-16.
    const NODES: i32 = 120;
    let mut sum = 0.0;
    for k in 0..NODES {
        let x = (FIRST + STEP * f64::from(k)).exp();
        sum += f(x) * x;
    }
    STEP * sum
}

/// Returns the root of the increasing function `f` in [low, high], where `f` returns its value and derivative. Newton's
/// steps are replaced by bisection when they leave the bracket. The result is exact to 1.5e-14 of the larger end, which
/// is beyond the rounding of `f`.
///
/// The nearer end is returned if the bracket holds no root.
pub(super) fn increasing_root(mut low: f64, mut high: f64, f: impl Fn(f64) -> (f64, f64)) -> f64 {
    let tolerance = 64.0 * f64::EPSILON * low.abs().max(high.abs());
    let mut x = 0.5 * (low + high);
    for _ in 0..200 {
        let (value, slope) = f(x);
        if value < 0.0 {
            low = x;
        } else {
            high = x;
        }
        let newton = x - value / slope;
        // At the root rounding decides which side of the bracket the step falls on.
        if (newton - x).abs() <= tolerance {
            return x;
        }
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if high - low <= tolerance {
            return next;
        }
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bounds from the error of the rules as stated, times ten.
    #[test]
    fn integrals_are_exact() {
        assert!((integrate(0.0, 1.0, f64::ln) + 1.0).abs() < 1e-13);
        assert!((integrate(-1.0, 2.0, |x| x * x) - 3.0).abs() < 1e-13);
        assert!((integrate_to_infinity(|x| (-x).exp()) - 1.0).abs() < 1e-10);
        let narrow = integrate_to_infinity(|x| (-x).exp() * 1e-6 / (x * x + 1e-12));
        let expected = FRAC_PI_2 + 1e-6 * (1e-6f64.ln() + 0.577_215_664_9 - 1.0);
        assert!((narrow / expected - 1.0).abs() < 1e-10, "{narrow}");
    }

    #[test]
    fn roots_are_exact() {
        let root = increasing_root(0.0, 2.0, |x| (x * x * x - 2.0, 3.0 * x * x));
        assert!((root - 2f64.cbrt()).abs() < 1e-14);
    }
}
