//! Paths through a scene: walks that make their vertices one by one from either end, connections between them, the weights of all
//! the ways to make a path, and the notation of all of path space.

mod connect;
mod emitter;
mod full;
mod mis;
mod subpath;
mod walk;

pub use connect::{Connection, Splat, connect, next_event, splat, toward_end, toward_light};
pub use emitter::Emitter;
pub use full::{Densities, Evaluation, FullPath, Node, Steps};
pub use mis::{Sums, Technique, Techniques, Weights};
pub use subpath::{Arrival, Subpath, Vertex};
pub use walk::{Departure, Tally, Walk};

#[doc = include_str!("notation.md")]
pub mod notation {}
