//! Do all methods and backends give the same picture of a scene? Each [`Candidate`] renders the scene with its own random
//! numbers in [`REPLICATES`] independent replicates; then the means of every pair are compared, of the whole image and of tiles of
//! 8×8 pixels and upwards, at one level for everything together ([`judge`](crate::render::same_mean::judge)).
//!
//! Use it on a scene whose picture matters, and after any change to the renderer. Its limits: what all candidates do wrong it
//! cannot see; a method that is blind to something in the scene is left out, and says so; where a picture has met too few of the
//! contributions that make it, a difference cannot be told from bad luck, and counts as not shown. What a whole picture has not met
//! at all it cannot suspect either: light that reaches it by fewer than about ten samples in all may be missed by chance, and one
//! method then be said to differ from another that finds it easily (a longer budget tells). "No difference" comes with the smallest difference that would have been seen.
//!
//! A candidate whose error is not to be trusted, since its samples have a heavy tail, is too dark as a rule and too certain. Where it is
//! the darker one of a pair nothing is concluded: `verify` cannot tell, and says of whom. Brighter than others it is convicted.

mod candidate;
mod lineup;
mod odd;
mod pictures;
mod report;
mod run;
mod table;

pub use candidate::{Candidate, REPLICATES};
pub use lineup::{Lineup, Request, default_size};
pub use odd::Odd;
pub use pictures::write as write_pictures;
pub use report::Report;
pub use run::{Effort, Ran, affordable, run};
