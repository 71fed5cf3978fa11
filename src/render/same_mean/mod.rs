//! Do pictures have the same mean? One implementation for `compare` (two files) and `verify` (all candidates of a run).
//!
//! A [`Pyramid`] holds the means of a picture's tiles, from 8×8 pixels to the whole image, with their errors. What the errors are
//! made of is what the method says is independent ([`crate::film::Independent`]): pixels, or replicates alone where splats or chains
//! tie pixels together. It comes from a film, from the record that an image carries (`record`), or from the pixel errors of an image
//! without one, if its pixels are independent. [`judge`] tests all tiles of all pairs at one level.
//!
//! The tests are Welch's, corrected for skewness [Welch47; Hall92; Zhou05], all together by Holm's method [Holm79]. Limits: it takes
//! three replicates or more; what all pictures do wrong it cannot see; a difference that the noise hides it does not show.

mod judge;
mod measured;
mod record;
mod sources;
mod sum;
mod tiles;

pub(in crate::render) use judge::{Finding, Tested, test_pair};
pub use judge::{Judgement, Outcome, Pair, Picture, Worst, judge};
pub(in crate::render) use record::{RECORD, decode, encode};
pub use sources::Doubt;
pub(in crate::render) use sources::PixelErrors;
pub(in crate::render) use tiles::CHANNELS;
pub use tiles::Pyramid;

/// Replicates that a test takes at least: fewer do not tell how skewed a mean is.
pub(in crate::render) const LEAST_REPLICATES: usize = 3;
