//! Tail of the samples, from the largest sample of each pixel. It is divided by the mean of the pixel's other samples,
//! so that bright image regions do not count as a tail. The tail shape of these ratios is that of the samples. Divided
//! by the number of passes, a ratio is the relative effect of that sample on its pixel: its influence.

use super::{Film, Plane};
use crate::stats::pareto::{Tail, tail_shape};
use rayon::prelude::*;

/// Influences above this are unresolved: the sample dominates the pixel's denominator, and the relative error is
/// underestimated.
const RESOLVED: f64 = 0.25;

/// Statistics of the largest samples of an image, one per pixel.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Peakedness {
    /// Mean over pixels of the squared influence: the contribution of the largest samples alone to relMSE.
    pub squares: f64,
    /// Part of `squares` from unresolved influences.
    pub unresolved: f64,
    /// Number of pixels of equal influence with the same noise: (Σ e²)² / Σ e⁴.
    pub effective_pixels: f64,
    /// Largest influence.
    pub largest: f64,
}

/// Returns the influences of the largest samples of `film` and the tail of their ratios. `floor` is added to the mean
/// of a pixel's other samples. The tail is `None` with too few pixels or passes.
pub(super) fn look(film: &Film, floor: f64) -> (Peakedness, Option<Tail>) {
    let passes = film.passes().len();
    if passes < 2 {
        return (Peakedness::default(), None);
    }
    let mut ratios: Vec<f64> =
        (0..film.layout().pixels()).into_par_iter().filter_map(|p| ratio(film, p, floor)).collect();
    (Peakedness::of(&ratios, passes as f64, film.layout().pixels() as f64), tail_shape(&mut ratios))
}

impl Peakedness {
    fn of(ratios: &[f64], passes: f64, pixels: f64) -> Self {
        let influences = || ratios.iter().map(|r| r / passes).filter(|e| e.is_finite());
        let squares: f64 = influences().map(|e| e * e).sum();
        let fourths: f64 = influences().map(|e| e.powi(4)).sum();
        Peakedness {
            squares: squares / pixels,
            unresolved: influences().filter(|&e| e > RESOLVED).map(|e| e * e).sum::<f64>() / pixels,
            effective_pixels: if fourths > 0.0 { squares * squares / fourths } else { 0.0 },
            largest: influences().fold(0.0, f64::max),
        }
    }
}

fn ratio(film: &Film, pixel: usize, floor: f64) -> Option<f64> {
    let peak = f64::from(film.peaks().at(pixel)?.value);
    let at = pixel * film.layout().channels();
    let light: f64 = (at..at + 3).map(|i| film.total(i)).sum::<f64>() * film.units().of(Plane::Color) / 3.0;
    let others = (light - peak).max(0.0) / (film.passes().len() as f64 - 1.0);
    Some(peak / (others + floor))
}
