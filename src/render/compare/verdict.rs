//! Could two images have the same mean? Welch's test of every channel of the whole image and of each tile, Holm-corrected
//! so that all together reject a true hypothesis with the stated probability [Welch47; Holm79].
//!
//! **What it stands on.** Both images carry standard errors from R replicates. A tile's mean is that of n pixels, which have
//! samples of their own and are independent (all methods so far; not those whose pixels share chains or photons), so its variance
//! is Σv/n². Each v is estimated with R − 1 degrees of freedom, their sum with (R − 1)(Σv)²/Σv² of them (Satterthwaite): a tile
//! whose error is that of one firefly has R − 1, and its t of about 1 convicts nobody. Tiles are 8 pixels wide, or so many more
//! that each has [`LEAST_SAMPLES`] samples for the central limit to work on.
//!
//! **What it does not see.** Images of the same seed share random numbers and are not independent: they are not tested. No
//! difference found is no proof of equality: the interval of the mean's difference says how large a global one could be.
//! Where a tile has few lit samples its mean is skewed, and the level is only approximate between images of very different sample
//! counts; images of like counts are skewed alike and do no harm.

use super::Pair;
use super::side::Side;
use crate::stats::{Estimate, TestResult, holm, welch_test};
use serde::Serialize;

/// The smallest tile.
const SMALLEST_TILE: usize = 8;
/// Tiles grow until each has so many samples.
const LEAST_SAMPLES: u64 = 4096;
/// Relative differences that rounding can make: 16 half-ulps of f32, for values that were computed in another order.
const ROUNDING: f64 = 16.0 / (1 << 24) as f64;
const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// What a comparison came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// R, G and B are the same bit for bit.
    Identical,
    /// The images could have the same mean.
    NoDifference,
    /// They have not.
    Differ,
    /// There is nothing to test with.
    Untested,
}

/// Whether two images could have the same mean.
#[derive(Debug, Clone, Serialize)]
pub struct Verdict {
    /// The answer.
    pub outcome: Outcome,
    /// Why there was nothing to test with.
    pub reason: Option<String>,
    /// The probability that images of the same mean are said to differ.
    pub level: f64,
    /// How many tests were made.
    pub tests: usize,
    /// Side of the tiles in pixels.
    pub tile: usize,
    /// Pixels left out because a value or an error is not finite.
    pub pixels_left_out: usize,
    /// The smallest of the p-values, corrected for their number.
    pub smallest_p: Option<f64>,
    /// The tests that reject, the most significant first, at most ten of them.
    pub rejections: Vec<Rejection>,
    /// How many rejected.
    pub rejected: usize,
    /// Differences of the whole images' channels.
    pub means: Vec<MeanDifference>,
}

/// A test that found a difference.
#[derive(Debug, Clone, Serialize)]
pub struct Rejection {
    /// The channel.
    pub channel: &'static str,
    /// The tile's first pixel in the full image; `None` for the image mean.
    pub tile: Option<[u32; 2]>,
    /// Mean of the image less mean of the reference.
    pub difference: f64,
    /// Standard error of that.
    pub standard_error: f64,
    /// The corrected p-value.
    pub p: f64,
}

/// How far apart the means of a channel are.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct MeanDifference {
    /// The channel.
    pub channel: &'static str,
    /// Mean of the image less mean of the reference.
    pub difference: f64,
    /// The 95 % interval of that.
    pub interval: [f64; 2],
    /// Mean of the reference.
    pub reference: f64,
}

impl Verdict {
    pub(super) fn of(pair: &Pair, level: f64) -> Verdict {
        let same = |(a, b): (&f32, &f32)| a.to_bits() == b.to_bits();
        if pair.image.colors.iter().zip(&pair.reference.colors).all(same) {
            return Verdict::without_tests(Outcome::Identical, None, level);
        }
        match Evidence::of(pair) {
            Ok(evidence) => evidence.judge(level),
            Err(reason) => Verdict::without_tests(Outcome::Untested, Some(reason), level),
        }
    }

    fn without_tests(outcome: Outcome, reason: Option<String>, level: f64) -> Verdict {
        Verdict {
            outcome,
            reason,
            level,
            tests: 0,
            tile: 0,
            pixels_left_out: 0,
            smallest_p: None,
            rejections: Vec::new(),
            rejected: 0,
            means: Vec::new(),
        }
    }

    /// The verdict in words.
    pub fn sentence(&self) -> String {
        let Verdict { level, tests, tile, rejected, .. } = self;
        let smallest = self.smallest_p.unwrap_or(1.0);
        match self.outcome {
            Outcome::Identical => "the pixels are identical".into(),
            Outcome::Untested => format!("not tested: {}", self.reason.as_deref().unwrap_or_default()),
            Outcome::NoDifference => format!(
                "no difference of the means found at level {level} in {tests} tests (image and {tile}x{tile} tiles by channel), smallest corrected p {smallest:.2e}"
            ),
            Outcome::Differ => format!(
                "the means differ at level {level} in {rejected} of {tests} tests (image and {tile}x{tile} tiles by channel), smallest corrected p {smallest:.2e}"
            ),
        }
    }
}

/// What the tests are made of.
struct Evidence<'a> {
    pair: &'a Pair,
    errors: [&'a [f32]; 2],
    replicates: [u64; 2],
    tile: usize,
}

impl<'a> Evidence<'a> {
    /// All that is needed, or why it is not there.
    fn of(pair: &'a Pair) -> Result<Self, String> {
        let sides = [&pair.image, &pair.reference];
        let errors =
            sides.map(|side| side.errors.as_deref().ok_or_else(|| lacks(side, "standard errors (layers stderr.R, G, B)")));
        let replicates = sides.map(|side| {
            let known = side.origin.replicates.filter(|&r| r >= 2);
            known.ok_or_else(|| lacks(side, "a number of replicates in its header"))
        });
        let ([ea, eb], [ra, rb]) = (errors, replicates);
        let (errors, replicates) = ([ea?, eb?], [ra?, rb?]);
        if let (Some(a), Some(b)) = (sides[0].origin.seed, sides[1].origin.seed) {
            if a == b {
                return Err(format!(
                    "both have seed {a}, so that their errors are not independent; render one with another --seed"
                ));
            }
        }
        let spp = sides.map(|side| side.origin.spp.unwrap_or(1));
        Ok(Evidence { pair, errors, replicates, tile: tile(pair.extent(), spp[0].min(spp[1])) })
    }

    fn judge(&self, level: f64) -> Verdict {
        let [width, height] = self.pair.extent();
        let corner = self.pair.image.crop;
        let mut whole = [Sums::default(); 3];
        let mut tested: Vec<Tested> = Vec::new();
        for y in (0..height).step_by(self.tile) {
            for x in (0..width).step_by(self.tile) {
                let sums = self.sums([x, y], [(x + self.tile).min(width), (y + self.tile).min(height)]);
                let place = [corner.x0 + x as u32, corner.y0 + y as u32];
                whole.iter_mut().zip(&sums).for_each(|(all, tile)| all.add(tile));
                tested.extend((0..3).filter_map(|c| self.test(&sums[c], c, Some(place))));
            }
        }
        tested.extend((0..3).filter_map(|c| self.test(&whole[c], c, None)));
        let mut verdict = conclude(&tested, level);
        verdict.tile = self.tile;
        verdict.pixels_left_out = width * height - whole[0].n as usize;
        verdict.means = (0..3).filter_map(|c| self.mean(&whole[c], c)).collect();
        verdict
    }

    /// Sums of each channel over the pixels from `start` to before `end`.
    fn sums(&self, start: [usize; 2], end: [usize; 2]) -> [Sums; 3] {
        let width = self.pair.extent()[0];
        let mut sums = [Sums::default(); 3];
        for pixel in (start[1]..end[1]).flat_map(|y| (start[0]..end[0]).map(move |x| y * width + x)) {
            let at = 3 * pixel..3 * pixel + 3;
            let (a, b) = (&self.pair.image.colors[at.clone()], &self.pair.reference.colors[at.clone()]);
            let [sa, sb] = self.errors.map(|errors| &errors[at.clone()]);
            if [a, b, sa, sb].into_iter().flatten().all(|v| v.is_finite()) {
                (0..3).for_each(|c| sums[c].push([a[c], b[c]].map(f64::from), [sa[c], sb[c]].map(f64::from)));
            }
        }
        sums
    }

    fn test(&self, sums: &Sums, channel: usize, place: Option<[u32; 2]>) -> Option<Tested> {
        let [a, b] = self.estimates(sums)?;
        let rounding = ROUNDING * sums.size / sums.n;
        let difference = a.value - b.value;
        let beyond = difference.signum() * (difference.abs() - rounding).max(0.0);
        let result = welch_test(&Estimate { value: beyond, ..a }, &Estimate { value: 0.0, ..b });
        Some(Tested { channel, place, difference, standard_error: a.standard_error.hypot(b.standard_error), result })
    }

    fn mean(&self, sums: &Sums, channel: usize) -> Option<MeanDifference> {
        let [a, b] = self.estimates(sums)?;
        let dof = welch_test(&a, &b).dof;
        let (value, standard_error) = (a.value - b.value, a.standard_error.hypot(b.standard_error));
        let interval = Estimate { value, standard_error, dof }.interval95();
        Some(MeanDifference { channel: CHANNELS[channel], difference: value, interval, reference: b.value })
    }

    /// The means of both images and their errors; `None` without pixels.
    fn estimates(&self, sums: &Sums) -> Option<[Estimate; 2]> {
        let estimate = |i: usize| {
            let (variance, own) = (sums.variance[i], self.replicates[i] as f64 - 1.0);
            let dof = if sums.squares[i] > 0.0 { own * variance * variance / sums.squares[i] } else { own };
            Estimate { value: sums.mean[i] / sums.n, standard_error: variance.sqrt() / sums.n, dof }
        };
        (sums.n > 0.0).then(|| [estimate(0), estimate(1)])
    }
}

fn lacks(side: &Side, what: &str) -> String {
    format!("{} has no {}", side.origin.path, what.trim_start_matches("a "))
}

/// The side of tiles with enough samples.
fn tile(size: [usize; 2], spp: u64) -> usize {
    let mut side = SMALLEST_TILE;
    while ((side * side) as u64).saturating_mul(spp) < LEAST_SAMPLES && side < size[0].max(size[1]) {
        side *= 2;
    }
    side
}

/// Sums over pixels, of the image and of the reference.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    n: f64,
    mean: [f64; 2],
    /// Of the pixels' variances.
    variance: [f64; 2],
    /// Of their squares.
    squares: [f64; 2],
    /// Of the absolute values of both.
    size: f64,
}

impl Sums {
    fn push(&mut self, mean: [f64; 2], error: [f64; 2]) {
        let variance = error.map(|s| s * s);
        self.add(&Sums { n: 1.0, mean, variance, squares: variance.map(|v| v * v), size: mean[0].abs() + mean[1].abs() });
    }

    fn add(&mut self, other: &Sums) {
        let both = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        self.n += other.n;
        self.mean = both(self.mean, other.mean);
        self.variance = both(self.variance, other.variance);
        self.squares = both(self.squares, other.squares);
        self.size += other.size;
    }
}

struct Tested {
    channel: usize,
    place: Option<[u32; 2]>,
    difference: f64,
    standard_error: f64,
    result: TestResult,
}

fn conclude(tested: &[Tested], level: f64) -> Verdict {
    if tested.is_empty() {
        return Verdict::without_tests(Outcome::Untested, Some("no pixel is finite in both".into()), level);
    }
    let corrected = holm(&tested.iter().map(|t| t.result.p_value).collect::<Vec<_>>());
    let mut rejections: Vec<Rejection> = tested.iter().zip(&corrected).filter(|(_, p)| **p < level).map(Rejection::of).collect();
    rejections.sort_by(|a, b| a.p.total_cmp(&b.p).then(a.tile.is_some().cmp(&b.tile.is_some())));
    let rejected = rejections.len();
    rejections.truncate(10);
    let outcome = if rejected > 0 { Outcome::Differ } else { Outcome::NoDifference };
    let smallest_p = corrected.iter().copied().reduce(f64::min);
    Verdict { tests: tested.len(), smallest_p, rejections, rejected, ..Verdict::without_tests(outcome, None, level) }
}

impl Rejection {
    fn of((test, &p): (&Tested, &f64)) -> Rejection {
        let Tested { channel, place, difference, standard_error, .. } = *test;
        Rejection { channel: CHANNELS[channel], tile: place, difference, standard_error, p }
    }
}

#[cfg(test)]
#[path = "verdict_tests.rs"]
mod tests;
