//! Compares two images of one picture: error metrics, difference maps, the provenance of both, and a test for equal
//! means. The second image is the reference. This is the logic behind `etendue compare`.
//!
//! Only R, G and B are compared, as stored. Alpha and other layers are ignored.

pub mod maps;
mod metrics;
mod side;
mod verdict;

pub use metrics::Metrics;
pub use side::Origin;
pub use verdict::{CompareOutcome, MeanDifference, Rejection, Verdict};

use crate::error::{Error, Kind, Result};
use crate::film::Crop;
use crate::lab::image::flip::{self, HdrFlip};
use serde::Serialize;
use side::Side;
use std::path::Path;
use std::sync::OnceLock;

/// Two images of the same size and crop, in memory.
#[derive(Debug)]
pub struct ImagePair {
    image: Side,
    reference: Side,
    /// Computed on first use.
    flip: OnceLock<HdrFlip>,
}

/// Result of a comparison.
#[derive(Debug, Clone, Serialize)]
pub struct Comparison {
    /// Provenance of the image.
    pub image: Origin,
    /// Provenance of the reference.
    pub reference: Origin,
    /// Width and height of the compared region, in pixels.
    pub size: [u32; 2],
    /// Error metrics.
    pub metrics: Metrics,
    /// Verdict on the equality of the means.
    pub verdict: Verdict,
}

impl ImagePair {
    /// Reads both images.
    ///
    /// # Errors
    /// A file cannot be read; [`Kind::Usage`] if it lacks R, G or B, or if sizes or crops differ.
    pub fn read(image: &Path, reference: &Path) -> Result<ImagePair> {
        let (image, reference) = (Side::read(image)?, Side::read(reference)?);
        let name = |side: &Side| side.origin.path.clone();
        if image.size != reference.size || image.crop != reference.crop {
            let (a, b) = (describe(&image), describe(&reference));
            return Err(Error::usage(format!(
                "{} is {a}, {} is {b}: only like can be compared",
                name(&image),
                name(&reference)
            )));
        }
        Ok(ImagePair::of(image, reference))
    }

    fn of(image: Side, reference: Side) -> ImagePair {
        ImagePair { image, reference, flip: OnceLock::new() }
    }

    /// Returns HDR ꟻLIP at the standard viewing distance.
    fn hdr_flip(&self) -> &HdrFlip {
        let make = || flip::hdr(&self.image.colors, &self.reference.colors, self.extent(), flip::PIXELS_PER_DEGREE);
        self.flip.get_or_init(make)
    }

    /// Compares at a family-wise `level`. relMSE uses the `epsilon` given, or (0.1 × the reference's mean)².
    pub fn compare(&self, level: f64, epsilon: Option<f64>) -> Comparison {
        let [width, height] = self.extent();
        Comparison {
            image: self.image.origin.clone(),
            reference: self.reference.origin.clone(),
            size: [width as u32, height as u32],
            metrics: Metrics::of(self, epsilon),
            verdict: Verdict::of(self, level),
        }
    }

    /// Width and height of the rendered region, in pixels.
    fn extent(&self) -> [usize; 2] {
        let Crop { x0, y0, x1, y1 } = self.image.crop;
        [(x1 - x0) as usize, (y1 - y0) as usize]
    }
}

impl Comparison {
    /// Fails with an exit code of its own if the images differ.
    ///
    /// # Errors
    /// [`Kind::Differ`] if they do.
    pub fn require_agreement(&self) -> Result<()> {
        if self.verdict.outcome != CompareOutcome::Differ {
            return Ok(());
        }
        let (image, reference) = (&self.image.path, &self.reference.path);
        Err(Error::new(Kind::Differ, format!("{image} and {reference} differ: {}", self.verdict.sentence())))
    }
}

fn describe(side: &Side) -> String {
    let ([width, height], Crop { x0, y0, x1, y1 }) = (side.size, side.crop);
    let is_whole = side.crop == Crop { x0: 0, y0: 0, x1: width, y1: height };
    if is_whole { format!("{width}x{height}") } else { format!("{width}x{height} cropped to {x0},{y0},{x1},{y1}") }
}
