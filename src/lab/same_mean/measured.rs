//! Tile-by-tile comparisons of two pictures, with allowance for light that either may have missed.
//!
//! Tiles that missed their few large contributions underestimate mean and variance together. The third cumulant of a
//! tile's mean is therefore the largest of three estimates: from the tile itself, from the 5×5 tiles around it, and
//! from all tiles of that size that are at least a tenth as bright as the picture. The latter two are relative to
//! brightness, which is the same for both candidates under the hypothesis.

use crate::film::Crop;
use crate::film::pyramid::{CHANNELS, Pyramid};
use crate::stats::{Estimate, Skewness, TestResult, detectable_difference, skewed_welch_test};

/// Relative differences up to this bound count as rounding: some hundred f32 roundings (2⁻²⁴ each) in one direction, as
/// may occur between two backends.
const ROUNDING: f64 = 1.0 / 131_072.0;
/// Tiles darker than this fraction of the picture are left out of the global estimate: their relative skewness is
/// unbounded.
const DARK: f64 = 0.1;
/// Power for which detectable differences are stated.
pub(super) const POWER: f64 = 0.9;

/// Comparison of two means of one channel of one tile.
#[derive(Debug, Clone, Copy)]
pub(super) struct Comparison {
    pub(super) area: Crop,
    pub(super) channel: usize,
    pub(super) a: Estimate,
    pub(super) b: Estimate,
    skewness: Skewness,
}

/// Relation of two candidates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kin {
    /// The same method on different backends: both sample the same light.
    SameMethod,
    /// Different methods: one may have found, by chance, light that the other missed entirely.
    OtherMethod,
}

impl Comparison {
    /// Skewness-corrected Welch test, two-sided. Means without error are compared exactly. The difference is reduced by
    /// the light that the darker picture may have missed: `unseen`, for either picture, as a sum over pixels.
    pub(super) fn test(&self, unseen: [f64; 2]) -> TestResult {
        let missed = unseen[usize::from(self.b.value < self.a.value)] / self.area.pixels() as f64;
        let slack = ROUNDING * self.a.value.abs().max(self.b.value.abs()) + missed;
        let is_exact = is_certain(&self.a) && is_certain(&self.b);
        let skewness = if is_exact { Skewness::default() } else { self.skewness };
        skewed_welch_test(&self.a, &self.b, skewness, slack)
    }

    /// Returns the relative difference that is detected at `level` with probability [`POWER`]; infinite if there is
    /// none.
    pub(super) fn detectable(&self, level: f64) -> f64 {
        let mean = self.mean();
        let found = detectable_difference(&self.a, &self.b, self.skewness, level, POWER);
        if mean > 0.0 { found / mean + ROUNDING } else { f64::INFINITY }
    }

    /// Returns the mean of both.
    pub(super) fn mean(&self) -> f64 {
        0.5 * (self.a.value + self.b.value)
    }
}

/// Whether all samples of a mean are equal up to rounding, including that of the film's sums.
fn is_certain(mean: &Estimate) -> bool {
    mean.standard_error <= ROUNDING * mean.value.abs()
}

/// Returns the comparisons of all levels that are testable in both pictures, level by level: the smallest tiles first,
/// the image last.
pub(super) fn compare(a: &Pyramid, b: &Pyramid, kin: Kin) -> Vec<Vec<Comparison>> {
    let lucky = |channel: usize| {
        let [black_a, black_b] = [a, b].map(|p| saw_nothing(p, channel));
        let is_between = kin == Kin::OtherMethod;
        [is_between && black_a && !black_b, is_between && black_b && !black_a]
    };
    let level = |i: usize| (0..CHANNELS).flat_map(|c| channel([a, b], i, c, lucky(c))).collect();
    (a.first.max(b.first)..a.levels.len().min(b.levels.len())).map(level).collect()
}

/// Whether a channel is black without any error.
fn saw_nothing(picture: &Pyramid, channel: usize) -> bool {
    let estimate = picture.image_mean(channel);
    estimate.value <= 0.0 && estimate.standard_error <= 0.0
}

/// Compares all tiles of one level in one channel. An `unlucky` side may have missed any amount of light.
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
    /// Relative to the cube of the brightness: of the neighbourhood or of the whole picture.
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
