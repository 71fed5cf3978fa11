//! Evidence for and against an interval of relMSE, and the verdict. A render without rare samples looks more accurate
//! than it is. The verdict therefore uses evidence that does not depend on having seen them.
//!
//! - Prior knowledge: light that the method cannot sample, and the radiance M of a sample from a path that it samples
//!   only by chance (see `integrator::prior`). If N samples of each of P pixels contain none, their rate is at most 3 /
//!   (N P) (95 %, rule of three). The missing relMSE is then at most 3/P (M / (N mean))²: little in a large image,
//!   perhaps all in a small one.
//! - The upper confidence limit of the tail shape, rather than its estimate.
//! - Samples unresolved by the denominators of their pixels: see [`Peakedness`].
//! - The noise of the denominators.

use super::relmse::RelMse;
use super::tail_index::{self, Peakedness};
use super::trust::{Distrust, Reason, Trust};
use super::{Film, Known};
use crate::stats::pareto::{Tail, UNTRUSTED_SHAPE};

/// Largest accepted relative bias by curvature, or by skewness with fewer than four replicates. Beyond it, terms above
/// second order matter, and the result is an order of magnitude only.
const MOST_BIAS: f64 = 0.15;
/// Largest accepted contribution of unresolved samples, as a share of relMSE.
const MOST_UNRESOLVED: f64 = 0.3;
/// Largest accepted unseen contribution of rare paths, as a share of relMSE.
const MOST_RARE: f64 = 0.5;
/// Rule of three: −ln .05 bounds the expected number of events at 95 % confidence if none was seen.
const RULE_OF_THREE: f64 = 3.0;
/// Least number of replicates for independent numerators and denominators.
const APART_FROM: u32 = 4;

/// Measured evidence.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Evidence {
    /// Statistics of the largest samples.
    pub peaks: Peakedness,
    /// Upper end of the one-sided 95 % interval of the tail shape.
    pub shape_limit: Option<f64>,
    /// Bound on the unseen contribution of rare paths to relMSE at 95 % confidence; infinite (`null` in JSON) without a
    /// bound.
    #[serde(deserialize_with = "super::relmse::null_is_infinite")]
    pub rare_relmse: f64,
}

impl Evidence {
    /// Returns the evidence of a film of the given `mean`, and the tail; `floor` is the square root of the ε of relMSE.
    pub(super) fn of(film: &Film, known: Known, mean: f64, floor: f64) -> (Self, Option<Tail>) {
        let (peaks, tail) = tail_index::look(film, floor);
        let (passes, pixels) = (film.passes().len() as f64, film.layout().pixels() as f64);
        let rare = if mean > 0.0 { known.prior.rare_radiance / (mean * passes) } else { 0.0 };
        let shape_limit = tail.map(|tail| tail.upper_shape());
        (Evidence { peaks, shape_limit, rare_relmse: RULE_OF_THREE * rare * rare / pixels }, tail)
    }

    /// Returns the contribution of one sample of a rare path to an image of `pixels` pixels, as a share of its total.
    pub(super) fn rare_share(&self, pixels: usize) -> f64 {
        (self.rare_relmse / (RULE_OF_THREE * pixels as f64)).sqrt()
    }

    /// Returns the verdict on the interval of `relmse` of an image with that `mean`.
    pub(super) fn verdict(&self, relmse: &RelMse, mean: f64, known: Known, replicates: u32) -> Trust {
        let least = f64::from(known.independent.least_replicates());
        let skewness = if replicates < APART_FROM { relmse.skewness_bias } else { 0.0 };
        let share = |part: f64| if part > 0.0 { part / relmse.value } else { 0.0 };
        let above =
            |reason: Reason, value: f64, limit: f64| (value > limit).then_some(Distrust { reason, value, limit });
        let too_few = f64::from(replicates) < least;
        let reasons = [
            above(Reason::BlindMethod, f64::from(u8::from(known.prior.blind)), 0.0),
            (mean <= 0.0).then_some(Distrust { reason: Reason::NoLight, value: mean, limit: 0.0 }),
            above(Reason::RarePaths, share(self.rare_relmse), MOST_RARE),
            above(Reason::HeavyTail, self.shape_limit.unwrap_or(0.0), UNTRUSTED_SHAPE),
            above(Reason::FewSamples, share(self.peaks.unresolved), MOST_UNRESOLVED),
            above(Reason::NoisyImage, relmse.curvature_bias.abs().max(skewness), MOST_BIAS),
            too_few.then_some(Distrust { reason: Reason::FewReplicates, value: f64::from(replicates), limit: least }),
        ];
        Trust::unless(reasons.into_iter().flatten().collect())
    }
}

#[cfg(test)]
#[path = "evidence_tests.rs"]
mod tests;
