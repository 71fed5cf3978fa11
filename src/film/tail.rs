//! What the largest samples of an image say. Each pixel gives its largest sample over the mean of its others, so that bright parts
//! of a picture do not pass for a tail; the shape of the tail of these maxima is that of the samples. Over the number of passes the
//! same is what that one sample did to its pixel, its influence.

use super::{Film, Plane};
use crate::stats::pareto::{Tail, tail_shape};
use rayon::prelude::*;

/// An influence above this is not resolved: the pixel's denominator is the sample's own, and its relative error too small.
const RESOLVED: f64 = 0.25;

/// The largest samples of an image, one a pixel.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Peakedness {
    /// Mean over pixels of the squared influence: what the largest samples alone bring to relMSE.
    pub squares: f64,
    /// The part of `squares` that comes of influences that are not resolved.
    pub unresolved: f64,
    /// How many pixels with the same influence would have the same noise: (Σ e²)² / Σ e⁴.
    pub effective_pixels: f64,
    /// The largest influence.
    pub largest: f64,
}

/// The influences of the largest samples of `film` and the tail of their ratios; `floor` is added to the mean of a pixel's
/// other samples. `None` where there are too few pixels or passes to tell.
pub(super) fn look(film: &Film, floor: f64) -> (Peakedness, Option<Tail>) {
    let passes = film.passes().len();
    if passes < 2 {
        return (Peakedness::default(), None);
    }
    let mut ratios: Vec<f64> = (0..film.layout().pixels()).into_par_iter().filter_map(|p| ratio(film, p, floor)).collect();
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
