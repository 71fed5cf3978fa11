//! Statistics of one error curve over its repetitions.

use super::contestant::BenchCase;
use super::mark::Mark;
use crate::stats::{Moments, PowerLaw, WeightedPoint};
use serde::Serialize;

/// A positive quantity with its 95 % confidence interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interval {
    /// The geometric mean over repetitions.
    pub value: f64,
    /// Lower end of the 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// A fitted exponent with its 95 % confidence interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Slope {
    /// The exponent.
    pub value: f64,
    /// Lower end of the 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Statistics of all repetitions at one sample count.
#[derive(Debug, Clone, Serialize)]
pub struct CurvePoint {
    /// Samples per pixel.
    pub spp: u64,
    /// Processor time in seconds, geometric mean.
    pub cpu_seconds: f64,
    /// Wall-clock time in seconds, geometric mean.
    pub wall_seconds: f64,
    /// relMSE; `None` where it is lost in the reference's noise.
    pub relmse: Option<Interval>,
}

/// Error against time of one method with one backend on one scene.
#[derive(Debug, Clone, Serialize)]
pub struct ErrorCurve {
    /// Method and backend.
    pub label: String,
    /// Blind spots of the method in the scene. The curve then levels off at the missing light and is left out of
    /// ratios.
    pub blind_spots: Vec<String>,
    /// The curve.
    pub points: Vec<CurvePoint>,
    /// Exponent of error against processor time.
    pub slope_in_time: Option<Slope>,
    /// Exponent of error against samples: −1 for independent samples.
    pub slope_in_samples: Option<Slope>,
    /// 1 / (relMSE × processor seconds) at the last point.
    pub efficiency: Option<Interval>,
    /// Million rays per second of wall-clock time.
    pub mrays_per_second: f64,
    /// Million rays per second of processor time.
    pub mrays_per_cpu_second: f64,
    /// Bytes of film, geometry, textures and ray-tracing structure.
    pub memory_bytes: u64,
    /// Seconds spent on loading.
    pub load_seconds: f64,
    /// Seconds spent on building, which the curve excludes.
    pub build_seconds: f64,
    /// The repetitions.
    pub runs: Vec<Vec<Mark>>,
}

impl Interval {
    /// Returns the geometric mean of positive `values`, with Student's interval of their logarithms; `None` with fewer
    /// than two values, or with one that is not positive.
    pub(super) fn geometric(values: impl IntoIterator<Item = f64>) -> Option<Interval> {
        let logs: Vec<f64> = values.into_iter().map(|v| if v > 0.0 { v.ln() } else { f64::NAN }).collect();
        let estimate = logs.iter().copied().collect::<Moments>().estimate().filter(|e| e.value.is_finite())?;
        let [low, high] = estimate.interval95();
        Some(Interval { value: estimate.value.exp(), low: low.exp(), high: high.exp() })
    }
}

/// 1 / (relMSE × processor seconds) at the last point of a repetition.
pub(super) fn efficiency(run: &[Mark]) -> f64 {
    run.last().map_or(f64::NAN, |m| 1.0 / (m.relmse * m.cpu_seconds))
}

impl ErrorCurve {
    /// Computes the curve of a contestant. `noise` is the reference's error that was subtracted.
    pub(super) fn of(contestant: &BenchCase<'_>, noise: f64) -> ErrorCurve {
        let (runs, info) = (&contestant.runs, &contestant.stage.info);
        let last = || runs.iter().filter_map(|run| run.last());
        let sum = |f: fn(&Mark) -> f64| last().map(f).sum::<f64>();
        let rays = sum(|m| m.rays as f64) / 1e6;
        let layout = contestant.settings.layout();
        let film = crate::film::Film::bytes_per_pixel(&layout, contestant.settings.replicates) * layout.pixels();
        ErrorCurve {
            label: contestant.label(),
            blind_spots: contestant.blind_spots.clone(),
            points: (0..runs.first().map_or(0, Vec::len)).map(|at| point(runs, at)).collect(),
            slope_in_time: slope(runs, noise, |m| m.cpu_seconds),
            slope_in_samples: slope(runs, noise, |m| m.spp as f64),
            efficiency: Interval::geometric(runs.iter().map(|run| efficiency(run))),
            mrays_per_second: rays / sum(|m| m.wall_seconds),
            mrays_per_cpu_second: rays / sum(|m| m.cpu_seconds),
            memory_bytes: (film + info.bytes()) as u64,
            load_seconds: contestant.stage.preparation.load_seconds,
            build_seconds: contestant.stage.preparation.build_seconds,
            runs: runs.clone(),
        }
    }
}

fn point(runs: &[Vec<Mark>], at: usize) -> CurvePoint {
    let marks: Vec<&Mark> = runs.iter().filter_map(|run| run.get(at)).collect();
    let mean = |f: fn(&Mark) -> f64| marks.iter().map(|m| f(m).ln()).collect::<Moments>().mean().exp();
    CurvePoint {
        spp: marks.first().map_or(0, |m| m.spp),
        cpu_seconds: mean(|m| m.cpu_seconds),
        wall_seconds: mean(|m| m.wall_seconds),
        relmse: Interval::geometric(marks.iter().map(|m| m.relmse)),
    }
}

/// Fits the slope in logarithms. The scatter of ln e is the same at every sample count, except that subtracting the
/// reference's noise n scales it by 1 + n/e.
fn slope(runs: &[Vec<Mark>], noise: f64, x: impl Fn(&Mark) -> f64) -> Option<Slope> {
    let weigh = |m: &Mark| WeightedPoint { x: x(m), y: m.relmse, weight: (m.relmse / (m.relmse + noise)).powi(2) };
    let curves: Vec<Vec<WeightedPoint>> = runs.iter().map(|run| run.iter().map(weigh).collect()).collect();
    let slope = PowerLaw::of_curves(&curves)?.slope;
    let [low, high] = slope.interval95();
    Some(Slope { value: slope.value, low, high })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn geometric_means_have_the_interval_of_their_logarithms() {
        // ln: 0 and 2; mean 1, standard error 1, t at one degree of freedom 12.7062.
        let interval = Interval::geometric([1.0, 2.0_f64.exp()]).unwrap();
        assert!((interval.value.ln() - 1.0).abs() < 1e-12, "rounding");
        assert!((interval.low.ln() - (1.0 - 12.7062)).abs() < 5.1e-5 && (interval.high.ln() - 13.7062).abs() < 5.1e-5);
        for lost in [vec![1.0], vec![1.0, 0.0], vec![1.0, -1.0, 2.0], vec![f64::NAN, 1.0]] {
            assert_eq!(Interval::geometric(lost), None);
        }
    }

    #[test]
    fn an_error_that_falls_as_one_over_samples_has_slope_minus_one_in_both() {
        let run = |scale: f64| {
            let mark = |k: u32| {
                let spp = 4 << k;
                Mark {
                    spp,
                    cpu_seconds: 0.1 * spp as f64,
                    wall_seconds: 0.05 * spp as f64,
                    relmse: scale / spp as f64,
                    rays: 0,
                }
            };
            (0..5).map(mark).collect::<Vec<_>>()
        };
        let runs = [run(1.0), run(1.5), run(0.7)];
        for slope in [slope(&runs, 0.01, |m| m.cpu_seconds), slope(&runs, 0.01, |m| m.spp as f64)] {
            assert!((slope.unwrap().value + 1.0).abs() < 1e-12, "rounding: {slope:?}");
        }
        let point = point(&runs, 4);
        assert!((point.cpu_seconds - 6.4).abs() < 1e-12, "rounding");
        assert!((efficiency(&runs[0]) - 10.0).abs() < 1e-12, "1 / (1/64 × 6.4), to rounding");
    }
}
