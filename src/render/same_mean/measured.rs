//! The comparisons of two pictures, tile by tile, with what may be missing from each.
//!
//! A tile that has missed its few large contributions looks dark and certain. How skewed its mean may be is therefore taken from
//! three places, whichever says most: the tile itself, the 5×5 tiles around it, and all tiles of that size that are at least a
//! tenth as bright as the picture; the latter two relative to the brightness, which under the hypothesis is that of either candidate.

use super::tiles::{CHANNELS, Pyramid};
use crate::defects::{Defect, planted};
use crate::film::Crop;
use crate::stats::{Estimate, Skewness, TestResult, detectable_difference, skewed_welch_test};

/// Differences up to this share of the brighter mean are rounding: some hundred roundings of f32 (2⁻²⁴ each) all in one
/// direction, as two backends may make them.
const ROUNDING: f64 = 1.0 / 131_072.0;
/// Tiles darker than this share of the picture do not speak for all: their relative skewness has no bound.
const DARK: f64 = 0.1;
/// The probability with which a detectable difference would have been found.
pub(super) const POWER: f64 = 0.9;

/// Two means of one channel of one tile.
#[derive(Debug, Clone, Copy)]
pub(super) struct Comparison {
    pub(super) area: Crop,
    pub(super) channel: usize,
    pub(super) a: Estimate,
    pub(super) b: Estimate,
    skewness: Skewness,
}

/// What two candidates have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kin {
    /// The same method with another backend: what one sees the other should.
    SameMethod,
    /// Another method: one may have found light by luck that the other had none of.
    OtherMethod,
}

impl Comparison {
    /// t, corrected for skewness, and its two-sided p-value. Two means without errors are not noisy: they are the same, or they are not.
    /// The darker may have missed so much of the difference, as a sum over pixels: `unseen`, of either.
    pub(super) fn test(&self, unseen: [f64; 2]) -> TestResult {
        let missed = unseen[usize::from(self.b.value < self.a.value)] / self.area.pixels() as f64;
        let slack = ROUNDING * self.a.value.abs().max(self.b.value.abs()) + missed;
        let is_exact = is_certain(&self.a) && is_certain(&self.b) && !planted(Defect::ExactIsNoise);
        let skewness = if is_exact { Skewness::default() } else { self.skewness };
        skewed_welch_test(&self.a, &self.b, skewness, slack)
    }

    /// The relative difference that would have been found at `level`; infinite where none can be.
    pub(super) fn detectable(&self, level: f64) -> f64 {
        let mean = self.mean();
        let found = detectable_difference(&self.a, &self.b, self.skewness, level, POWER);
        if mean > 0.0 { found / mean + ROUNDING } else { f64::INFINITY }
    }

    /// The mean of both.
    pub(super) fn mean(&self) -> f64 {
        0.5 * (self.a.value + self.b.value)
    }
}

/// Whether all samples behind a mean are the same but for rounding, that of the film's sums included.
fn is_certain(mean: &Estimate) -> bool {
    mean.standard_error <= ROUNDING * mean.value.abs()
}

/// The comparisons of all levels that both have samples for, each level apart: the smallest tiles first, the image last.
pub(super) fn compare(a: &Pyramid, b: &Pyramid, kin: Kin) -> Vec<Vec<Comparison>> {
    let lucky = |channel: usize| {
        let [black_a, black_b] = [a, b].map(|p| saw_nothing(p, channel));
        let is_between = kin == Kin::OtherMethod;
        [is_between && black_a && !black_b, is_between && black_b && !black_a]
    };
    let level = |i: usize| (0..CHANNELS).flat_map(|c| channel([a, b], i, c, lucky(c))).collect();
    (a.first.max(b.first)..a.levels.len().min(b.levels.len())).map(level).collect()
}

/// Whether all of a channel is black and certain.
fn saw_nothing(picture: &Pyramid, channel: usize) -> bool {
    let estimate = picture.image_mean(channel);
    estimate.value <= 0.0 && estimate.standard_error <= 0.0
}

/// All tiles of one level in one channel; a side that is `unlucky` may be missing anything.
fn channel(pictures: [&Pyramid; 2], level: usize, channel: usize, unlucky: [bool; 2]) -> Vec<Comparison> {
    let estimates = pictures.map(|p| p.levels[level].tiles.iter().map(|t| p.estimate(t, channel)).collect::<Vec<_>>());
    let darker: Vec<f64> = estimates[0].iter().zip(&estimates[1]).map(|(a, b)| a.value.min(b.value).max(0.0)).collect();
    let thirds = pictures.map(|p| thirds(p, level, channel, &darker));
    let comparison = |i: usize| {
        let (x, y) = (estimates[0][i], estimates[1][i]);
        let brighter = x.value.max(y.value).max(0.0).powi(3);
        let deviation = x.standard_error.hypot(y.standard_error).powi(3);
        let lambda = |side: usize| match thirds[side][i].most(brighter) {
            _ if unlucky[side] => f64::INFINITY,
            third if third > 0.0 => third / deviation,
            _ => 0.0,
        };
        let skewness = Skewness { of_a: lambda(0), of_b: lambda(1) };
        Comparison { area: pictures[0].levels[level].tiles[i].area, channel, a: x, b: y, skewness }
    };
    (0..darker.len()).map(comparison).collect()
}

/// The third cumulant of a tile's mean.
struct Third {
    own: f64,
    /// Over the cube of the brightness, here or all over the picture.
    relative: f64,
}

impl Third {
    fn most(&self, cubed_brightness: f64) -> f64 {
        self.own.max(self.relative * cubed_brightness).max(0.0)
    }
}

fn thirds(picture: &Pyramid, level: usize, channel: usize, darker: &[f64]) -> Vec<Third> {
    let level = &picture.levels[level];
    let own: Vec<f64> = level.tiles.iter().map(|t| picture.third(t, channel)).collect();
    let cubes: Vec<f64> = darker.iter().map(|m| m.powi(3)).collect();
    let mean = darker.iter().sum::<f64>() / darker.len() as f64;
    let bright: Vec<usize> = (0..own.len()).filter(|&i| darker[i] > 0.0 && darker[i] >= DARK * mean).collect();
    let everywhere = bright.iter().map(|&i| own[i] / cubes[i]).sum::<f64>() / bright.len().max(1) as f64;
    let around = |i: usize| {
        let [third, cube] = level.around(i).fold([0.0; 2], |[t, c], j| [t + own[j], c + cubes[j]]);
        if cube > 0.0 { third / cube } else { 0.0 }
    };
    own.iter().enumerate().map(|(i, &own)| Third { own, relative: around(i).max(everywhere) }).collect()
}
