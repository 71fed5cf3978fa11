//! Paths through a scene: the walk that makes their vertices one by one, and the notation of all of path space.

mod walk;

pub use walk::{Departure, Tally, Walk};

#[doc = include_str!("notation.md")]
pub mod notation {}
