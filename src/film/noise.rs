//! How far an estimated relMSE may be off, from whatever parts of an image are independent of each other.
//!
//! Replicates always are; they are few, and say little. Pixels are many, and say much where each has its own samples. With four
//! replicates or more the noise of each pixel's error, or of each block's, is estimated from within it, so that bright and dark, easy
//! and hard parts of a picture do not pass for noise; with fewer, blocks are taken as a sample of blocks, and the interval is too wide.
//! Where replicates alone are independent, the whole image is one number a replicate, and the jackknife over them has R − 1 degrees
//! of freedom: below eight replicates its interval is too narrow if all pixels rise and fall as one (R = 4: 92 %, 8 and 16: 97 %).

use super::error_estimate::Block;
use super::spread::{Spread, third_cumulant};
use crate::defects::{Defect, planted};
use crate::stats::{Moments, third_cumulant_of_mean};

/// What of an image says how noisy its estimated error is, being independent of the rest of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Independent {
    /// Pixels: each has its own samples.
    Pixels,
    /// Blocks of pixels: what falls on one pixel falls on its neighbours too, as splats under a filter do, and on others seldom.
    Blocks,
    /// Replicates and nothing else: chains, photons or cached vertices serve the whole image.
    Replicates,
}

impl Independent {
    /// How many of the pixels of a block of `block` are taken together.
    pub(super) fn together(self, block: usize) -> usize {
        match self {
            Independent::Pixels => 1,
            Independent::Blocks if planted(Defect::PixelsForBlocks) => 1,
            Independent::Blocks | Independent::Replicates => block,
        }
    }

    /// How many replicates an interval needs.
    pub(super) fn least_replicates(self) -> u32 {
        match self {
            Independent::Pixels | Independent::Blocks => 2,
            Independent::Replicates => 8,
        }
    }
}

/// The noise of an estimated relMSE.
pub(super) struct Noise {
    pub(super) standard_error: f64,
    pub(super) skewness: f64,
    pub(super) dof: f64,
}

impl Noise {
    /// That of `relative` over `values`, the sums over `blocks`.
    pub(super) fn of(independent: Independent, blocks: &[Block], relative: f64, values: f64) -> Self {
        let within = || Noise::within_patches(blocks, values).unwrap_or_else(|| Noise::between_blocks(blocks, relative, values));
        match independent {
            Independent::Pixels | Independent::Blocks => within(),
            Independent::Replicates if planted(Defect::PatchesForReplicates) => within(),
            Independent::Replicates => Noise::between_replicates(&squares(blocks, values), relative / values),
        }
    }

    /// From the noise of each patch, of which there are many enough for a normal quantile. The variance is no less than that of
    /// normal replicates: where few pixels make up the error, one that comes out less is noise, and the interval would miss.
    fn within_patches(blocks: &[Block], values: f64) -> Option<Self> {
        let spread = blocks.iter().map(|b| b.spread).sum::<Option<Spread>>()?.scaled(1.0 / values);
        Some(Noise::new(spread.variance.max(spread.of_normal), spread.third, f64::INFINITY))
    }

    /// By the jackknife over blocks [Efron81].
    fn between_blocks(blocks: &[Block], relative: f64, values: f64) -> Self {
        let n = blocks.len() as f64;
        let pseudo = |b: &Block| n * relative / values - (n - 1.0) * (relative - b.relative) / (values - b.values);
        let pseudo: Vec<f64> = blocks.iter().map(pseudo).collect();
        let moments: Moments = pseudo.iter().copied().collect();
        let variance = moments.variance().map_or(f64::INFINITY, |variance| variance / n);
        Noise::new(variance, third_cumulant_of_mean(&pseudo, moments.mean()), (n - 1.0).max(1.0))
    }

    /// By the jackknife over replicates [Efron81], of which two say nothing.
    ///
    /// Let S be the `squares` by replicate, whose sum is (R − 1) T. Without replicate r that sum is Σ S − R/(R − 1) S_r, and the
    /// pseudo-value is T + R/(R − 2) (S_r − mean S). The third cumulant of few pseudo-values is too small as a rule, that of
    /// [`third_cumulant`] too large where events are rare: half of either holds best.
    fn between_replicates(squares: &[f64], value: f64) -> Self {
        let replicates = squares.len() as f64;
        if squares.len() < 3 {
            return Noise { standard_error: f64::INFINITY, skewness: 0.0, dof: 1.0 };
        }
        let influence = if planted(Defect::SquaresForPseudoValues) { 1.0 } else { replicates / (replicates - 2.0) };
        let moments: Moments = squares.iter().map(|s| influence * s).collect();
        let variance = moments.variance().map_or(f64::INFINITY, |variance| variance / replicates);
        let third = influence.powi(3) * third_cumulant_of_mean(squares, moments.mean() / influence);
        Noise::new(variance, 0.5 * (third + third_cumulant(variance, value)), replicates - 1.0)
    }

    fn new(variance: f64, third: f64, dof: f64) -> Self {
        let is_known = variance > 0.0 && variance.is_finite();
        let skewness = if is_known { third / (variance * variance.sqrt()) } else { 0.0 };
        Noise { standard_error: variance.sqrt(), skewness, dof }
    }
}

/// The squares of all blocks by replicate, over `values`.
fn squares(blocks: &[Block], values: f64) -> Vec<f64> {
    let mut sums = vec![0.0; blocks.first().map_or(0, |b| b.squares.len())];
    for block in blocks {
        sums.iter_mut().zip(&block.squares).for_each(|(sum, square)| *sum += square / values);
    }
    sums
}

#[cfg(test)]
#[path = "noise_tests.rs"]
mod tests;
