//! The verdict. Half of the family's level goes to the image means, which show the smallest errors, and half to the tiles, which
//! show where; within each half all pairs, tiles and channels are corrected together by Holm's method [Holm79]. So the probability
//! that anything is said to differ where all candidates are right is at most the level.

use super::measured::{Comparison, Kin, compare};
use super::tiles::Pyramid;
use crate::film::Crop;
use crate::stats::{holm, student_quantile, welch_test};
use serde::Serialize;

/// What all pairs say.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judgement {
    /// Probability at most of any difference being found where there is none.
    pub level: f64,
    /// How many means were compared.
    pub tests: usize,
    /// Every pair.
    pub pairs: Vec<Pair>,
}

/// Two candidates compared.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Pair {
    /// The first, by its place in the list of candidates.
    pub a: usize,
    /// The second.
    pub b: usize,
    /// Whether anything differs.
    pub differs: bool,
    /// The channel of the image's mean that differs most.
    pub image: Worst,
    /// The tile and channel that differ most; `None` for an image of one tile.
    pub tile: Option<Worst>,
    /// How many tiles, of all sizes, differ in some channel.
    pub tiles_different: usize,
    /// How many tiles there are, of all sizes.
    pub tiles: usize,
    /// How many of them have met too few large contributions to tell a difference in any channel from bad luck.
    pub tiles_undecided: usize,
    /// The smallest relative difference that would have been found with a probability of 90 % in the image's mean, in its best
    /// channel; `None` if none would.
    pub detectable: Option<f64>,
    /// The same for the median tile of the size given in `detectable_side`.
    pub detectable_tile: Option<f64>,
    /// Side in pixels of the smallest tiles of which half or more can tell twice as bright.
    pub detectable_side: Option<u32>,
}

/// The most different mean of some.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Worst {
    /// Which pixels.
    pub area: Crop,
    /// Which channel: 0 red, 1 green, 2 blue.
    pub channel: usize,
    /// The first mean.
    pub a: f64,
    /// The second mean.
    pub b: f64,
    /// (a − b) over the mean of both.
    pub relative: f64,
    /// Where the relative difference lies, at a confidence of 1 − level for all means together.
    pub interval: [f64; 2],
    /// Welch's t, corrected for skewness.
    pub t: f64,
    /// Its p-value, corrected for all tests.
    pub p_value: f64,
}

/// All comparisons of a pair and what they gave.
struct Tested {
    levels: Vec<Vec<Comparison>>,
    t: Vec<f64>,
    p: Vec<f64>,
}

/// Compares all pairs. `methods` says of each picture which method made it; `level` is the family's.
///
/// # Panics
/// Unless 0 < level < 1, there are two pictures or more and as many methods.
pub fn judge<M: PartialEq>(pictures: &[Pyramid], methods: &[M], level: f64) -> Judgement {
    let n = pictures.len();
    assert!(n >= 2 && methods.len() == n && level > 0.0 && level < 1.0, "{n} pictures at level {level}");
    let numbers: Vec<[usize; 2]> = (0..n).flat_map(|a| (a + 1..n).map(move |b| [a, b])).collect();
    let kin = |[a, b]: [usize; 2]| if methods[a] == methods[b] { Kin::SameMethod } else { Kin::OtherMethod };
    let mut pairs: Vec<Tested> =
        numbers.iter().map(|&[a, b]| Tested::new(compare(&pictures[a], &pictures[b], kin([a, b])))).collect();
    let image_tests = correct(&mut pairs, |tested| tested.tile_tests()..tested.p.len());
    let tile_tests = correct(&mut pairs, |tested| 0..tested.tile_tests());
    let each = [level / 2.0 / tile_tests.max(1) as f64, level / 2.0 / image_tests as f64];
    let pairs = numbers.iter().zip(&pairs).map(|(&[a, b], tested)| tested.pair(a, b, level, each)).collect();
    Judgement { level, tests: image_tests + tile_tests, pairs }
}

/// Corrects the p-values in a range of every pair as one half of the family, and says how many they are.
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
    fn new(levels: Vec<Vec<Comparison>>) -> Tested {
        let (t, p) = levels.iter().flatten().map(|c| c.test().into()).unzip();
        Tested { levels, t, p }
    }

    /// How many tests come before those of the whole image.
    fn tile_tests(&self) -> usize {
        self.p.len() - self.levels.last().map_or(0, Vec::len)
    }

    fn pair(&self, a: usize, b: usize, level: f64, each: [f64; 2]) -> Pair {
        let split = self.tile_tests();
        let all: Vec<&Comparison> = self.levels.iter().flatten().collect();
        let image = all[split..].iter().map(|c| c.detectable(each[1])).fold(f64::INFINITY, f64::min);
        let different = areas((0..split).filter(|&i| self.p[i] < level).map(|i| all[i].area));
        let decided = areas(all[..split].iter().filter(|c| c.detectable(each[0]).is_finite()).map(|c| c.area));
        let tiles = areas(all[..split].iter().map(|c| c.area));
        let smallest = self.smallest_decided(each[0]);
        Pair {
            a,
            b,
            differs: self.p.iter().any(|&p| p < level),
            image: self.worst(split..all.len(), &all, each[1]).unwrap_or_else(|| worst_of(all[split], 0.0, 1.0, each[1])),
            tile: self.worst(0..split, &all, each[0]),
            tiles_different: different,
            tiles,
            tiles_undecided: tiles - decided,
            detectable: Some(image).filter(|d| d.is_finite()),
            detectable_tile: smallest.map(|(median, _)| median),
            detectable_side: smallest.map(|(_, side)| side),
        }
    }

    /// The median detectable difference of the smallest tiles where it is no more than the mean itself, and their side.
    fn smallest_decided(&self, each: f64) -> Option<(f64, u32)> {
        let of = |(i, level): (usize, &Vec<Comparison>)| {
            let mut found: Vec<f64> = level.iter().filter(|c| c.mean() > 0.0).map(|c| c.detectable(each)).collect();
            found.sort_by(f64::total_cmp);
            let median = *found.get(found.len() / 2)?;
            (median <= 1.0).then_some((median, super::tiles::SIDE << i))
        };
        self.levels[..self.levels.len() - 1].iter().enumerate().find_map(of)
    }

    /// The test with the smallest p-value, and among equals the largest t.
    fn worst(&self, range: std::ops::Range<usize>, all: &[&Comparison], each: f64) -> Option<Worst> {
        let worse = |&i: &usize, &j: &usize| self.p[j].total_cmp(&self.p[i]).then(self.t[i].abs().total_cmp(&self.t[j].abs()));
        let worst = range.max_by(worse)?;
        Some(worst_of(all[worst], self.t[worst], self.p[worst], each))
    }
}

/// How many different areas there are.
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
