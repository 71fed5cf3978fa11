//! Paths through a scene: the walk that makes their vertices one by one.

mod walk;

pub use walk::{Departure, Tally, Walk};
