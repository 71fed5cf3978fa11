//! Verdicts on pairs of pictures. Half of the family-wise level is spent on the image means, which have the smallest
//! errors. The other half is spent on the tiles, which localise a difference. Within each half, all pairs, tiles and
//! channels are corrected together by Holm's method [Holm79]. The probability of any false rejection is therefore at
//! most the level if all candidates are right.
//!
//! This holds if the error estimates hold. A picture with an untrusted error has a heavy tail that it has hardly
//! sampled. It usually underestimates mean and variance together. If it is the darker one of a pair, its mean is
//! allowed the light that it may have missed ([`Doubt`]). A pair that differs only without this allowance is undecided.

use super::Doubt;
use super::measured::{Comparison, Kin, compare};
use crate::film::Crop;
use crate::film::pyramid::Pyramid;
use crate::stats::{Estimate, holm, student_quantile, welch_test};
use serde::Serialize;

/// A picture to be tested.
#[derive(Debug, Clone, Copy)]
pub struct TestedPicture<'a, M> {
    /// Its tile pyramid.
    pub pyramid: &'a Pyramid,
    /// The method that rendered it.
    pub method: M,
    /// The light it may have missed, if its errors are not to be trusted.
    pub doubt: Option<Doubt>,
}

impl<M> TestedPicture<'_, M> {
    /// Bound on the missed light, as a sum over pixels.
    fn unseen(&self) -> f64 {
        self.doubt.map_or(0.0, |doubt| doubt.unseen)
    }
}

/// Outcome of the tests of two pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// No difference was found.
    Agree,
    /// The means differ.
    Differ,
    /// The means differ only if the untrusted error of the darker picture is taken at face value.
    CannotTell,
}

/// Verdict on all pairs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judgement {
    /// Family-wise level: the maximum probability of any false rejection.
    pub level: f64,
    /// Number of tests.
    pub tests: usize,
    /// Verdicts by pair.
    pub pairs: Vec<PairJudgement>,
}

/// Verdict on two candidates.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PairJudgement {
    /// Index of the first candidate.
    pub a: usize,
    /// Index of the second candidate.
    pub b: usize,
    /// Outcome of the tests.
    pub outcome: Outcome,
    /// The channel of the image mean with the largest difference.
    pub image: Worst,
    /// The tile and channel with the largest difference; `None` for an image of one tile.
    pub tile: Option<Worst>,
    /// Number of tiles, of all sizes, that differ in some channel.
    pub tiles_different: usize,
    /// Number of tiles, of all sizes.
    pub tiles: usize,
    /// Number of tiles with too few large contributions to detect a difference in any channel.
    pub tiles_undecided: usize,
    /// Smallest relative difference of the image mean that is detected with a probability of 90 %, in the best channel;
    /// `None` if none would be.
    pub detectable: Option<f64>,
    /// Detectable difference of the median tile of the size given in `detectable_side`.
    pub detectable_tile: Option<f64>,
    /// Side in pixels of the smallest tiles for which at least half detect a difference of 100 %.
    pub detectable_side: Option<u32>,
}

/// The most significant difference of a set of means.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Worst {
    /// The tile or the image.
    pub area: Crop,
    /// Channel: 0 red, 1 green, 2 blue.
    pub channel: usize,
    /// The first mean.
    pub a: f64,
    /// The second mean.
    pub b: f64,
    /// (a − b) over the mean of both.
    pub relative: f64,
    /// Simultaneous confidence interval of the relative difference, at a confidence of 1 − level for all means
    /// together.
    pub interval: [f64; 2],
    /// Welch's t, corrected for skewness.
    pub t: f64,
    /// Its p-value, corrected for all tests.
    pub p_value: f64,
}

/// A significant difference of two means.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Finding {
    pub(crate) area: Crop,
    pub(crate) channel: usize,
    /// The first mean.
    pub(crate) a: Estimate,
    /// The second.
    pub(crate) b: Estimate,
    /// p-value, corrected for all tests.
    pub(crate) p: f64,
    /// Whether it concerns the whole image.
    pub(crate) is_image: bool,
}

/// All comparisons of a pair with their test results.
pub(crate) struct Tested {
    levels: Vec<Vec<Comparison>>,
    /// Side of the tiles of each level, in pixels.
    sides: Vec<u32>,
    t: Vec<f64>,
    p: Vec<f64>,
}

/// Tests all pairs at the family-wise `level`.
///
/// # Panics
/// Unless 0 < level < 1 and there are two pictures or more.
pub fn judge<M: PartialEq + Copy>(pictures: &[TestedPicture<'_, M>], level: f64) -> Judgement {
    let n = pictures.len();
    assert!(n >= 2 && level > 0.0 && level < 1.0, "{n} pictures at level {level}");
    let numbers: Vec<[usize; 2]> = (0..n).flat_map(|a| (a + 1..n).map(move |b| [a, b])).collect();
    let mut pairs: Vec<Tested> = numbers.iter().map(|&[a, b]| Tested::new([&pictures[a], &pictures[b]])).collect();
    correct_all(&mut pairs);
    let found = |tested: &Tested| tested.p.iter().any(|&p| p < level);
    let plain: Vec<bool> = pairs.iter().map(found).collect();
    for (tested, pair) in pairs.iter_mut().zip(&numbers) {
        tested.test(pair.map(|i| pictures[i].unseen()));
    }
    let [tile_tests, image_tests] = correct_all(&mut pairs);
    let each = [level / 2.0 / tile_tests.max(1) as f64, level / 2.0 / image_tests as f64];
    let of = |((&[a, b], tested), &plain): ((&[usize; 2], &Tested), &bool)| {
        let outcome = match [plain, found(tested)] {
            [_, true] => Outcome::Differ,
            [true, false] => Outcome::CannotTell,
            [false, false] => Outcome::Agree,
        };
        tested.pair(a, b, outcome, level, each)
    };
    let pairs = numbers.iter().zip(&pairs).zip(&plain).map(of).collect();
    Judgement { level, tests: image_tests + tile_tests, pairs }
}

/// Tests two pictures, corrected for the number of tests.
pub(crate) fn test_pair<M: PartialEq>(pictures: [&TestedPicture<'_, M>; 2]) -> Tested {
    let mut pair = Tested::new(pictures);
    pair.test(pictures.map(TestedPicture::unseen));
    correct_all(std::slice::from_mut(&mut pair));
    pair
}

/// Corrects the p-values of all pairs. Returns the numbers of tile tests and of image tests.
fn correct_all(pairs: &mut [Tested]) -> [usize; 2] {
    let image_tests = correct(pairs, |tested| tested.tile_tests()..tested.p.len());
    [correct(pairs, |tested| 0..tested.tile_tests()), image_tests]
}

/// Corrects the p-values in a range of every pair as one half of the family. Returns their number.
fn correct(pairs: &mut [Tested], range: impl Fn(&Tested) -> std::ops::Range<usize>) -> usize {
    let all: Vec<f64> = pairs.iter().flat_map(|tested| tested.p[range(tested)].iter().copied()).collect();
    let mut corrected = holm(&all).into_iter();
    for tested in pairs {
        let range = range(tested);
        tested.p[range].iter_mut().zip(&mut corrected).for_each(|(p, corrected)| *p = (2.0 * corrected).min(1.0));
    }
    all.len()
}

impl Tested {
    /// Compares two pictures, and tests them as if their errors could be trusted.
    fn new<M: PartialEq>([a, b]: [&TestedPicture<'_, M>; 2]) -> Tested {
        let kin = if a.method == b.method { Kin::SameMethod } else { Kin::OtherMethod };
        let levels = compare(a.pyramid, b.pyramid, kin);
        let first = a.pyramid.levels.len() - levels.len();
        let sides = (0..levels.len()).map(|i| a.pyramid.side(first + i)).collect();
        let mut tested = Tested { levels, sides, t: Vec::new(), p: Vec::new() };
        tested.test([0.0; 2]);
        tested
    }

    /// Tests the pictures, which may have missed `unseen` light each, as a sum over pixels.
    fn test(&mut self, unseen: [f64; 2]) {
        let tests = self.levels.iter().flatten().map(|c| c.test(unseen));
        (self.t, self.p) = tests.map(|test| (test.statistic, test.p_value)).unzip();
    }

    /// Returns the number of tests.
    pub(crate) fn count(&self) -> usize {
        self.p.len()
    }

    /// Returns the smallest corrected p-value.
    pub(crate) fn smallest_p(&self) -> Option<f64> {
        self.p.iter().copied().reduce(f64::min)
    }

    /// Returns the side in pixels of the smallest tested tiles.
    pub(crate) fn smallest_side(&self) -> u32 {
        self.sides[0]
    }

    /// Returns the means that differ at `level`, the most significant first. Image means come before tiles of equal
    /// significance.
    pub(crate) fn findings(&self, level: f64) -> Vec<Finding> {
        let split = self.tile_tests();
        let finding = |(i, (c, &p)): (usize, (&Comparison, &f64))| {
            (p < level).then_some(Finding { area: c.area, channel: c.channel, a: c.a, b: c.b, p, is_image: i >= split })
        };
        let mut found: Vec<Finding> =
            self.levels.iter().flatten().zip(&self.p).enumerate().filter_map(finding).collect();
        found.sort_by(|a, b| a.p.total_cmp(&b.p).then(b.is_image.cmp(&a.is_image)));
        found
    }

    /// Number of tile tests, which precede those of the whole image.
    fn tile_tests(&self) -> usize {
        self.p.len() - self.levels.last().map_or(0, Vec::len)
    }

    fn pair(&self, a: usize, b: usize, outcome: Outcome, level: f64, each: [f64; 2]) -> PairJudgement {
        let split = self.tile_tests();
        let all: Vec<&Comparison> = self.levels.iter().flatten().collect();
        let image = all[split..].iter().map(|c| c.detectable(each[1])).fold(f64::INFINITY, f64::min);
        let different = areas((0..split).filter(|&i| self.p[i] < level).map(|i| all[i].area));
        let decided = areas(all[..split].iter().filter(|c| c.detectable(each[0]).is_finite()).map(|c| c.area));
        let tiles = areas(all[..split].iter().map(|c| c.area));
        let smallest = self.smallest_decided(each[0]);
        PairJudgement {
            a,
            b,
            outcome,
            image: self
                .worst(split..all.len(), &all, each[1])
                .unwrap_or_else(|| worst_of(all[split], 0.0, 1.0, each[1])),
            tile: self.worst(0..split, &all, each[0]),
            tiles_different: different,
            tiles,
            tiles_undecided: tiles - decided,
            detectable: Some(image).filter(|d| d.is_finite()),
            detectable_tile: smallest.map(|(median, _)| median),
            detectable_side: smallest.map(|(_, side)| side),
        }
    }

    /// Finds the smallest tiles whose median detectable difference is at most 100 % of the mean. Returns this median
    /// and their side.
    fn smallest_decided(&self, each: f64) -> Option<(f64, u32)> {
        let of = |(i, level): (usize, &Vec<Comparison>)| {
            let mut found: Vec<f64> = level.iter().filter(|c| c.mean() > 0.0).map(|c| c.detectable(each)).collect();
            found.sort_by(f64::total_cmp);
            let median = *found.get(found.len() / 2)?;
            (median <= 1.0).then_some((median, self.sides[i]))
        };
        self.levels[..self.levels.len() - 1].iter().enumerate().find_map(of)
    }

    /// Returns the test with the smallest p-value; among equal ones the one with the largest |t|.
    fn worst(&self, range: std::ops::Range<usize>, all: &[&Comparison], each: f64) -> Option<Worst> {
        let worse =
            |&i: &usize, &j: &usize| self.p[j].total_cmp(&self.p[i]).then(self.t[i].abs().total_cmp(&self.t[j].abs()));
        let worst = range.max_by(worse)?;
        Some(worst_of(all[worst], self.t[worst], self.p[worst], each))
    }
}

impl Judgement {
    /// Returns the outcome over all pairs: a difference if any pair differs.
    pub fn outcome(&self) -> Outcome {
        let has = |outcome| self.pairs.iter().any(|pair| pair.outcome == outcome);
        [Outcome::Differ, Outcome::CannotTell].into_iter().find(|&outcome| has(outcome)).unwrap_or(Outcome::Agree)
    }
}

impl PairJudgement {
    /// Whether the means differ.
    pub fn differs(&self) -> bool {
        self.outcome == Outcome::Differ
    }
}

/// Number of distinct areas.
fn areas(found: impl Iterator<Item = Crop>) -> usize {
    found.collect::<std::collections::HashSet<_>>().len()
}

fn worst_of(c: &Comparison, t: f64, p_value: f64, each: f64) -> Worst {
    let standard_error = c.a.standard_error.hypot(c.b.standard_error);
    let half = student_quantile(1.0 - 0.5 * each, welch_test(&c.a, &c.b).dof) * standard_error;
    let (difference, mean) = (c.a.value - c.b.value, c.mean());
    let relative = |d: f64| if mean > 0.0 { d / mean } else { 0.0 };
    let interval = [relative(difference - half), relative(difference + half)];
    let (a, b) = (c.a.value, c.b.value);
    Worst { area: c.area, channel: c.channel, a, b, relative: relative(difference), interval, t, p_value }
}

#[cfg(test)]
#[path = "judge_tests.rs"]
mod tests;
