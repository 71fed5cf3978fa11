//! Tests whether all methods and backends converge to the same picture of a scene. Each [`Candidate`] renders the scene
//! with its own random numbers in [`REPLICATES`] independent replicates. Then the means of every pair are compared, for
//! the whole image and for tiles from 8×8 pixels upwards, at one family-wise level
//! ([`judge`](crate::lab::same_mean::judge)).
//!
//! Use it on a scene whose picture matters, and after any change to the renderer. Limits: an error common to all
//! candidates is not detected. A method with a blind spot in the scene is excluded and reported. Where a picture has
//! sampled too few of its contributions, a difference is indistinguishable from noise and counts as not shown. Light
//! that reaches a whole picture by fewer than about ten samples in all may be missed by chance, without any trace in
//! the error estimate. A method may then be reported as different from one that finds this light easily. A longer
//! budget settles it. "No difference" is reported with the smallest difference that would have been detected.
//!
//! A candidate with an untrusted error has a heavy-tailed sample distribution. It usually underestimates mean and
//! variance together. If it is the darker one of a pair, the pair is undecided, and `verify` names the candidate. If it
//! is brighter than the others, the difference counts.

mod candidate;
mod lineup;
mod odd;
mod pictures;
mod report;
mod run;
mod table;

pub use candidate::Candidate;
pub use lineup::{Lineup, VerifyRequest, default_size};
pub use odd::Outlier;
pub use pictures::write as write_pictures;
pub use report::VerifyReport;
pub use run::{Effort, Ran, affordable, run};

/// Number of independent replicates of each candidate. Their scatter is the error of the comparison.
pub const REPLICATES: u32 = 32;
