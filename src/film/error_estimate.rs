//! The error that an image carries, from its replicates.
//!
//! Replicates are independent whatever happens inside one (random, QMC, chains), so the error of the mean follows from how
//! they differ. The relative error pools over the image; its interval comes from what the method says is [`Independent`]: pixels,
//! blocks of them, or replicates alone. Errors are positive and their estimates skewed, the more the fewer pixels make up the
//! error: the interval is Hall's.
//!
//! Bias: the m² of a denominator is itself an estimate. At relative variance v of m that makes the result too high by 3 v for
//! normal samples and too low by v for exponential ones, whose large V come with large m. Both effects are estimated to first
//! order, together δ, block by block, and taken out as 1 / (1 + δ + δ²/2). What may be left widens the interval ([`RESIDUAL`]): with
//! four replicates of normal, exponential and binary samples at v up to 0.1 it is half the square of the curvature's part, 3 v; on
//! the Cornell box at 16 samples per pixel, whose pixels are more skewed than that, three times that square. (Denominators from
//! replicates that the numerator does not use are noisier: a pixel that sees a small lamp in one of two then has the error of a
//! black one.)
//!
//! A mean that few chains brought is more skewed still, and few replicates show too little of it: on the Cornell box with all light
//! left to chains, where skewness put the share k back, up to 2.1 k² of the result was missing. First order helps up to k = .17
//! there; from .32 on results were up to a quarter too low, and those of path tracing on small lamps up to 60 %.

use super::noise::{Independent, Noise, squares};
use super::peaks::Peak;
use super::replicates::{COLOR, PixelError, Replicates};
use super::spread::{Pairs, Patch, Spread};
use super::{Evidence, Film, Known, Layout, Trust, evidence};
use crate::stats::pareto::Tail;
use crate::stats::{skewed_quantile, student_quantile};
use rayon::prelude::*;

/// ε is the square of this share of the image mean, so that black pixels do not dominate.
const FLOOR: f64 = 0.1;
/// Side of the blocks of pixels that share work, and whose share of the error is reported; halved until there are at least 16.
const BLOCK: usize = 8;
/// See the module's head.
const SECOND_ORDER: f64 = 0.5;
const RESIDUAL: f64 = 3.5;
/// The same for the square of skewness's part of δ over an image of which replicates alone are independent: see the module's head.
const SKEWED_RESIDUAL: f64 = 2.1;
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
    /// What noisy denominators do to `value` by the curvature of the division, as a share of it; taken out to first order.
    pub curvature_bias: f64,
    /// What skewed samples do against that: they are bright where their variance is large. Put back to first order.
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
        let share = |f: fn(&Block) -> f64| if relative > 0.0 { sum(f) / relative } else { 0.0 };
        let skewness_bias = share(|b| b.skew);
        let skewed = if independent == Independent::Replicates { SKEWED_RESIDUAL } else { 0.0 };
        let empty = RelMse {
            value: relative / values,
            low: 0.0,
            high: 0.0,
            standard_error,
            skewness,
            dof,
            curvature_bias: share(|b| b.curvature),
            skewness_bias,
            bias_bound: sum(|b| b.residual).max(skewed * skewness_bias * skewness_bias * relative) / values,
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
        let sum = |f: fn(&Block) -> f64| blocks.iter().map(f).sum::<f64>();
        let (values, relative) = (sum(|b| b.values), sum(|b| b.relative));
        let relmse = RelMse::of(&blocks, independent);
        let (evidence, tail) = evidence::of(self, known, mean.value, epsilon.sqrt(), &squares(&blocks, values));
        let trust = evidence::verdict(&relmse, &evidence, tail.as_ref(), known, self.replicates());
        let largest = blocks.iter().map(|b| b.relative).fold(0.0, f64::max);
        Some(ImageError {
            relmse,
            rmse: (sum(|b| b.variance) / values).sqrt(),
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
    variance: f64,
    /// Without the bias of denominators.
    pub(super) relative: f64,
    /// The curvature's part of that bias.
    curvature: f64,
    /// What skewness takes off it.
    skew: f64,
    /// What of it may be left.
    residual: f64,
    /// That of `relative`; `None` where it is not known from within.
    pub(super) spread: Option<Spread>,
    /// By replicate: see [`super::replicates::Scratch`].
    pub(super) squares: Vec<f64>,
}

impl Block {
    fn of(pixels: &[usize], replicates: &Replicates<'_>, pairs: &Pairs, epsilon: f64, independent: Independent) -> Self {
        let (mut scratch, mut excess) = (replicates.scratch(pairs), 0.0);
        let mut block = Block { spread: Some(Spread::default()), ..Block::default() };
        for together in pixels.chunks(independent.together(pixels.len())) {
            let mut patch = Patch::empty(pairs);
            for &pixel in together {
                let error = replicates.pixel(pixel, epsilon, pairs, &mut scratch, &mut patch);
                block.add(&error);
                excess += error.excess;
            }
            block.spread = block.spread.zip(pairs.spread(&patch)).map(|(sum, spread)| sum + spread);
        }
        block.squares = scratch.squares;
        if block.relative > 0.0 {
            block.correct(excess / block.relative);
        }
        block
    }

    fn add(&mut self, pixel: &PixelError) {
        self.values += COLOR as f64;
        self.variance += pixel.variance;
        self.relative += pixel.relative;
        self.curvature += pixel.curvature;
        self.skew += pixel.skew;
    }

    /// Takes out the bias that makes up the share `delta` of `relative`.
    fn correct(&mut self, delta: f64) {
        let (delta, curvature) = (delta.max(LEAST_DELTA), self.curvature / self.relative);
        let share = 1.0 / (1.0 + delta + SECOND_ORDER * delta * delta);
        self.relative *= share;
        self.curvature *= share;
        self.skew *= share;
        self.residual = RESIDUAL * curvature * curvature * self.relative;
        self.spread = self.spread.map(|spread| spread.scaled(share));
        self.squares.iter_mut().for_each(|square| *square *= share);
    }
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
