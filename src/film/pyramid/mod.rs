//! Means of a picture's tiles, from 8×8 pixels to the whole image, with their errors: the statistics of the test of
//! equal means.
//!
//! The errors are estimated between the units that the method renders independently ([`super::Independent`]): pixels,
//! or only replicates if splats or chains correlate pixels. A pyramid comes from a film, from the record that an image
//! carries (`record`), or from the pixel errors of an image without a record, if its pixels are independent.

mod record;
mod sources;
mod sum;
mod tiles;

pub use record::{RECORD, decode, encode};
pub use sources::PixelErrors;
#[cfg(all(test, feature = "cli"))]
pub(crate) use sum::Replicates;
pub use tiles::CHANNELS;
pub use tiles::Pyramid;

/// Minimum number of replicates: fewer do not determine skewness.
pub const LEAST_REPLICATES: usize = 3;
