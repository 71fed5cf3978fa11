//! Could two images have the same mean? [`same_mean`](crate::render::same_mean) tests every channel of the whole image and of its
//! tiles, so that all together reject a true hypothesis with the stated probability.
//!
//! **What it stands on.** An image carries a record of its tiles that is made of what its method's pixels share. Where it has none, or
//! its pixels were changed after rendering, the standard errors of pixels serve if the method's pixels are independent; other images
//! are not tested.
//!
//! **What it does not see.** Images of the same seed share random numbers and are not independent: they are not tested. No
//! difference found is no proof of equality: the interval of the mean's difference says how large a global one could be. Four
//! replicates of a method whose pixels are not independent tell means apart that are some nine standard errors off at the usual level;
//! sixteen, the default of methods with chains, do at five.

use super::Pair;
use super::side::Side;
use crate::film::{Crop, Independent};
use crate::render::same_mean::{CHANNELS, Finding, LEAST_REPLICATES, Picture, PixelErrors, Pyramid, Tested, decode, test_pair};
use crate::stats::{Estimate, welch_test};
use serde::Serialize;

const NAMES: [&str; CHANNELS] = ["R", "G", "B"];
/// Rejections that are told.
const MOST_TOLD: usize = 10;

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
    /// Side of the smallest tiles in pixels.
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
    /// Its width and height.
    pub size: [u32; 2],
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
                "no difference of the means found at level {level} in {tests} tests (image and tiles from {tile}x{tile} up by channel), smallest corrected p {smallest:.2e}"
            ),
            Outcome::Differ => format!(
                "the means differ at level {level} in {rejected} of {tests} tests (image and tiles from {tile}x{tile} up by channel), smallest corrected p {smallest:.2e}"
            ),
        }
    }
}

/// What the tests are made of.
struct Evidence<'a> {
    pair: &'a Pair,
    pyramids: [Pyramid; 2],
    left_out: usize,
}

impl<'a> Evidence<'a> {
    /// All that is needed, or why it is not there.
    fn of(pair: &'a Pair) -> Result<Self, String> {
        let sides = [&pair.image, &pair.reference];
        if let [Some(a), Some(b)] = sides.map(|side| side.origin.seed) {
            if a == b {
                return Err(format!(
                    "both have seed {a}, so that their errors are not independent; render one with another --seed"
                ));
            }
        }
        let left_out = (0..pair.image.crop.pixels()).filter(|&pixel| !sides.iter().all(|side| is_finite(side, pixel))).count();
        if left_out == pair.image.crop.pixels() {
            return Err("no pixel is finite in both".into());
        }
        let taken = |pixel: usize| sides.iter().all(|side| is_finite(side, pixel));
        let [a, b] = sides.map(|side| match recorded(side).filter(|_| left_out == 0) {
            Some(pyramid) => Ok(pyramid),
            // It has the replicates that it takes.
            None => pixel_errors(side)?.pyramid(taken).ok_or_else(|| lacks(side, "replicates enough")),
        });
        Ok(Evidence { pair, pyramids: [a?, b?], left_out })
    }

    fn judge(&self, level: f64) -> Verdict {
        let sides = [&self.pair.image, &self.pair.reference];
        let picture = |i: usize| Picture { pyramid: &self.pyramids[i], method: &sides[i].origin.method, doubt: None };
        let tested: Tested = test_pair([&picture(0), &picture(1)]);
        let found = tested.findings(level);
        let outcome = if found.is_empty() { Outcome::NoDifference } else { Outcome::Differ };
        Verdict {
            tests: tested.count(),
            tile: tested.smallest_side() as usize,
            pixels_left_out: self.left_out,
            smallest_p: tested.smallest_p(),
            rejected: found.len(),
            rejections: found.iter().take(MOST_TOLD).map(Rejection::of).collect(),
            means: (0..CHANNELS).map(|channel| self.mean(channel)).collect(),
            ..Verdict::without_tests(outcome, None, level)
        }
    }

    fn mean(&self, channel: usize) -> MeanDifference {
        let [a, b] = [0, 1].map(|i: usize| self.pyramids[i].image_mean(channel));
        let (value, standard_error) = (a.value - b.value, a.standard_error.hypot(b.standard_error));
        let interval = Estimate { value, standard_error, dof: welch_test(&a, &b).dof }.interval95();
        MeanDifference { channel: NAMES[channel], difference: value, interval, reference: b.value }
    }
}

/// The tiles that an image carries, if its pixels are those that it was rendered with.
fn recorded(side: &Side) -> Option<Pyramid> {
    let is_as_rendered = side.origin.hash_matches == Some(true);
    decode(side.record.as_deref().filter(|_| is_as_rendered)?, side.crop)
}

/// The errors of the pixels of an image, if they say how far tiles may be off.
fn pixel_errors(side: &Side) -> Result<PixelErrors<'_>, String> {
    let errors = side.errors.as_deref().ok_or_else(|| lacks(side, "standard errors (layers stderr.R, G, B)"))?;
    let known = side.origin.replicates.ok_or_else(|| lacks(side, "number of replicates in its header"))?;
    let replicates =
        usize::try_from(known).ok().filter(|r| (LEAST_REPLICATES..=MOST_REPLICATES).contains(r)).ok_or_else(|| {
            format!("{} has {known} replicates, and a test takes three or more: render it with --replicates 4", side.origin.path)
        })?;
    let method = side.origin.method.as_deref().unwrap_or_default();
    match side.origin.independent() {
        Some(Independent::Pixels) => {
            let spp = side.origin.spp.unwrap_or(1);
            Ok(PixelErrors { crop: side.crop, means: &side.colors, errors, replicates, spp })
        }
        None => Err(lacks(side, "known method in its header, so that nothing says what its pixels share")),
        Some(_) if side.origin.hash_matches == Some(false) => Err(format!(
            "the pixels of {} were changed after rendering, and those of {method} are not independent",
            side.origin.path
        )),
        Some(_) => Err(format!(
            "{} carries no sound record of its tiles, and the pixels of {method} are not independent: render it with this version",
            side.origin.path
        )),
    }
}

/// More than any render has: a header may say anything.
const MOST_REPLICATES: usize = 256;

/// Whether a pixel's colour and its errors are finite.
fn is_finite(side: &Side, pixel: usize) -> bool {
    let at = CHANNELS * pixel..CHANNELS * (pixel + 1);
    let errors = side.errors.as_deref().map_or(&[][..], |errors| &errors[at.clone()]);
    side.colors[at].iter().chain(errors).all(|v| v.is_finite())
}

fn lacks(side: &Side, what: &str) -> String {
    format!("{} has no {what}", side.origin.path)
}

impl Rejection {
    fn of(found: &Finding) -> Rejection {
        let Crop { x0, y0, x1, y1 } = found.area;
        let standard_error = found.a.standard_error.hypot(found.b.standard_error);
        Rejection {
            channel: NAMES[found.channel],
            tile: (!found.is_image).then_some([x0, y0]),
            size: [x1 - x0, y1 - y0],
            difference: found.a.value - found.b.value,
            standard_error,
            p: found.p,
        }
    }
}

#[cfg(test)]
#[path = "verdict_tests.rs"]
mod tests;
