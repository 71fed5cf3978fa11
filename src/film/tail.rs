//! How heavy the tail of an image's samples is. Each pixel gives its largest sample over the mean of its others, so that
//! bright parts of a picture do not pass for a tail; the shape of the tail of these maxima is that of the samples.

use super::{Film, Plane};
use crate::stats::pareto::{Tail, tail_shape};
use rayon::prelude::*;

/// The tail of the samples of `film`; `floor` is added to the mean of a pixel's other samples. `None` where there are too few
/// pixels or passes to tell.
pub(super) fn tail_of(film: &Film, floor: f64) -> Option<Tail> {
    let passes = film.passes().len();
    if passes < 2 {
        return None;
    }
    let mut ratios: Vec<f64> = (0..film.layout().pixels()).into_par_iter().filter_map(|p| ratio(film, p, floor)).collect();
    tail_shape(&mut ratios)
}

fn ratio(film: &Film, pixel: usize, floor: f64) -> Option<f64> {
    let peak = f64::from(film.peaks().at(pixel)?.value);
    let at = pixel * film.layout().channels();
    let light: f64 = (at..at + 3).map(|i| film.total(i)).sum::<f64>() * film.units().of(Plane::Color) / 3.0;
    let others = (light - peak).max(0.0) / (film.passes().len() as f64 - 1.0);
    Some(peak / (others + floor))
}
