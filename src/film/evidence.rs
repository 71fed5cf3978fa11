//! What speaks for and against an interval of relMSE, in figures, and the verdict on them. A render that met no rare sample must
//! not be trusted for that: the verdict asks what luck cannot hide.
//!
//! - What is known beforehand: light that the method is blind to, and the radiance M that a sample brings by a path which the
//!   method meets by luck (see `integrator::prior`). N samples of P pixels that met none leave a rate of up to 3 / (N P) (95 %, the rule of three), and
//!   then relMSE lacks 3/P (M / (N mean))²: in a large picture little, in a small one perhaps all.
//! - The tail, at the upper end of its shape's interval and not at the estimate.
//! - Samples that their pixels' denominators cannot resolve: see [`Peakedness`].
//! - The noise of denominators.

use super::error_estimate::RelMse;
use super::tail::{self, Peakedness};
use super::trust::{Distrust, Reason, Trust};
use super::{Film, Known};
use crate::defects::{Defect, planted};
use crate::stats::pareto::{Tail, UNTRUSTED_SHAPE};

/// Where curvature, or with fewer than four replicates skewness, makes more than this share of bias, orders beyond the second matter, and the result is good for its
/// magnitude only.
const MOST_BIAS: f64 = 0.15;
/// The most that samples which are not resolved may bring, as a share of relMSE.
const MOST_UNRESOLVED: f64 = 0.3;
/// The most that rare paths may have hidden, as a share of relMSE.
const MOST_RARE: f64 = 0.5;
/// −ln .05: so many events are expected at most, at 95 % confidence, where none was met.
const RULE_OF_THREE: f64 = 3.0;
/// With fewer replicates what is divided and what it is divided by are not apart.
const APART_FROM: u32 = 4;

/// The figures.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Evidence {
    /// The largest samples.
    pub peaks: Peakedness,
    /// The upper end of the 95 % interval of the tail's shape (one-sided).
    pub shape_limit: Option<f64>,
    /// What rare paths may bring to relMSE though none was met, at 95 % confidence; infinite (`null` in JSON) without a bound.
    #[serde(deserialize_with = "super::error_estimate::null_is_infinite")]
    pub rare_relmse: f64,
}

impl Evidence {
    /// What the samples of a film say whose mean is `mean`, and the tail; `floor` is the root of relMSE's ε.
    pub(super) fn of(film: &Film, known: Known, mean: f64, floor: f64) -> (Self, Option<Tail>) {
        let (peaks, tail) = tail::look(film, floor);
        let (passes, pixels) = (film.passes().len() as f64, film.layout().pixels() as f64);
        let rare = if mean > 0.0 { known.prior.rare_radiance / (mean * passes) } else { 0.0 };
        let lucky = planted(Defect::TrustByLuck);
        let shape_limit = tail.map(|tail| if lucky { tail.shape } else { tail.upper_shape() });
        (Evidence { peaks, shape_limit, rare_relmse: RULE_OF_THREE * rare * rare / pixels }, tail)
    }

    /// What one sample of a rare path brings to an image of so many `pixels`, as a share of its light.
    pub(super) fn rare_share(&self, pixels: usize) -> f64 {
        (self.rare_relmse / (RULE_OF_THREE * pixels as f64)).sqrt()
    }

    /// The verdict.
    pub(super) fn verdict(&self, relmse: &RelMse, known: Known, replicates: u32) -> Trust {
        let least = f64::from(known.independent.least_replicates());
        let skewness = if replicates < APART_FROM { relmse.skewness_bias } else { 0.0 };
        let share = |part: f64| if part > 0.0 { part / relmse.value } else { 0.0 };
        let above = |reason: Reason, value: f64, limit: f64| (value > limit).then_some(Distrust { reason, value, limit });
        let too_few = f64::from(replicates) < least;
        let reasons = [
            above(Reason::BlindMethod, f64::from(u8::from(known.prior.blind)), 0.0),
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
