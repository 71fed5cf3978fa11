//! Paths through a scene: random walks that sample vertices from either end, connections between them, MIS weights over
//! all techniques, and the notation of path space.

mod connect;
mod emitter;
mod fly;
mod full;
mod mis;
mod selection_stats;
mod subpath;
mod vertex;
mod walk;

pub use connect::{Connection, Splat, connect, next_event, splat};
pub use emitter::Emitter;
pub use fly::{FlightEnd, MediumPoint};
pub use full::{Densities, Evaluation, FullPath, PathVertex, VertexPdfs};
pub use mis::{MisStrategy, PartialMis, Technique, Techniques};
pub use selection_stats::SelectionStats;
pub use subpath::{Arrival, Subpath, SubpathVertex};
pub use vertex::{MediumVertex, SurfaceVertex, Vertex};
pub use walk::{LONGEST, PreviousVertex, ROULETTE_FROM, RandomWalk, TraceStats, survival_probability};

#[doc = include_str!("notation.md")]
pub mod notation {}
