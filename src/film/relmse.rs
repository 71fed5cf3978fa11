//! The relative mean squared error of an image, and its interval.

use super::block::Block;
use super::independent::Independent;
use super::noise::Noise;
use crate::stats::{skewed_quantile, student_quantile};

/// ε is the square of this fraction of the image mean.
const FLOOR: f64 = 0.1;
/// Bound on the residual bias, in squares of the correction. Normal samples leave up to 1.5 squares (1 % at T_½ / T =
/// 1.08, 3.5 % at 1.15), path-traced ones less than a third of that.
const RESIDUAL: f64 = 1.5;

/// Returns the ε of relMSE, (0.1 × mean)². It keeps black pixels from dominating.
pub fn relmse_epsilon(mean: f64) -> f64 {
    (FLOOR * mean).powi(2)
}

/// Mean squared error relative to the squared value, and its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct RelMse {
    /// The estimate.
    pub value: f64,
    /// Lower end of the 95 % interval.
    pub low: f64,
    /// Upper end; infinite (`null` in JSON) for an image of one block.
    #[serde(deserialize_with = "null_is_infinite")]
    pub high: f64,
    /// Standard error of `value`; infinite (`null` in JSON) where nothing is known of it.
    #[serde(deserialize_with = "null_is_infinite")]
    pub standard_error: f64,
    /// Skewness of `value`: the upper side of the interval is longer for positive skewness.
    pub skewness: f64,
    /// Degrees of freedom of the interval; infinite (`null` in JSON) where the noise was estimated within pixels.
    #[serde(deserialize_with = "null_is_infinite")]
    pub dof: f64,
    /// Relative bias of `value` due to the nonlinearity of the division, T_½ / T − 1. Already removed.
    pub curvature_bias: f64,
    /// First-order relative bias if variances were divided by their own mean, due to skewed samples. Corrected
    /// explicitly below four replicates.
    pub skewness_bias: f64,
    /// Bound on the residual bias of `value`, to either side.
    pub bias_bound: f64,
}

impl RelMse {
    pub(super) fn of(blocks: &[Block], independent: Independent) -> Self {
        let sum = |f: fn(&Block) -> f64| blocks.iter().map(f).sum::<f64>();
        let (values, relative) = (sum(|b| b.values), sum(|b| b.relative));
        let Noise { standard_error, skewness, dof } = Noise::of(independent, blocks, relative, values);
        let share = |part: f64, of: f64| if of > 0.0 { part / of } else { 0.0 };
        let skewness_bias = share(sum(|b| b.sum.skew), sum(|b| b.sum.coupled));
        let apart = sum(|b| b.sum.apart);
        let curvature_bias = if apart > 0.0 {
            sum(|b| b.sum.half_apart) / apart - 1.0
        } else {
            share(sum(|b| b.sum.curvature), sum(|b| b.sum.coupled))
        };
        let empty = RelMse {
            value: relative / values,
            low: 0.0,
            high: 0.0,
            standard_error,
            skewness,
            dof,
            curvature_bias,
            skewness_bias,
            bias_bound: RESIDUAL * curvature_bias * curvature_bias * relative / values,
        };
        let [low, high] = [-1.0, 1.0].map(|side| empty.limit(0.025, side));
        RelMse { low, high, ..empty }
    }

    /// Returns the end of the interval on one `side`; the true value lies beyond it with probability `level`.
    pub(super) fn limit(&self, level: f64, side: f64) -> f64 {
        if self.standard_error.is_infinite() {
            return if side > 0.0 { f64::INFINITY } else { 0.0 };
        }
        let quantile = skewed_quantile(-side * student_quantile(1.0 - level, self.dof), self.skewness);
        (self.value - quantile * self.standard_error + side * self.bias_bound).max(0.0)
    }
}

pub(super) fn null_is_infinite<'de, D: serde::Deserializer<'de>>(source: D) -> Result<f64, D::Error> {
    let value: Option<f64> = serde::Deserialize::deserialize(source)?;
    Ok(value.unwrap_or(f64::INFINITY))
}
