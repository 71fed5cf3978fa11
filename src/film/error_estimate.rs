//! The error that an image carries, from its replicates.
//!
//! Replicates are independent whatever happens inside one (random, QMC, chains), so the error of the mean follows from how
//! they differ. The relative error pools over the image; its interval comes from what the method says is [`Independent`]: pixels,
//! blocks of them, or replicates alone. Errors are positive and their estimates skewed, the more the fewer pixels make up the
//! error: the interval is Hall's.
//!
//! Bias: E V / (m² + ε) is not Var(m) / (μ² + ε). Two things make it wrong: 1 / (m² + ε) is curved (at relative variance v of m the
//! result is too high by 3 v to first order), and a bright sample raises V and m together, so that its own light hides its noise
//! (one that is e times the rest of its pixel shows at most 1 of its e²). Against the second, the variance (m_a − m_b)² of a pair of replicates is divided
//! by the mean of the *others*, of which it is independent whatever the samples are like: E T = Σ Var(m) E g(m_o), g(m) = 1 / (m² + ε). Against
//! the first, T is taken again by the means of half of the others, T_½, whose variance is twice as large. Then T = G (1 + δ + …) and T_½ =
//! G (1 + 2 δ + …) of the same G = Σ Var(m) g(μ), and T² / T_½ = G to first order: linear extrapolation of ln T in the variance of what
//! is divided by. Over 2 T − T_½ it leaves a seventh (δ ≈ .1) to half of the second order.
//!
//! With two or three replicates there are no others: both effects are estimated to first order from the whole mean, together δ, block by
//! block, and taken out as 1 / (1 + δ + δ²/2). What may be left widens the interval ([`RESIDUAL`]).
//!
//! Measured (path, R = 4, 300 to 400 renders each): of a two-lamp room's relMSE at 8, 16 and 32 samples first order gave .974, .994,
//! .998, this 1.005, 1.004, 1.001; where the second lamp is seldom chosen, .42, .51, .68 at 16, 32, 64 samples, and this 1.09, 1.07, 1.06.

use super::noise::{Independent, Noise};
use super::peaks::Peak;
use super::replicates::{COLOR, PixelError, Replicates};
use super::spread::{Pairs, Patch, Spread};
use super::{Evidence, Film, Known, Layout, Trust};
use crate::defects::{Defect, planted};
use crate::stats::pareto::Tail;
use crate::stats::{skewed_quantile, student_quantile};
use rayon::prelude::*;

/// ε is the square of this share of the image mean, so that black pixels do not dominate.
const FLOOR: f64 = 0.1;
/// Side of the blocks of pixels that share work, and whose share of the error is reported; halved until there are at least 16.
const BLOCK: usize = 8;
/// See the module's head.
const SECOND_ORDER: f64 = 0.5;
/// What may be left of the bias, in squares of what was taken out: with normal samples up to 1.5 of them is missing (1 % at T_½ / T =
/// 1.08, 3.5 % at 1.15), with those of path tracing less than a third of that.
const RESIDUAL: f64 = 1.5;
/// No block is corrected by more than what doubles it: such a δ is noise.
const LEAST_DELTA: f64 = -0.5;
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
    /// Skewness of `value`: how much the interval is longer above than below.
    pub skewness: f64,
    /// Degrees of freedom of the interval; infinite (`null` in JSON) where the noise was estimated within pixels.
    #[serde(deserialize_with = "null_is_infinite")]
    pub dof: f64,
    /// What noisy denominators do to `value` by the curvature of the division, as a share of it: T_½ / T − 1. Taken out.
    pub curvature_bias: f64,
    /// What skewed samples would hide if variances were divided by their own mean, to first order. Below four replicates it is put back.
    pub skewness_bias: f64,
    /// What `value` may be off besides, on either side.
    pub bias_bound: f64,
}

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
    /// How many replicates the estimate stands on.
    pub replicates: u32,
    /// What the interval of `relmse` takes as independent.
    pub independent: Independent,
    /// The largest share that one block of pixels has in `relmse`. Near 1, a few fireflies make the error and the
    /// interval cannot be trusted.
    pub max_share: f64,
    /// The largest sample; `None` in a black image.
    pub largest: Option<LargestSample>,
    /// How heavy the tail of the samples is; `None` where there are too few to tell.
    pub tail: Option<Tail>,
    /// What else there is to judge the interval by.
    pub evidence: Evidence,
    /// Whether the interval of `relmse` is to be trusted, and why not.
    #[serde(flatten)]
    pub trust: Trust,
}

/// One sample that the image owes much to.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct LargestSample {
    /// Its share of the light in the image.
    pub share: f64,
    /// Its colour, as the mean over channels.
    pub value: f64,
    /// Column of its pixel.
    pub x: u32,
    /// Row of its pixel.
    pub y: u32,
    /// The pass it belongs to.
    pub pass: u32,
}

pub(super) fn null_is_infinite<'de, D: serde::Deserializer<'de>>(source: D) -> Result<f64, D::Error> {
    let value: Option<f64> = serde::Deserialize::deserialize(source)?;
    Ok(value.unwrap_or(f64::INFINITY))
}

impl RelMse {
    fn of(blocks: &[Block], independent: Independent) -> Self {
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

    /// The end of the interval on one `side` that the truth is beyond with probability `level`.
    fn limit(&self, level: f64, side: f64) -> f64 {
        if self.standard_error.is_infinite() {
            return if side > 0.0 { f64::INFINITY } else { 0.0 };
        }
        let quantile = skewed_quantile(-side * student_quantile(1.0 - level, self.dof), self.skewness);
        (self.value - quantile * self.standard_error + side * self.bias_bound).max(0.0)
    }
}

impl ImageError {
    /// What the relative mean squared error is below, but for a chance of `level`.
    ///
    /// # Panics
    /// Unless 0 < level < 1.
    pub fn upper_limit(&self, level: f64) -> f64 {
        self.relmse.limit(level, 1.0)
    }

    /// What samples larger than any that was met may bring to an image of so many `pixels`, as a share of its light, but for a chance of
    /// `level`: −ln `level` of them at most are expected where none was met, and one of them brings the mean beyond the largest sample of a
    /// tail of that shape, or the radiance that is known of rare paths. Infinite where the tail has no mean.
    pub fn unseen_share(&self, pixels: usize, level: f64) -> f64 {
        let largest = self.largest.map_or(0.0, |largest| largest.share);
        let shape = self.evidence.shape_limit.unwrap_or(0.0).max(0.0);
        let of_tail = if shape < 1.0 { largest / (1.0 - shape) } else { f64::INFINITY };
        -level.ln() * of_tail.max(self.evidence.rare_share(pixels))
    }

    /// Whether the interval of `relmse` is to be trusted.
    pub fn trust(&self) -> &Trust {
        &self.trust
    }

    /// Why the interval of `relmse` cannot be trusted, if it cannot.
    pub fn distrust(&self) -> Option<&'static str> {
        self.trust.why_not()
    }
}

impl Film {
    /// Standard error of every colour mean, 3 channels per pixel; `None` with fewer than 2 replicates or an empty one.
    ///
    /// Replicates r of n_r passes, N in all: Var(m) = Σ n_r/N (m_r − m)² / (R − 1), which is unbiased where the variance of m_r goes as
    /// 1/n_r, and the usual Σ (m_r − m)² / (R (R − 1)) where all n_r are equal.
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

    /// The error of the whole image, of whose samples that is `known`; `None` with fewer than 2 replicates, an empty one, or no
    /// pixels.
    pub fn image_error(&self, known: impl Into<Known>) -> Option<ImageError> {
        let known = known.into();
        let independent = known.independent;
        let replicates = Replicates::of(self)?;
        let mean = replicates.image_mean()?;
        let epsilon = (FLOOR * mean.value).powi(2);
        let pairs = Pairs::of(&replicates.counts);
        let block = |pixels: Vec<usize>| Block::of(&pixels, &replicates, &pairs, epsilon, independent);
        let blocks: Vec<Block> = blocks(self.layout()).into_par_iter().map(block).collect();
        let share = extrapolation(&blocks);
        let blocks: Vec<Block> = blocks.into_iter().map(|block| block.scaled(share)).collect();
        let sum = |f: fn(&Block) -> f64| blocks.iter().map(f).sum::<f64>();
        let (values, relative) = (sum(|b| b.values), sum(|b| b.relative));
        let relmse = RelMse::of(&blocks, independent);
        let (evidence, tail) = Evidence::of(self, known, mean.value, epsilon.sqrt());
        let trust = evidence.verdict(&relmse, known, self.replicates());
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

/// Sums over the pixels and channels of a block.
#[derive(Default)]
pub(super) struct Block {
    pub(super) values: f64,
    /// Relative variance, as yet without what the whole image says of the noise of denominators.
    pub(super) relative: f64,
    sum: PixelError,
    /// That of `relative`; `None` where it is not known from within.
    pub(super) spread: Option<Spread>,
    /// By replicate: see [`super::replicates::Scratch`].
    pub(super) squares: Vec<f64>,
}

impl Block {
    fn of(pixels: &[usize], replicates: &Replicates<'_>, pairs: &Pairs, epsilon: f64, independent: Independent) -> Self {
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
        if planted(Defect::RelmseBiased) || block.sum.coupled <= 0.0 {
            return block;
        }
        if pairs.pairs.is_empty() { block.corrected() } else { Block { relative: block.sum.apart, ..block } }
    }

    /// The same with its `relative` times `share`, and what tells of the noise of that.
    fn scaled(self, share: f64) -> Self {
        let relative = share * self.relative;
        let of_squares = if self.sum.coupled > 0.0 { relative / self.sum.coupled } else { 0.0 };
        let squares = self.squares.iter().map(|square| square * of_squares).collect();
        Block { relative, spread: self.spread.map(|spread| spread.scaled(share)), squares, ..self }
    }

    /// Without the bias to first order in the noise of the whole mean.
    fn corrected(self) -> Self {
        let PixelError { coupled, curvature, skew, .. } = self.sum;
        let delta = ((curvature - skew) / coupled).max(LEAST_DELTA);
        Block { relative: coupled / (1.0 + delta + SECOND_ORDER * delta * delta), ..self }
    }
}

/// T / T_½, by which T is extrapolated to denominators without noise: see the module's head.
fn extrapolation(blocks: &[Block]) -> f64 {
    let sum = |f: fn(&Block) -> f64| blocks.iter().map(f).sum::<f64>();
    let [all, half] = [sum(|b| b.sum.apart), sum(|b| b.sum.half_apart)];
    let is_left = planted(Defect::CurvatureForgotten) || planted(Defect::RelmseBiased);
    if half > 0.0 && !is_left { all / half } else { 1.0 }
}

/// The pixels of each block, by index within the crop.
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

/// The largest sample of the image, whose `mean` is that of its pixels and channels.
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
