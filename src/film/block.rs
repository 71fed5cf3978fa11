//! Sums of squared errors over a block of pixels.

use super::estimator_variance::{Pairs, Patch, Spread};
use super::independent::Independent;
use super::layout::COLOR;
use super::replicates::{PixelError, Replicates};

/// Coefficient of δ² in the correction below four replicates; see `error_estimate`.
const SECOND_ORDER: f64 = 0.5;
/// Lower bound of δ; −½ limits the first-order factor to 2. A smaller δ is noise.
const LEAST_DELTA: f64 = -0.5;

/// Sums over the pixels and channels of a block.
#[derive(Default)]
pub(super) struct Block {
    pub(super) values: f64,
    /// Sum of relative variances, not yet extrapolated by the ratio of the whole image.
    pub(super) relative: f64,
    pub(super) sum: PixelError,
    /// Spread of `relative`; `None` if it cannot be estimated from within.
    pub(super) spread: Option<Spread>,
    /// By replicate: see [`super::replicates::Scratch`].
    pub(super) squares: Vec<f64>,
}

impl Block {
    pub(super) fn of(
        pixels: &[usize],
        replicates: &Replicates<'_>,
        pairs: &Pairs,
        epsilon: f64,
        independent: Independent,
    ) -> Self {
        let (mut scratch, mut sum) = (replicates.scratch(pairs), PixelError::default());
        let mut spread = Some(Spread::default());
        for together in pixels.chunks(independent.together(pixels.len())) {
            let mut patch = Patch::empty(pairs);
            for &pixel in together {
                sum += replicates.pixel(pixel, epsilon, pairs, &mut scratch, &mut patch);
            }
            spread = spread.zip(pairs.spread(&patch)).map(|(sum, spread)| sum + spread);
        }
        let values = (pixels.len() * COLOR) as f64;
        let block = Block { values, relative: sum.coupled, sum, spread, squares: scratch.squares };
        if block.sum.coupled <= 0.0 {
            return block;
        }
        if pairs.pairs.is_empty() { block.corrected() } else { Block { relative: block.sum.apart, ..block } }
    }

    /// Scales `relative` by `share`, and its spread and squares with it.
    pub(super) fn scaled(self, share: f64) -> Self {
        let relative = share * self.relative;
        let of_squares = if self.sum.coupled > 0.0 { relative / self.sum.coupled } else { 0.0 };
        let squares = self.squares.iter().map(|square| square * of_squares).collect();
        Block { relative, spread: self.spread.map(|spread| spread.scaled(share)), squares, ..self }
    }

    /// Removes the first-order bias due to the noise of the whole mean.
    fn corrected(self) -> Self {
        let PixelError { coupled, curvature, skew, .. } = self.sum;
        let delta = ((curvature - skew) / coupled).max(LEAST_DELTA);
        Block { relative: coupled / (1.0 + delta + SECOND_ORDER * delta * delta), ..self }
    }
}
