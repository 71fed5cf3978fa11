//! Two images of one picture compared: figures and maps of how far they are apart, where both come from, and whether they
//! could have the same mean. The second image is the reference. Logic behind `etendue compare`.
//!
//! Only R, G and B are compared, as they are: alpha and other layers are not looked at.

pub mod maps;
mod metrics;
mod side;
mod verdict;

pub use metrics::Metrics;
pub use side::Origin;
pub use verdict::{MeanDifference, Outcome, Rejection, Verdict};

use crate::error::{Error, Kind, Result};
use crate::film::Crop;
use crate::stats::image::flip::{self, HdrFlip};
use serde::Serialize;
use side::Side;
use std::path::Path;
use std::sync::OnceLock;

/// Two images of the same size and crop, in memory.
#[derive(Debug)]
pub struct Pair {
    image: Side,
    reference: Side,
    /// Made when first asked for.
    flip: OnceLock<HdrFlip>,
}

/// What was found.
#[derive(Debug, Clone, Serialize)]
pub struct Comparison {
    /// Where the image comes from.
    pub image: Origin,
    /// Where the reference comes from.
    pub reference: Origin,
    /// Width and height of what was compared.
    pub size: [u32; 2],
    /// Figures.
    pub metrics: Metrics,
    /// Whether the means could be the same.
    pub verdict: Verdict,
}

impl Pair {
    /// Reads both.
    ///
    /// # Errors
    /// A file that cannot be read; [`Kind::Usage`] for one without R, G and B, or if sizes or crops differ.
    pub fn read(image: &Path, reference: &Path) -> Result<Pair> {
        let (image, reference) = (Side::read(image)?, Side::read(reference)?);
        let name = |side: &Side| side.origin.path.clone();
        if image.size != reference.size || image.crop != reference.crop {
            let (a, b) = (describe(&image), describe(&reference));
            return Err(Error::usage(format!("{} is {a}, {} is {b}: only like can be compared", name(&image), name(&reference))));
        }
        Ok(Pair::of(image, reference))
    }

    fn of(image: Side, reference: Side) -> Pair {
        Pair { image, reference, flip: OnceLock::new() }
    }

    /// HDR ꟻLIP at the usual distance.
    fn hdr_flip(&self) -> &HdrFlip {
        let make = || flip::hdr(&self.image.colors, &self.reference.colors, self.extent(), flip::PIXELS_PER_DEGREE);
        self.flip.get_or_init(make)
    }

    /// Compares at a family-wise `level`; relMSE has the `epsilon` given, or (0.1 × the reference's mean)².
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

    /// Width and height of the pixels that are there.
    fn extent(&self) -> [usize; 2] {
        let Crop { x0, y0, x1, y1 } = self.image.crop;
        [(x1 - x0) as usize, (y1 - y0) as usize]
    }
}

impl Comparison {
    /// An error with an exit code of its own if the images differ.
    ///
    /// # Errors
    /// [`Kind::Differ`] then.
    pub fn require_agreement(&self) -> Result<()> {
        if self.verdict.outcome != Outcome::Differ {
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
