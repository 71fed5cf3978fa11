//! Power-law fits y = a xᵇ by least squares in log y against log x: error as a function of time or of samples.
//! Independent sampling has b = −1 for squared errors. Good low-discrepancy points are steeper, and bias flattens the
//! end of the curve.
//!
//! [`PowerLaw::fit`] requires independent points. Points of one render at growing sample counts are correlated, since
//! each includes the earlier samples. For such curves fit several independent renders and take the error from their
//! scatter: [`PowerLaw::of_curves`].

use super::{Estimate, Moments};

/// A point of a curve; `weight` is the inverse variance of ln y, up to a common factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeightedPoint {
    /// Time or samples, positive.
    pub x: f64,
    /// Error, positive.
    pub y: f64,
    /// Weight; points without a positive weight are ignored.
    pub weight: f64,
}

/// The fitted power law.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct PowerLaw {
    /// The exponent b with its standard error.
    pub slope: Estimate,
    /// The factor a: y at x = 1.
    pub factor: f64,
}

/// Sums of a weighted regression line, about the weighted means.
struct Line {
    slope: f64,
    /// ln a.
    intercept: f64,
    /// Σ w (ln x − mean)².
    spread: f64,
    /// Σ w (residual)².
    residual: f64,
    points: usize,
}

impl PowerLaw {
    /// Fits independent points. The scale of their variance is estimated from the residuals, with n − 2 degrees of
    /// freedom. `None` below three usable points (positive and finite) or without spread in x.
    pub fn fit(points: &[WeightedPoint]) -> Option<PowerLaw> {
        let line = Line::through(points).filter(|line| line.points >= 3)?;
        let dof = line.points as f64 - 2.0;
        let standard_error = (line.residual / dof / line.spread).sqrt();
        Some(PowerLaw { slope: Estimate { value: line.slope, standard_error, dof }, factor: line.intercept.exp() })
    }

    /// Averages the fits of several independent curves. The error comes from their scatter, with curves − 1 degrees of
    /// freedom. Points within a curve may be correlated. `None` below two curves with two usable points each.
    pub fn of_curves(curves: &[Vec<WeightedPoint>]) -> Option<PowerLaw> {
        let lines: Vec<Line> = curves.iter().filter_map(|points| Line::through(points)).collect();
        let slope = lines.iter().map(|line| line.slope).collect::<Moments>().estimate()?;
        let intercept = lines.iter().map(|line| line.intercept).collect::<Moments>().mean();
        Some(PowerLaw { slope, factor: intercept.exp() })
    }
}

impl Line {
    fn through(points: &[WeightedPoint]) -> Option<Line> {
        let is_usable = |p: &&WeightedPoint| [p.x, p.y, p.weight].iter().all(|v| v.is_finite() && *v > 0.0);
        let logs: Vec<[f64; 3]> = points.iter().filter(is_usable).map(|p| [p.weight, p.x.ln(), p.y.ln()]).collect();
        let sum = |f: &dyn Fn(&[f64; 3]) -> f64| logs.iter().map(f).sum::<f64>();
        let total = sum(&|l| l[0]);
        let (x, y) = (sum(&|l| l[0] * l[1]) / total, sum(&|l| l[0] * l[2]) / total);
        let spread = sum(&|l| l[0] * (l[1] - x) * (l[1] - x));
        if logs.len() < 2 || spread <= 0.0 {
            return None;
        }
        let slope = sum(&|l| l[0] * (l[1] - x) * (l[2] - y)) / spread;
        let off_line = |l: &[f64; 3]| l[2] - y - slope * (l[1] - x);
        let residual = sum(&|l| l[0] * off_line(l) * off_line(l));
        Some(Line { slope, intercept: y - slope * x, spread, residual, points: logs.len() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::test_random::Random;

    fn point(x: f64, y: f64, weight: f64) -> WeightedPoint {
        WeightedPoint { x, y, weight }
    }

    /// Relative rounding of some hundred operations whose condition is below 100.
    const ROUNDING: f64 = 1e4 * f64::EPSILON;

    #[test]
    fn exact_power_law_is_recovered_with_any_weights() {
        let law = |x: f64| 3.5 * x.powf(-1.25);
        let points: Vec<_> =
            (0..6).map(|i| point(f64::from(1 << i), law(f64::from(1 << i)), f64::from(i + 1))).collect();
        let fit = PowerLaw::fit(&points).unwrap();
        assert!((fit.slope.value + 1.25).abs() < ROUNDING && (fit.factor / 3.5 - 1.0).abs() < ROUNDING, "{fit:?}");
        assert!(fit.slope.standard_error < 1e-7, "√ of the rounding of Σ residual²: {fit:?}");
    }

    /// By hand: ln y = (0, 1, 0) at ln x = (0, 1, 2) with weights (1, 1, 2). Means 5/4 and 1/4; Σwxx = 2 3/4 and
    /// Σwxy = −1/4 about them, so b = −1/11; residuals (−4, 8, −2)/11 give Σw r² = 88/121; s² = 8/11 at one degree of
    /// freedom, and Var b = 8/11 / (11/4) = 32/121.
    #[test]
    fn weights_enter_as_the_closed_form_says() {
        let e = std::f64::consts::E;
        let fit = PowerLaw::fit(&[point(1.0, 1.0, 1.0), point(e, e, 1.0), point(e * e, 1.0, 2.0)]).unwrap();
        assert!((fit.slope.value + 1.0 / 11.0).abs() < ROUNDING, "{fit:?}");
        assert!((fit.slope.standard_error - (32.0_f64 / 121.0).sqrt()).abs() < ROUNDING, "{fit:?}");
        assert!((fit.factor.ln() - (0.25 + 1.25 / 11.0)).abs() < ROUNDING, "{fit:?}");
        assert_eq!(fit.slope.dof.to_bits(), 1.0_f64.to_bits());
    }

    #[test]
    fn unusable_points_are_left_out() {
        let good = [point(1.0, 1.0, 1.0), point(2.0, 0.5, 1.0), point(4.0, 0.25, 1.0)];
        let bad = [point(8.0, -1.0, 1.0), point(0.0, 1.0, 1.0), point(8.0, f64::NAN, 1.0), point(8.0, 7.0, 0.0)];
        assert_eq!(PowerLaw::fit(&[&good[..], &bad].concat()), PowerLaw::fit(&good));
        assert_eq!(PowerLaw::fit(&good[..2]), None);
        assert_eq!(PowerLaw::fit(&[good[0]; 5]), None);
        assert_eq!(PowerLaw::of_curves(&[good.to_vec()]), None);
    }

    /// Two-sided binomial test of "95 % of the intervals hold the slope" at level 1e-6 (4.9 σ).
    fn covers(trials: u32, mut slope: impl FnMut() -> Estimate, truth: f64) {
        let holds = |estimate: Estimate| {
            let [low, high] = estimate.interval95();
            (low..high).contains(&truth)
        };
        let hits = (0..trials).filter(|_| holds(slope())).count() as f64;
        let (n, p) = (f64::from(trials), 0.95);
        assert!((hits - n * p).abs() < 4.9 * (n * p * (1.0 - p)).sqrt(), "{hits} of {trials}");
    }

    /// Noise of ln y with standard deviation 0.05 to 0.8, with the corresponding weights.
    #[test]
    fn intervals_of_independent_points_cover_at_their_level() {
        let mut random = Random::new(5);
        let mut slope = || {
            let noisy = |i: i32| {
                let deviation = 0.05 * f64::from(1 << (i % 5));
                let x = 2.0_f64.powi(i);
                point(x, (deviation * random.normal()).exp() / x, 1.0 / (deviation * deviation))
            };
            PowerLaw::fit(&(0..7).map(noisy).collect::<Vec<_>>()).unwrap().slope
        };
        covers(10_000, &mut slope, -1.0);
    }

    /// Curves like those of a render: the error at 2N samples combines that at N with as many new samples, so that
    /// neighbouring points are correlated. Here it is the ln of a mean of squares of 64 pixels' running means, for five
    /// renders.
    #[test]
    fn intervals_of_curves_cover_though_their_points_depend_on_each_other() {
        let mut random = Random::new(6);
        let mut curve = || {
            let mut sums = [0.0; 64];
            let mut grow = |i: i32| {
                let n = 2.0_f64.powi(i);
                let fresh = if i == 0 { 1.0 } else { 0.5 * n };
                sums.iter_mut().for_each(|s| *s += fresh.sqrt() * random.normal());
                point(n, sums.iter().map(|s| s * s / (n * n)).sum::<f64>() / 64.0, 1.0)
            };
            (0..6).map(&mut grow).collect::<Vec<_>>()
        };
        let slope = || PowerLaw::of_curves(&[curve(), curve(), curve(), curve(), curve()]).unwrap().slope;
        // E ln χ²₆₄/64 is the same at every point, so the slope is −1 without bias.
        covers(10_000, slope, -1.0);
    }
}
