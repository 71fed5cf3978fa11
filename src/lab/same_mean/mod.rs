//! Tests whether pictures have the same mean. One implementation serves `compare` (two files) and `verify` (all
//! candidates of a run). [`judge`] tests all tiles of all pairs at one family-wise level; the tiles are those of
//! [`Pyramid`](crate::film::pyramid::Pyramid).
//!
//! The tests are Welch's, corrected for skewness [Welch47; Hall92; Zhou05], and together corrected by Holm's method
//! [Holm79]. Limits: three or more replicates are required. An error common to all pictures is not detected. Neither is
//! a difference below the noise.

mod doubt;
mod judge;
mod measured;

pub use doubt::Doubt;
pub(crate) use judge::{Finding, Tested, test_pair};
pub use judge::{Judgement, Outcome, PairJudgement, TestedPicture, Worst, judge};
