//! The film: order-free integer sums per replicate, so that the picture does not depend on threads, shards or resumption.

mod accumulate;
mod error_estimate;
mod evidence;
mod filter;
mod head;
mod layout;
mod noise;
mod pass_film;
mod pass_set;
mod peaks;
mod prior;
mod replicates;
mod splats;
mod spread;
mod sums;
mod tail;
mod trust;
mod units;

pub use accumulate::Film;
pub use error_estimate::{ImageError, LargestSample, RelMse};
pub use evidence::Evidence;
pub use filter::{Filter, FilterSampler};
pub use head::Head;
pub use layout::{Crop, Layout, Plane};
pub use noise::Independent;
pub use pass_film::PassFilm;
pub use pass_set::PassSet;
pub(crate) use peaks::keep_largest;
pub use prior::{Known, Prior};
pub use splats::Splats;
pub(crate) use sums::{Sums, add_all};
pub use tail::Peakedness;
pub use trust::{Distrust, Reason, Trust};
pub use units::Units;
