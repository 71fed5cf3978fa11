//! What speaks for and against an interval of relMSE, in figures, and the verdict on them.

use super::error_estimate::RelMse;
use super::tail::{self, Peakedness};
use super::trust::{Distrust, Reason, Trust};
use super::{Film, Known};
use crate::stats::pareto::{Tail, UNTRUSTED_SHAPE};

/// Where the curvature's part of the bias, about 3 v, or that of skewness is more than this share, orders beyond the second matter, and
/// the result is good for its magnitude only.
const MOST_BIAS: f64 = 0.3;

/// The figures.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Evidence {
    /// The largest samples.
    pub peaks: Peakedness,
    /// What share the replicate that brought most has in the error.
    pub largest_replicate: f64,
    /// The influence on its pixel of one sample along a rare path: see [`super::Prior::rare_radiance`].
    pub rare_influence: f64,
    /// What rare paths may bring to relMSE though none was met, at 95 % confidence.
    pub rare_relmse: f64,
}

/// What an image says of its tail.
pub(super) fn of(film: &Film, known: Known, mean: f64, floor: f64, squares: &[f64]) -> (Evidence, Option<Tail>) {
    let (peaks, tail) = tail::look(film, floor);
    let (passes, pixels) = (film.passes().len() as f64, film.layout().pixels() as f64);
    let all: f64 = squares.iter().sum();
    let rare_influence = if mean > 0.0 { known.prior.rare_radiance / (mean * passes) } else { 0.0 };
    let evidence = Evidence {
        peaks,
        largest_replicate: if all > 0.0 { squares.iter().copied().fold(0.0, f64::max) / all } else { 0.0 },
        rare_influence,
        rare_relmse: 3.0 * rare_influence * rare_influence / pixels,
    };
    (evidence, tail)
}

/// The verdict.
pub(super) fn verdict(relmse: &RelMse, evidence: &Evidence, tail: Option<&Tail>, known: Known, replicates: u32) -> Trust {
    let least = f64::from(known.independent.least_replicates());
    let heavy = tail.map_or(0.0, |tail| tail.shape);
    let bias = relmse.curvature_bias.max(relmse.skewness_bias);
    let checks = [
        (known.prior.blind, Reason::BlindMethod, 1.0, 0.0),
        (heavy > UNTRUSTED_SHAPE, Reason::HeavyTail, heavy, UNTRUSTED_SHAPE),
        (bias > MOST_BIAS, Reason::NoisyImage, bias, MOST_BIAS),
        (f64::from(replicates) < least, Reason::FewReplicates, f64::from(replicates), least),
    ];
    let reasons = checks.into_iter().filter(|check| check.0);
    let _ = evidence;
    Trust::unless(reasons.map(|(_, reason, value, limit)| Distrust { reason, value, limit }).collect())
}
