//! Tests whether pictures have the same mean. One implementation serves `compare` (two files) and `verify` (all
//! candidates of a run).
//!
//! A [`Pyramid`] holds the means of a picture's tiles, from 8×8 pixels to the whole image, with their errors. The
//! errors are estimated between the units that the method renders independently ([`crate::film::Independent`]): pixels,
//! or only replicates if splats or chains correlate pixels. A pyramid comes from a film, from the record that an image
//! carries (`record`), or from the pixel errors of an image without a record, if its pixels are independent. [`judge`]
//! tests all tiles of all pairs at one family-wise level.
//!
//! The tests are Welch's, corrected for skewness [Welch47; Hall92; Zhou05], and together corrected by Holm's method
//! [Holm79]. Limits: three or more replicates are required. An error common to all pictures is not detected. Neither is
//! a difference below the noise.

mod judge;
mod measured;
mod record;
mod sources;
mod sum;
mod tiles;

pub(in crate::render) use judge::{Finding, Tested, test_pair};
pub use judge::{Judgement, Outcome, PairJudgement, TestedPicture, Worst, judge};
pub(in crate::render) use record::{RECORD, decode, encode};
pub use sources::Doubt;
pub(in crate::render) use sources::PixelErrors;
pub(in crate::render) use tiles::CHANNELS;
pub use tiles::Pyramid;

/// Minimum number of replicates of a test: fewer do not determine skewness.
pub(in crate::render) const LEAST_REPLICATES: usize = 3;
