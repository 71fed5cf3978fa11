//! Paths through a scene: random walks that sample vertices from either end, connections between them, MIS weights over
//! all techniques, and the notation of path space.

mod connect;
mod content;
mod emitter;
mod fly;
mod full;
mod mis;
mod scatterer;
mod selection_stats;
mod subpath;
mod vertex;
mod walk;

pub use connect::{Connection, Splat, connect, next_event, splat};
pub use content::Content;
pub use emitter::Emitter;
pub use fly::{FlightEnd, Flown, MediumPoint, Stretch};
pub use full::{Densities, FullPath, PathVertex, VertexPdfs, edge};
pub use mis::{FlightPdfs, MisStrategy, PartialMis, Technique, Techniques};
pub use scatterer::{PhaseAt, Scatterer};
pub use selection_stats::SelectionStats;
pub use subpath::{Arrival, Subpath, SubpathVertex};
pub use vertex::{SurfaceVertex, Vertex};
pub use walk::{LONGEST, PreviousVertex, ROULETTE_FROM, RandomWalk, TraceStats, survival_probability};

#[doc = include_str!("notation.md")]
pub mod notation {}
