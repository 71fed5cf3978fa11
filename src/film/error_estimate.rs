//! The error that an image carries, from its replicates.
//!
//! Replicates are independent whatever happens inside one (random, QMC, chains), so the error of the mean follows from how
//! they differ. The relative error pools over the image; its interval takes blocks of 8×8 pixels as independent, which holds
//! for methods whose pixels have their own samples and not for those that share chains, photons or light vertices.
//!
//! Bias: the squared reference m² in a denominator is itself an estimate, from the replicates that the numerator does not
//! use; at relative variance v of it (about relMSE × R/(R−2)) the result is too high by up to a factor 1 + 3 v.

use super::{Film, Layout, Plane};
use crate::stats::{Estimate, Moments};
use rayon::prelude::*;

/// ε is the square of this share of the image mean, so that black pixels do not dominate.
const FLOOR: f64 = 0.1;
/// Pairs of replicates further apart than this (cyclically) are left out: they would cost R² and add almost nothing.
const PAIR_DISTANCE: usize = 4;
/// Side of the blocks of pixels that are taken as independent; halved until there are at least 16 of them.
const BLOCK: usize = 8;
const COLOR: usize = 3;

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
}

/// The estimated error of an image's colour.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
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
    /// The largest share that one block of pixels has in `relmse`. Near 1, a few fireflies make the error and the
    /// interval cannot be trusted.
    pub max_share: f64,
}

fn null_is_infinite<'de, D: serde::Deserializer<'de>>(source: D) -> Result<f64, D::Error> {
    let value: Option<f64> = serde::Deserialize::deserialize(source)?;
    Ok(value.unwrap_or(f64::INFINITY))
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

    /// The error of the whole image; `None` with fewer than 2 replicates, an empty one, or no pixels.
    pub fn image_error(&self) -> Option<ImageError> {
        let replicates = Replicates::of(self)?;
        let mean = replicates.image_mean()?;
        let epsilon = (FLOOR * mean.value).powi(2);
        let pairs = replicates.pairs();
        let blocks: Vec<Block> =
            blocks(self.layout()).into_par_iter().map(|pixels| replicates.block(&pixels, &pairs, epsilon)).collect();
        let sum = |f: fn(&Block) -> f64| blocks.iter().map(f).sum::<f64>();
        let (values, relative) = (sum(|b| b.values), sum(|b| b.relative));
        let largest = blocks.iter().map(|b| b.relative).fold(0.0, f64::max);
        Some(ImageError {
            relmse: pooled(&blocks, relative, values),
            rmse: (sum(|b| b.variance) / values).sqrt(),
            mean: mean.value,
            mean_standard_error: mean.standard_error,
            epsilon,
            replicates: self.replicates(),
            max_share: if relative > 0.0 { largest / relative } else { 0.0 },
        })
    }
}

/// Sums over the pixels and channels of a block.
struct Block {
    values: f64,
    variance: f64,
    relative: f64,
}

/// Σ relative / Σ values with its t interval, by the jackknife over blocks [Efron81].
fn pooled(blocks: &[Block], relative: f64, values: f64) -> RelMse {
    let value = relative / values;
    let left_out: Moments = blocks.iter().map(|b| (relative - b.relative) / (values - b.values)).collect();
    let Some(variance) = left_out.variance().filter(|v| v.is_finite()) else {
        return RelMse { value, low: 0.0, high: f64::INFINITY };
    };
    let n = blocks.len() as f64;
    let standard_error = ((n - 1.0) * (n - 1.0) / n * variance).sqrt();
    let [low, high] = Estimate { value, standard_error, dof: n - 1.0 }.interval95();
    RelMse { value, low: low.max(0.0), high }
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

/// Two replicates, and what their difference says.
struct Pair {
    a: usize,
    b: usize,
    /// (m_a − m_b)² times this estimates Var(m) without bias.
    variance_weight: f64,
    /// 1 over the passes of the other replicates; 0 where there are none.
    others: f64,
}

/// The colour means of a film by replicate.
struct Replicates<'a> {
    film: &'a Film,
    counts: Vec<f64>,
    total: f64,
}

impl<'a> Replicates<'a> {
    fn of(film: &'a Film) -> Option<Self> {
        let counts: Vec<f64> = (0..film.replicates()).map(|r| film.passes_of(r) as f64).collect();
        let is_usable = counts.len() >= 2 && counts.iter().all(|&n| n > 0.0) && film.layout().pixels() > 0;
        is_usable.then(|| Replicates { film, total: counts.iter().sum(), counts })
    }

    /// The means m_r of one pixel and channel.
    fn means(&self, pixel: usize, channel: usize, out: &mut [f64]) {
        let unit = self.film.units().of(Plane::Color);
        let index = pixel * self.film.layout().channels() + channel;
        for ((mean, sums), n) in out.iter_mut().zip(self.film.sums()).zip(&self.counts) {
            *mean = sums.value(index) * unit / n;
        }
    }

    fn mean(&self, means: &[f64]) -> f64 {
        means.iter().zip(&self.counts).map(|(m, n)| m * n).sum::<f64>() / self.total
    }

    fn variance(&self, means: &[f64]) -> f64 {
        let mean = self.mean(means);
        let squares: f64 = means.iter().zip(&self.counts).map(|(m, n)| n / self.total * (m - mean) * (m - mean)).sum();
        squares / (self.counts.len() as f64 - 1.0)
    }

    /// The mean of the image with its standard error.
    fn image_mean(&self) -> Option<Estimate> {
        let pixels = self.film.layout().pixels();
        let rows: Vec<Vec<f64>> = (0..pixels.div_ceil(1024))
            .into_par_iter()
            .map(|chunk| self.sum_of_means(chunk * 1024..((chunk + 1) * 1024).min(pixels)))
            .collect();
        let values = (pixels * COLOR) as f64;
        let means: Vec<f64> = (0..self.counts.len()).map(|r| rows.iter().map(|row| row[r]).sum::<f64>() / values).collect();
        let dof = means.len() as f64 - 1.0;
        let value = self.mean(&means);
        value.is_finite().then(|| Estimate { value, standard_error: self.variance(&means).sqrt(), dof })
    }

    fn sum_of_means(&self, pixels: std::ops::Range<usize>) -> Vec<f64> {
        let (mut sums, mut means) = (vec![0.0; self.counts.len()], vec![0.0; self.counts.len()]);
        for pixel in pixels {
            for channel in 0..COLOR {
                self.means(pixel, channel, &mut means);
                sums.iter_mut().zip(&means).for_each(|(sum, m)| *sum += m);
            }
        }
        sums
    }

    fn pairs(&self) -> Vec<Pair> {
        let n = self.counts.len();
        let near = |a: usize, b: usize| (b - a).min(n - (b - a)) <= PAIR_DISTANCE;
        let all = (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b)));
        all.filter(|&(a, b)| near(a, b)).map(|(a, b)| self.pair(a, b)).collect()
    }

    fn pair(&self, a: usize, b: usize) -> Pair {
        let (na, nb) = (self.counts[a], self.counts[b]);
        let others = if self.counts.len() > 2 { 1.0 / (self.total - na - nb) } else { 0.0 };
        Pair { a, b, variance_weight: 1.0 / ((1.0 / na + 1.0 / nb) * self.total), others }
    }

    fn block(&self, pixels: &[usize], pairs: &[Pair], epsilon: f64) -> Block {
        let mut block = Block { values: (pixels.len() * COLOR) as f64, variance: 0.0, relative: 0.0 };
        let mut means = vec![0.0; self.counts.len()];
        for &pixel in pixels {
            for channel in 0..COLOR {
                self.means(pixel, channel, &mut means);
                block.variance += self.variance(&means);
                block.relative += self.relative_variance(&means, pairs, epsilon);
            }
        }
        block
    }

    /// Mean over pairs of Var(m) from the pair over m² + ε from the other replicates, so that the two are independent. With
    /// two replicates there are no others and m is the mean of both.
    fn relative_variance(&self, means: &[f64], pairs: &[Pair], epsilon: f64) -> f64 {
        let sum = self.mean(means) * self.total;
        let ratio = |pair: &Pair| {
            let (ma, mb) = (means[pair.a], means[pair.b]);
            let variance = (ma - mb) * (ma - mb) * pair.variance_weight;
            let others = (sum - ma * self.counts[pair.a] - mb * self.counts[pair.b]) * pair.others;
            let reference = if pair.others > 0.0 { others } else { sum / self.total };
            if variance > 0.0 { variance / (reference * reference + epsilon) } else { 0.0 }
        };
        pairs.iter().map(ratio).sum::<f64>() / pairs.len() as f64
    }
}

#[cfg(test)]
#[path = "error_estimate_tests.rs"]
mod tests;
