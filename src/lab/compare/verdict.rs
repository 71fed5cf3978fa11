//! Tests whether two images have the same mean. [`same_mean`](crate::lab::same_mean) tests every channel of the
//! whole image and of its tiles. The family-wise error rate is the stated level.
//!
//! **Error estimates.** A rendered image carries a record of its tiles. The record holds errors for the units that the
//! method renders independently. Without a record, or if the pixels were changed after rendering, the per-pixel
//! standard errors are used, provided that the method's pixels are independent. Other images are not tested.
//!
//! **Limits.** Images with the same seed share random numbers. They are not independent and are not tested. A test that
//! finds no difference does not prove equality: the confidence interval of the mean difference bounds a global one. For
//! methods with dependent pixels the power depends on the number of replicates. At the usual level, four replicates
//! detect differences of about nine standard errors. Sixteen, the default of methods with chains, detect five.

use super::ImagePair;
use super::side::Side;
use crate::film::pyramid::{CHANNELS, LEAST_REPLICATES, PixelErrors, Pyramid, decode};
use crate::film::{Crop, Independent};
use crate::lab::same_mean::{Finding, Tested, TestedPicture, test_pair};
use crate::stats::{Estimate, welch_test};
use serde::Serialize;

const NAMES: [&str; CHANNELS] = ["R", "G", "B"];
/// Maximum number of rejections listed.
const MOST_TOLD: usize = 10;

/// Outcome of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum CompareOutcome {
    /// R, G and B are the same bit for bit.
    Identical,
    /// The images could have the same mean.
    NoDifference,
    /// The means differ.
    Differ,
    /// The images cannot be tested.
    Untested,
}

/// Verdict on the equality of two images' means.
#[derive(Debug, Clone, Serialize)]
pub struct Verdict {
    /// The outcome.
    pub outcome: CompareOutcome,
    /// Why the images could not be tested.
    pub reason: Option<String>,
    /// Family-wise level: the probability that images of the same mean are reported as different.
    pub level: f64,
    /// Number of tests.
    pub tests: usize,
    /// Side of the smallest tiles in pixels.
    pub tile: usize,
    /// Number of pixels left out since a value or an error is not finite.
    pub pixels_left_out: usize,
    /// The smallest p-value, corrected for the number of tests.
    pub smallest_p: Option<f64>,
    /// The rejecting tests, the most significant first, at most ten of them.
    pub rejections: Vec<Rejection>,
    /// Number of rejecting tests.
    pub rejected: usize,
    /// Mean differences of the whole image, by channel.
    pub means: Vec<MeanDifference>,
}

/// A test that found a difference.
#[derive(Debug, Clone, Serialize)]
pub struct Rejection {
    /// The channel.
    pub channel: &'static str,
    /// The tile's first pixel in the full image; `None` for the image mean.
    pub tile: Option<[u32; 2]>,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Mean of the image − mean of the reference.
    pub difference: f64,
    /// Standard error of the difference.
    pub standard_error: f64,
    /// The corrected p-value.
    pub p: f64,
}

/// Difference of a channel's means.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct MeanDifference {
    /// The channel.
    pub channel: &'static str,
    /// Mean of the image − mean of the reference.
    pub difference: f64,
    /// 95 % confidence interval of the difference.
    pub interval: [f64; 2],
    /// Mean of the reference.
    pub reference: f64,
}

impl Verdict {
    pub(super) fn of(pair: &ImagePair, level: f64) -> Verdict {
        let same = |(a, b): (&f32, &f32)| a.to_bits() == b.to_bits();
        if pair.image.colors.iter().zip(&pair.reference.colors).all(same) {
            return Verdict::without_tests(CompareOutcome::Identical, None, level);
        }
        match Evidence::of(pair) {
            Ok(evidence) => evidence.judge(level),
            Err(reason) => Verdict::without_tests(CompareOutcome::Untested, Some(reason), level),
        }
    }

    fn without_tests(outcome: CompareOutcome, reason: Option<String>, level: f64) -> Verdict {
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

    /// Returns the verdict as a sentence.
    pub fn sentence(&self) -> String {
        let Verdict { level, tests, tile, rejected, .. } = self;
        let smallest = self.smallest_p.unwrap_or(1.0);
        match self.outcome {
            CompareOutcome::Identical => "the pixels are identical".into(),
            CompareOutcome::Untested => format!("not tested: {}", self.reason.as_deref().unwrap_or_default()),
            CompareOutcome::NoDifference => format!(
                "no difference of the means found at level {level} in {tests} tests (image and tiles from \
                 {tile}x{tile} up by channel), smallest corrected p {smallest:.2e}"
            ),
            CompareOutcome::Differ => format!(
                "the means differ at level {level} in {rejected} of {tests} tests (image and tiles from {tile}x{tile} \
                 up by channel), smallest corrected p {smallest:.2e}"
            ),
        }
    }
}

/// Data of the tests.
struct Evidence<'a> {
    pair: &'a ImagePair,
    pyramids: [Pyramid; 2],
    left_out: usize,
}

impl<'a> Evidence<'a> {
    /// Collects the data, or tells why there is none.
    fn of(pair: &'a ImagePair) -> Result<Self, String> {
        let sides = [&pair.image, &pair.reference];
        if let [Some(a), Some(b)] = sides.map(|side| side.origin.seed) {
            if a == b {
                return Err(format!(
                    "both have seed {a}, so that their errors are not independent; render one with another --seed"
                ));
            }
        }
        let left_out =
            (0..pair.image.crop.pixels()).filter(|&pixel| !sides.iter().all(|side| is_finite(side, pixel))).count();
        if left_out == pair.image.crop.pixels() {
            return Err("no pixel is finite in both".into());
        }
        let taken = |pixel: usize| sides.iter().all(|side| is_finite(side, pixel));
        let [a, b] = sides.map(|side| match recorded(side).filter(|_| left_out == 0) {
            Some(pyramid) => Ok(pyramid),
            // `pixel_errors` has checked that there are enough replicates.
            None => pixel_errors(side)?.pyramid(taken).ok_or_else(|| lacks(side, "replicates enough")),
        });
        Ok(Evidence { pair, pyramids: [a?, b?], left_out })
    }

    fn judge(&self, level: f64) -> Verdict {
        let sides = [&self.pair.image, &self.pair.reference];
        let picture =
            |i: usize| TestedPicture { pyramid: &self.pyramids[i], method: &sides[i].origin.method, doubt: None };
        let tested: Tested = test_pair([&picture(0), &picture(1)]);
        let found = tested.findings(level);
        let outcome = if found.is_empty() { CompareOutcome::NoDifference } else { CompareOutcome::Differ };
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

/// Decodes the tile record of an image, if its pixels are as rendered.
fn recorded(side: &Side) -> Option<Pyramid> {
    let is_as_rendered = side.origin.hash_matches == Some(true);
    decode(side.record.as_deref().filter(|_| is_as_rendered)?, side.crop)
}

/// Returns the errors of an image's pixels, if tile errors follow from them.
fn pixel_errors(side: &Side) -> Result<PixelErrors<'_>, String> {
    let errors = side.errors.as_deref().ok_or_else(|| lacks(side, "standard errors (layers stderr.R, G, B)"))?;
    let known = side.origin.replicates.ok_or_else(|| lacks(side, "number of replicates in its header"))?;
    let replicates =
        usize::try_from(known).ok().filter(|r| (LEAST_REPLICATES..=MOST_REPLICATES).contains(r)).ok_or_else(|| {
            format!(
                "{} has {known} replicates, and a test takes three or more: render it with --replicates 4",
                side.origin.path
            )
        })?;
    let method = side.origin.method.as_deref().unwrap_or_default();
    match side.origin.independent() {
        Some(Independent::Pixels) => {
            let spp = side.origin.spp.unwrap_or(1);
            Ok(PixelErrors { crop: side.crop, means: &side.colors, errors, replicates, spp })
        }
        None => {
            Err(lacks(side, "known method in its header, so that it is unknown which of its pixels are independent"))
        }
        Some(_) if side.origin.hash_matches == Some(false) => Err(format!(
            "the pixels of {} were changed after rendering, and those of {method} are not independent",
            side.origin.path
        )),
        Some(_) => Err(format!(
            "{} carries no sound record of its tiles, and the pixels of {method} are not independent: render it with \
             this version",
            side.origin.path
        )),
    }
}

/// More than any render has. The header is untrusted.
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
