//! Paths through a scene: the walk that makes their vertices one by one.

mod walk;

pub use walk::{Arrival, Departure, Tally, Walk};
