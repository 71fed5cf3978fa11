//! The film: order-free integer sums per replicate, so that the picture does not depend on threads, shards or resumption.

mod accumulate;
mod error_estimate;
mod filter;
mod layout;
mod pass_set;

pub use accumulate::{Film, PassFilm, Units};
pub use error_estimate::{ImageError, RelMse};
pub use filter::Filter;
pub use layout::{Crop, Layout, Plane};
pub use pass_set::PassSet;
