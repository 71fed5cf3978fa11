//! Do all methods and backends give the same picture of a scene? Each [`Candidate`] renders the scene with its own random
//! numbers in [`REPLICATES`] independent replicates; then the means of every pair are compared, of the whole image and of tiles of
//! 8×8 pixels and upwards, at one level for everything together ([`judge`]).
//!
//! Use it on a scene whose picture matters, and after any change to the renderer. Its limits: what all candidates do wrong it
//! cannot see; a method that is blind to something in the scene is left out, and says so; where a picture has met too few of the
//! contributions that make it, a difference cannot be told from bad luck, and counts as not shown. What a whole picture has not met
//! at all it cannot suspect either: light that reaches it by fewer than about ten samples in all may be missed by chance, and one
//! method then be said to differ from another that finds it easily (a longer budget tells). "No difference" comes with the smallest difference that would have been seen. Pixels of a method are taken as independent of each other, which
//! methods that share chains or photons will not keep.

mod candidate;
mod judge;
mod lineup;
mod measured;
mod odd;
mod pictures;
mod report;
mod run;
mod table;
mod tiles;

pub use candidate::{Candidate, REPLICATES};
pub use judge::{Judgement, Pair, Worst, judge};
pub use lineup::{Lineup, Request, default_size};
pub use odd::Odd;
pub use pictures::write as write_pictures;
pub use report::Report;
pub use run::{Effort, Ran, affordable, run};
pub use tiles::Pyramid;
