//! What the replicates of a film say about each pixel: means, the variance of their mean, the variance relative to the square.

use super::{Film, Plane};
use crate::defects::{Defect, planted};
use crate::stats::{Estimate, third_cumulant_of_mean};
use rayon::prelude::*;

/// Channels of colour.
pub(super) const COLOR: usize = 3;
/// Pairs of replicates further apart than this (cyclically) are left out: they would cost R² and add almost nothing.
const PAIR_DISTANCE: usize = 4;

/// The colour means of a film by replicate.
pub(super) struct Replicates<'a> {
    film: &'a Film,
    pub(super) counts: Vec<f64>,
    total: f64,
}

/// Two replicates, and what their difference says.
struct Pair {
    a: usize,
    b: usize,
    /// (m_a − m_b)² times this estimates Var(m) without bias.
    variance_weight: f64,
}

/// Σ over the channels of a pixel.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PixelError {
    /// Var(m).
    pub(super) variance: f64,
    /// Var(m) / (m² + ε), biased by the noise in m.
    pub(super) relative: f64,
    /// That bias, to first order.
    pub(super) excess: f64,
    /// The part of it that is due to the curvature of the division.
    pub(super) curvature: f64,
    /// The noise of `relative`; `None` with fewer than four replicates.
    pub(super) spread: Option<Spread>,
}

/// How an estimate is distributed, its denominators taken as known. Those of independent estimates add up to that of their sum.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Spread {
    /// Its variance, without bias; may be negative.
    pub(super) variance: f64,
    /// What the variance would be if replicates were normal, without bias.
    pub(super) of_normal: f64,
    /// Its third cumulant, rather too large than too small.
    pub(super) third: f64,
}

impl Spread {
    /// That of `scale` times the estimate.
    pub(super) fn scaled(self, scale: f64) -> Self {
        let square = scale * scale;
        Spread { variance: square * self.variance, of_normal: square * self.of_normal, third: square * scale * self.third }
    }
}

impl std::ops::Add for Spread {
    type Output = Spread;

    fn add(self, b: Spread) -> Spread {
        Spread { variance: self.variance + b.variance, of_normal: self.of_normal + b.of_normal, third: self.third + b.third }
    }
}

impl std::iter::Sum for Spread {
    fn sum<I: Iterator<Item = Spread>>(spreads: I) -> Spread {
        spreads.fold(Spread::default(), std::ops::Add::add)
    }
}

/// How the relative variances of pixels are estimated from pairs of replicates.
pub(super) struct Pairs {
    pairs: Vec<Pair>,
    /// Pairs of pairs that share no replicate, by index.
    disjoint: Vec<[usize; 2]>,
    /// The weights of Var(d) and of tr C² in a variance, and that of the latter if samples are normal: see [`Pairs::spread`].
    spread_weights: [f64; 3],
    epsilon: f64,
}

/// Numbers that are needed for one pixel after the other.
pub(super) struct Scratch {
    means: Vec<f64>,
    /// By pair and channel: signed roots of relative variances.
    terms: Vec<[f64; COLOR]>,
}

impl<'a> Replicates<'a> {
    /// `None` with fewer than 2 replicates, an empty one, or no pixels.
    pub(super) fn of(film: &'a Film) -> Option<Self> {
        let counts: Vec<f64> = (0..film.replicates()).map(|r| film.passes_of(r) as f64).collect();
        let is_usable = counts.len() >= 2 && counts.iter().all(|&n| n > 0.0) && film.layout().pixels() > 0;
        is_usable.then(|| Replicates { film, total: counts.iter().sum(), counts })
    }

    /// The means m_r of one pixel and channel.
    pub(super) fn means(&self, pixel: usize, channel: usize, out: &mut [f64]) {
        let unit = self.film.units().of(Plane::Color);
        let index = pixel * self.film.layout().channels() + channel;
        for ((mean, sums), n) in out.iter_mut().zip(self.film.sums()).zip(&self.counts) {
            let n = if planted(Defect::ReplicatesAlike) { self.total / self.counts.len() as f64 } else { *n };
            *mean = sums.value(index) * unit / n;
        }
    }

    fn mean(&self, means: &[f64]) -> f64 {
        means.iter().zip(&self.counts).map(|(m, n)| m * n).sum::<f64>() / self.total
    }

    /// Var(m), without bias where the variance of m_r goes as 1/n_r.
    pub(super) fn variance(&self, means: &[f64]) -> f64 {
        let mean = self.mean(means);
        let squares: f64 = means.iter().zip(&self.counts).map(|(m, n)| n / self.total * (m - mean) * (m - mean)).sum();
        let one = if planted(Defect::ErrorOfOneReplicate) { self.counts.len() as f64 } else { 1.0 };
        one * squares / (self.counts.len() as f64 - 1.0)
    }

    /// The mean of the image with its standard error.
    pub(super) fn image_mean(&self) -> Option<Estimate> {
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

    /// The pairs for relative variances over m² + `epsilon`.
    pub(super) fn pairs(&self, epsilon: f64) -> Pairs {
        let n = self.counts.len();
        let near = |a: usize, b: usize| (b - a).min(n - (b - a)) <= PAIR_DISTANCE;
        let all = (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b)));
        let pairs: Vec<Pair> = all.filter(|&(a, b)| near(a, b)).map(|(a, b)| self.pair(a, b)).collect();
        let disjoint = disjoint(&pairs, n);
        Pairs { spread_weights: spread_weights(pairs.len() as f64, n as f64), pairs, disjoint, epsilon }
    }

    fn pair(&self, a: usize, b: usize) -> Pair {
        let (na, nb) = (self.counts[a], self.counts[b]);
        Pair { a, b, variance_weight: 1.0 / ((1.0 / na + 1.0 / nb) * self.total) }
    }

    /// Space for [`Replicates::pixel`].
    pub(super) fn scratch(&self, pairs: &Pairs) -> Scratch {
        Scratch { means: vec![0.0; self.counts.len()], terms: vec![[0.0; COLOR]; pairs.pairs.len()] }
    }

    /// The error of one pixel.
    pub(super) fn pixel(&self, pixel: usize, pairs: &Pairs, scratch: &mut Scratch) -> PixelError {
        let mut error = PixelError::default();
        for channel in 0..COLOR {
            self.means(pixel, channel, &mut scratch.means);
            self.add_channel(channel, pairs, scratch, &mut error);
        }
        error.relative = scratch.terms.iter().map(square).sum::<f64>() / scratch.terms.len() as f64;
        error.spread = pairs.spread(&scratch.terms, error.relative);
        error
    }

    /// Adds a channel's variance and bias, and sets its root of Var(m) / (m² + ε) by each pair.
    ///
    /// With V an estimate of Var(m) and g(m) = 1 / (m² + ε), E V g(m) is V g(μ) + g″ V² / 2 + g′ κ to first order: g is curved, and a
    /// skewed m (third cumulant κ) is large where V is. V² of R normal values is too large by (R + 1) / (R − 1).
    fn add_channel(&self, channel: usize, pairs: &Pairs, scratch: &mut Scratch, error: &mut PixelError) {
        let (means, replicates) = (&scratch.means, self.counts.len() as f64);
        let (mean, variance) = (self.mean(means), self.variance(means));
        scratch.terms.iter_mut().for_each(|term| term[channel] = 0.0);
        if variance <= 0.0 {
            return; // black, perhaps in a black image, where even ε is 0
        }
        let g = 1.0 / (mean * mean + pairs.epsilon);
        let second = (6.0 * mean * mean - 2.0 * pairs.epsilon) * g * g * g;
        let curvature = 0.5 * second * variance * variance * (replicates - 1.0) / (replicates + 1.0);
        error.variance += variance;
        error.curvature += curvature;
        if !planted(Defect::RelmseBiased) {
            error.excess += curvature - 2.0 * mean * g * g * third_cumulant_of_mean(means, mean);
        }
        for (pair, term) in pairs.pairs.iter().zip(&mut scratch.terms) {
            term[channel] = (means[pair.a] - means[pair.b]) * (pair.variance_weight * g).sqrt();
        }
    }
}

impl Pairs {
    /// The spread of T, the `mean` of the squares of `terms`, from pairs of them that share no replicate.
    ///
    /// Let d = |e|² be the square of a pair's term, C the covariance of e and κ what Var(d) has beyond that of a normal e:
    /// Var(d) = 2 tr C² + κ/2. Squares that share a replicate covary by a quarter of 2 tr C² + κ, so that the mean of P of them, k
    /// to a replicate, has the variance (1 + k)/P tr C² + κ/R. Disjoint pairs are independent: half the squared difference of
    /// their d estimates Var(d), the square of their e · e′ estimates tr C².
    ///
    /// The third cumulant would need six replicates. With S the variance, that of a gamma distribution, as of normal samples, is
    /// 2 S²/T; that of rare events, of which each brings T² to S, is S T. The smaller one fits both.
    fn spread(&self, terms: &[[f64; COLOR]], mean: f64) -> Option<Spread> {
        if self.disjoint.is_empty() {
            return None;
        }
        let [differences, products] = self.disjoint.iter().fold([0.0, 0.0], |[d, p], &[i, j]| {
            let difference = square(&terms[i]) - square(&terms[j]);
            [d + 0.5 * difference * difference, p + dot(&terms[i], &terms[j]).powi(2)]
        });
        let deals = self.disjoint.len() as f64;
        let [of_differences, of_products, of_normal] = self.spread_weights;
        let variance = (of_differences * differences + of_products * products) / deals;
        let positive = variance.max(0.0);
        let third = if mean > 0.0 { positive * mean.min(2.0 * positive / mean) } else { 0.0 };
        Some(Spread { variance, of_normal: of_normal * products / deals, third })
    }
}

fn dot(a: &[f64; COLOR], b: &[f64; COLOR]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn square(a: &[f64; COLOR]) -> f64 {
    dot(a, a)
}

/// The weights for the mean of `pairs` squares between `replicates`: see [`Pairs::spread`].
fn spread_weights(pairs: f64, replicates: f64) -> [f64; 3] {
    let of_normal = (1.0 + 2.0 * pairs / replicates) / pairs;
    [2.0 / replicates, of_normal - 4.0 / replicates, of_normal]
}

/// The three ways to deal four neighbouring replicates into two pairs, for each whole four of `replicates`.
fn disjoint(pairs: &[Pair], replicates: usize) -> Vec<[usize; 2]> {
    let find = |a: usize, b: usize| pairs.iter().position(|p| (p.a, p.b) == (a, b));
    let fours = (0..replicates / 4).map(|i| 4 * i);
    let deals = fours.flat_map(|r| [[(r, r + 1), (r + 2, r + 3)], [(r, r + 2), (r + 1, r + 3)], [(r, r + 3), (r + 1, r + 2)]]);
    deals.filter_map(|[p, q]| Some([find(p.0, p.1)?, find(q.0, q.1)?])).collect()
}
