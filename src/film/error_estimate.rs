//! Error estimates of an image, from its replicates.
//!
//! Replicates are independent, whatever the correlation within one (random samples, QMC, Markov chains). The variance
//! of the mean follows from their differences. The relative error is averaged over the image. Its interval relies on
//! the units that the method declares [`Independent`]: pixels, blocks of pixels, or replicates. Squared errors are
//! positive, and their estimate is the more skewed the fewer pixels dominate it. We therefore use Hall's interval.
//!
//! Bias: E V / (m² + ε) is not Var(m) / (μ² + ε), for two reasons. First, 1 / (m² + ε) is nonlinear: at relative
//! variance v of m, the result is too high by 3 v to first order. Second, V and m are correlated: a bright sample
//! raises both. A sample of e times the rest of its pixel shows as a relative variance of at most 1 instead of e².
//! We remove the correlation by cross-validation. The variance (m_a − m_b)² of a pair of replicates is divided by the
//! mean m_o of the *other* replicates, which is independent of it: E T = Σ Var(m) E g(m_o), g(m) = 1 / (m² + ε). We
//! remove the nonlinearity by extrapolation. T_½ is T with the means of half of the others, which have twice the
//! variance. Then T = G (1 + δ + …) and T_½ = G (1 + 2 δ + …) with the same G = Σ Var(m) g(μ), so that T² / T_½ = G to
//! first order. This is linear extrapolation of ln T in the variance of the denominator. Its second-order residual is a
//! seventh (δ ≈ .1) to half of that of 2 T − T_½.
//!
//! Two or three replicates leave no others to divide by. Both effects are then estimated to first order from the whole
//! mean as one δ per block, and removed by the factor 1 / (1 + δ + δ²/2). The interval is widened by a bound on the
//! residual bias (`RESIDUAL` in `relmse`).
//!
//! Measured (path, R = 4, 300 to 400 renders each), as a ratio to the true relMSE. Two-lamp room at 8, 16 and 32
//! samples: .974, .994, .998 with the first-order correction; 1.005, 1.004, 1.001 with this one. Where the second
//! lamp is rarely selected, at 16, 32, 64 samples: .42, .51, .68 and 1.09, 1.07, 1.06.

use super::block::Block;
use super::estimator_variance::Pairs;
use super::independent::Independent;
use super::layout::COLOR;
use super::max_samples::Peak;
use super::relmse::{RelMse, relmse_epsilon};
use super::replicates::Replicates;
use super::{Evidence, Film, Known, Layout, Trust};
use crate::stats::pareto::Tail;
use rayon::prelude::*;

/// Side in pixels of the blocks, which are the unit of parallel work and of the reported error share. Halved until
/// there are at least 16 blocks.
const BLOCK: usize = 8;
/// The estimated error of an image's colour.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ImageError {
    /// Mean over pixels and channels of Var(m) / (m² + ε) [Rousselle11].
    pub relmse: RelMse,
    /// Square root of the mean over pixels and channels of Var(m).
    pub rmse: f64,
    /// Mean of all pixels and channels.
    pub mean: f64,
    /// Standard error of `mean`, from the means of the replicates: R − 1 degrees of freedom.
    pub mean_standard_error: f64,
    /// The ε of `relmse`: (0.1 × mean)².
    pub epsilon: f64,
    /// Number of replicates behind the estimate.
    pub replicates: u32,
    /// Units of the image that the interval of `relmse` treats as independent.
    pub independent: Independent,
    /// Largest share of one block of pixels in `relmse`. Near 1, a few fireflies dominate the error and the interval is
    /// unreliable.
    pub max_share: f64,
    /// The largest sample; `None` in a black image.
    pub largest: Option<LargestSample>,
    /// Tail of the samples; `None` with too few samples.
    pub tail: Option<Tail>,
    /// Further evidence for or against the interval.
    pub evidence: Evidence,
    /// Whether the interval of `relmse` is reliable, with the reasons against it.
    #[serde(flatten)]
    pub trust: Trust,
}

/// The largest sample of an image.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct LargestSample {
    /// Its share of the total of the image.
    pub share: f64,
    /// Its mean over the colour channels.
    pub value: f64,
    /// Column of its pixel.
    pub x: u32,
    /// Row of its pixel.
    pub y: u32,
    /// Its pass.
    pub pass: u32,
}

impl ImageError {
    /// Returns the upper confidence limit of the relative mean squared error, which is exceeded with probability
    /// `level`.
    ///
    /// # Panics
    /// Unless 0 < level < 1.
    pub fn upper_limit(&self, level: f64) -> f64 {
        self.relmse.limit(level, 1.0)
    }

    /// Returns an upper bound, at error probability `level`, on the contribution of samples larger than any seen, as a
    /// share of the total of an image of `pixels` pixels. If none was seen, at most −ln `level` are expected. The value
    /// of one is the mean of a tail of the fitted shape beyond the largest sample, or the known radiance of rare paths.
    /// The bound is infinite if the tail has no mean.
    pub fn unseen_share(&self, pixels: usize, level: f64) -> f64 {
        let largest = self.largest.map_or(0.0, |largest| largest.share);
        let shape = self.evidence.shape_limit.unwrap_or(0.0).max(0.0);
        let of_tail = if shape < 1.0 { largest / (1.0 - shape) } else { f64::INFINITY };
        -level.ln() * of_tail.max(self.evidence.rare_share(pixels))
    }

    /// Returns the verdict on the interval of `relmse`.
    pub fn trust(&self) -> &Trust {
        &self.trust
    }

    /// Returns the reason to distrust the interval of `relmse`, if there is one.
    pub fn distrust(&self) -> Option<&'static str> {
        self.trust.why_not()
    }
}

impl Film {
    /// Returns the standard error of every colour mean, 3 channels per pixel; `None` with fewer than 2 replicates or an
    /// empty one.
    ///
    /// With n_r passes in replicate r and N in all, Var(m) = Σ n_r/N (m_r − m)² / (R − 1). This is unbiased where the
    /// variance of m_r is proportional to 1/n_r. For equal n_r it is the usual Σ (m_r − m)² / (R (R − 1)).
    pub fn standard_error(&self) -> Option<Vec<f32>> {
        let replicates = Replicates::of(self)?;
        let mut errors = vec![0.0_f32; self.layout().pixels() * COLOR];
        errors.par_chunks_mut(COLOR * 1024).enumerate().for_each(|(chunk, errors)| {
            let mut means = vec![0.0; replicates.counts.len()];
            for (i, error) in errors.iter_mut().enumerate() {
                let index = chunk * COLOR * 1024 + i;
                replicates.means(index / COLOR, index % COLOR, &mut means);
                *error = replicates.variance(&means).sqrt() as f32;
            }
        });
        Some(errors)
    }

    /// Returns the error of the whole image, given the prior knowledge `known` of its samples; `None` with fewer than 2
    /// replicates, an empty one, or no pixels.
    pub fn image_error(&self, known: impl Into<Known>) -> Option<ImageError> {
        let known = known.into();
        let independent = known.independent;
        let replicates = Replicates::of(self)?;
        let mean = replicates.image_mean()?;
        let epsilon = relmse_epsilon(mean.value);
        let pairs = Pairs::of(&replicates.counts);
        let block = |pixels: Vec<usize>| Block::of(&pixels, &replicates, &pairs, epsilon, independent);
        let blocks: Vec<Block> = blocks(self.layout()).into_par_iter().map(block).collect();
        let share = extrapolation(&blocks);
        let blocks: Vec<Block> = blocks.into_iter().map(|block| block.scaled(share)).collect();
        let sum = |f: fn(&Block) -> f64| blocks.iter().map(f).sum::<f64>();
        let (values, relative) = (sum(|b| b.values), sum(|b| b.relative));
        let relmse = RelMse::of(&blocks, independent);
        let (evidence, tail) = Evidence::of(self, known, mean.value, epsilon.sqrt());
        let trust = evidence.verdict(&relmse, mean.value, known, self.replicates());
        let largest = blocks.iter().map(|b| b.relative).fold(0.0, f64::max);
        Some(ImageError {
            relmse,
            rmse: (sum(|b| b.sum.variance) / values).sqrt(),
            mean: mean.value,
            mean_standard_error: mean.standard_error,
            epsilon,
            replicates: self.replicates(),
            independent,
            max_share: if relative > 0.0 { largest / relative } else { 0.0 },
            largest: largest_sample(self, mean.value),
            tail,
            evidence,
            trust,
        })
    }
}

/// Returns T / T_½, the factor that extrapolates T to noise-free denominators: see the module documentation.
fn extrapolation(blocks: &[Block]) -> f64 {
    let sum = |f: fn(&Block) -> f64| blocks.iter().map(f).sum::<f64>();
    let [all, half] = [sum(|b| b.sum.apart), sum(|b| b.sum.half_apart)];
    if half > 0.0 { all / half } else { 1.0 }
}

/// Returns the pixels of each block, by index within the crop.
fn blocks(layout: &Layout) -> Vec<Vec<usize>> {
    let width = (layout.crop.x1 - layout.crop.x0) as usize;
    let height = (layout.crop.y1 - layout.crop.y0) as usize;
    let mut side = BLOCK;
    while side > 1 && width.div_ceil(side) * height.div_ceil(side) < 16 {
        side /= 2;
    }
    let span = |start: usize, end: usize| start..(start + side).min(end);
    let corners = (0..height).step_by(side).flat_map(|y| (0..width).step_by(side).map(move |x| (x, y)));
    corners.map(|(x, y)| span(y, height).flat_map(|y| span(x, width).map(move |x| y * width + x)).collect()).collect()
}

/// Returns the largest sample of the image; `mean` is the image mean over pixels and channels.
fn largest_sample(film: &Film, mean: f64) -> Option<LargestSample> {
    let pixels = film.layout().pixels();
    let by_value = |a: &(usize, Peak), b: &(usize, Peak)| a.1.value.total_cmp(&b.1.value).then(b.0.cmp(&a.0));
    let (pixel, peak) = (0..pixels).filter_map(|p| Some((p, film.peaks().at(p)?))).max_by(by_value)?;
    let [x, y] = film.layout().pixel(pixel);
    let light = mean * pixels as f64 * film.passes().len() as f64;
    let value = f64::from(peak.value);
    Some(LargestSample { share: value / light, value, x, y, pass: peak.pass })
}

#[cfg(test)]
#[path = "error_estimate_tests.rs"]
mod tests;
