//! Statistics of the replicates of a film by pixel: means, the variance of their mean, and its relative variance.

use super::estimator_variance::{Pair, Pairs, Patch};
use super::layout::COLOR;
use super::{Film, Plane};
use crate::stats::{Estimate, third_cumulant_of_mean};
use rayon::prelude::*;

/// Colour means of a film by replicate.
pub(super) struct Replicates<'a> {
    film: &'a Film,
    pub(super) counts: Vec<f64>,
    total: f64,
}

/// Sums over the channels of a pixel.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PixelError {
    /// Var(m).
    pub(super) variance: f64,
    /// Var(m) / (m² + ε), biased by the noise of m and its correlation with Var(m).
    pub(super) coupled: f64,
    /// The same by pairs and the means of the other replicates, biased only by the noise of these means.
    pub(super) apart: f64,
    /// The same by the means of half of the others, which have twice the variance.
    pub(super) half_apart: f64,
    /// First-order bias of `coupled` due to the nonlinearity of the division.
    pub(super) curvature: f64,
    /// First-order reduction of `coupled` by the skewness of m.
    pub(super) skew: f64,
}

impl std::ops::AddAssign for PixelError {
    fn add_assign(&mut self, other: PixelError) {
        let PixelError { variance, coupled, apart, half_apart, curvature, skew } = other;
        self.variance += variance;
        self.coupled += coupled;
        self.apart += apart;
        self.half_apart += half_apart;
        self.curvature += curvature;
        self.skew += skew;
    }
}

/// Buffers of a sum over pixels, and its parts by pair or replicate.
pub(super) struct Scratch {
    means: Vec<f64>,
    /// By pair and channel: signed square roots of relative variances.
    roots: Vec<[f64; COLOR]>,
    /// By replicate, summed over pixels: n_r/N (m_r − m)² / (m² + ε). Their total is (R − 1) times the sum of relative
    /// variances.
    pub(super) squares: Vec<f64>,
}

impl<'a> Replicates<'a> {
    /// Returns `None` with fewer than 2 replicates, an empty one, or no pixels.
    pub(super) fn of(film: &'a Film) -> Option<Self> {
        let counts: Vec<f64> = (0..film.replicates()).map(|r| film.passes_of(r) as f64).collect();
        let is_usable = counts.len() >= 2 && counts.iter().all(|&n| n > 0.0) && film.layout().pixels() > 0;
        is_usable.then(|| Replicates { film, total: counts.iter().sum(), counts })
    }

    /// Writes the means m_r of one pixel and channel to `out`.
    pub(super) fn means(&self, pixel: usize, channel: usize, out: &mut [f64]) {
        let unit = self.film.units().of(Plane::Color);
        let index = pixel * self.film.layout().channels() + channel;
        for ((mean, sums), n) in out.iter_mut().zip(self.film.sums()).zip(&self.counts) {
            *mean = sums.value(index) * unit / n;
        }
    }

    fn mean(&self, means: &[f64]) -> f64 {
        means.iter().zip(&self.counts).map(|(m, n)| m * n).sum::<f64>() / self.total
    }

    /// Returns an estimate of Var(m), which is unbiased where the variance of m_r is proportional to 1/n_r.
    pub(super) fn variance(&self, means: &[f64]) -> f64 {
        let mean = self.mean(means);
        let squares: f64 = means.iter().zip(&self.counts).map(|(m, n)| n / self.total * (m - mean) * (m - mean)).sum();
        squares / (self.counts.len() as f64 - 1.0)
    }

    /// Returns the mean of the image with its standard error.
    pub(super) fn image_mean(&self) -> Option<Estimate> {
        let pixels = self.film.layout().pixels();
        let rows: Vec<Vec<f64>> = (0..pixels.div_ceil(1024))
            .into_par_iter()
            .map(|chunk| self.sum_of_means(chunk * 1024..((chunk + 1) * 1024).min(pixels)))
            .collect();
        let values = (pixels * COLOR) as f64;
        let means: Vec<f64> =
            (0..self.counts.len()).map(|r| rows.iter().map(|row| row[r]).sum::<f64>() / values).collect();
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

    /// Allocates buffers for sums over pixels.
    pub(super) fn scratch(&self, pairs: &Pairs) -> Scratch {
        let replicates = self.counts.len();
        Scratch {
            means: vec![0.0; replicates],
            roots: vec![[0.0; COLOR]; pairs.pairs.len()],
            squares: vec![0.0; replicates],
        }
    }

    /// Returns the error of one pixel, relative to m² + `epsilon`, and adds it to `patch`.
    pub(super) fn pixel(
        &self,
        pixel: usize,
        epsilon: f64,
        pairs: &Pairs,
        scratch: &mut Scratch,
        patch: &mut Patch,
    ) -> PixelError {
        let mut error = PixelError::default();
        for channel in 0..COLOR {
            self.means(pixel, channel, &mut scratch.means);
            let g = self.add_channel(&scratch.means, epsilon, &mut error);
            self.tell_apart(channel, g, epsilon, pairs, scratch, &mut error);
        }
        patch.add(error.apart, &scratch.roots);
        error
    }

    /// Adds a channel's variance, its relative variance by the whole mean, and the bias terms of the latter. Returns 1
    /// / (m² + `epsilon`), or 0 for a black pixel.
    ///
    /// With V an estimate of Var(m) and g(m) = 1 / (m² + ε), E V g(m) is V g(μ) + g″ V² / 2 + g′ κ to first order. The
    /// second term is due to the curvature of g, the third to the correlation of m and V (third cumulant κ). V² of R
    /// normal values is too large by the factor (R + 1) / (R − 1).
    fn add_channel(&self, means: &[f64], epsilon: f64, error: &mut PixelError) -> f64 {
        let replicates = self.counts.len() as f64;
        let (mean, variance) = (self.mean(means), self.variance(means));
        if variance <= 0.0 {
            return 0.0; // black, perhaps in a black image, where even ε is 0
        }
        let g = 1.0 / (mean * mean + epsilon);
        let second = (6.0 * mean * mean - 2.0 * epsilon) * g * g * g;
        error.variance += variance;
        error.coupled += variance * g;
        error.curvature += 0.5 * second * variance * variance * (replicates - 1.0) / (replicates + 1.0);
        error.skew += 2.0 * mean * g * g * third_cumulant_of_mean(means, mean);
        g
    }

    /// Computes the square roots of the channel's Var(m) g for each pair and adds their squares to `error`. The
    /// denominators are the means of replicates outside the pair: all of them, and half of them. With fewer than four
    /// replicates there are no pairs, and only the whole mean `g` is available.
    fn tell_apart(
        &self,
        channel: usize,
        g: f64,
        epsilon: f64,
        pairs: &Pairs,
        scratch: &mut Scratch,
        error: &mut PixelError,
    ) {
        let Scratch { means, roots, squares } = scratch;
        let (each, halves) = (1.0 / pairs.pairs.len().max(1) as f64, self.halves(means));
        for (pair, root) in pairs.pairs.iter().zip(roots) {
            let difference = means[pair.a] - means[pair.b];
            let [all, half] = self.apart(means, &halves, pair, epsilon);
            let [all, half] = if g > 0.0 { [all, half] } else { [0.0; 2] };
            root[channel] = difference * (pair.variance_weight * all).sqrt();
            let variance = each * pair.variance_weight * difference * difference;
            error.apart += variance * all;
            error.half_apart += variance * half;
        }
        let mean = self.mean(means);
        for ((square, m), n) in squares.iter_mut().zip(means.iter()).zip(&self.counts) {
            *square += n / self.total * (m - mean) * (m - mean) * g;
        }
    }

    /// Returns the weighted sums of even and of odd replicates, with their passes.
    fn halves(&self, means: &[f64]) -> [[f64; 2]; 2] {
        let mut halves = [[0.0; 2]; 2];
        for (r, (mean, count)) in means.iter().zip(&self.counts).enumerate() {
            let half = &mut halves[r % 2];
            *half = [half[0] + mean * count, half[1] + count];
        }
        halves
    }

    /// Returns 1 / (m² + `epsilon`) from the replicates outside `pair`: by the mean of all of them, and averaged over
    /// the two halves. Each half has one of the other two replicates of the pair's group of four. The rest is split
    /// into even and odd replicates.
    fn apart(&self, means: &[f64], halves: &[[f64; 2]; 2], pair: &Pair, epsilon: f64) -> [f64; 2] {
        let (four, mut sums) = (pair.a / 4 * 4, *halves);
        for (i, (half, own)) in sums.iter_mut().zip(pair.others).enumerate() {
            for (r, sign) in [(four + i, -1.0), (four + i + 2, -1.0), (own, 1.0)] {
                *half = [half[0] + sign * means[r] * self.counts[r], half[1] + sign * self.counts[r]];
            }
        }
        let g = |[sum, count]: [f64; 2]| 1.0 / ((sum / count) * (sum / count) + epsilon);
        [g([sums[0][0] + sums[1][0], sums[0][1] + sums[1][1]]), 0.5 * (g(sums[0]) + g(sums[1]))]
    }
}
