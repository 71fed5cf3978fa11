//! The film: order-independent integer sums per replicate, so that the image does not depend on threads, shards or
//! resumption.

mod accumulate;
mod block;
mod error_estimate;
mod estimator_variance;
mod evidence;
mod filter;
mod header;
mod independent;
mod layout;
mod max_samples;
mod noise;
mod pass_film;
mod pass_set;
mod prior;
// The lab reads what films write.
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub mod pyramid;
mod relmse;
mod replicates;
mod splats;
mod sums;
mod tail_index;
mod trust;
mod units;

pub use accumulate::Film;
pub use error_estimate::{ImageError, LargestSample};
pub use evidence::Evidence;
pub use filter::{Filter, FilterSampler};
pub use header::FilmHeader;
pub use independent::Independent;
pub use layout::{Crop, Layout, Plane};
pub(crate) use max_samples::keep_largest;
pub use pass_film::PassFilm;
pub use pass_set::PassSet;
pub use prior::{Known, Prior};
pub use relmse::{RelMse, relmse_epsilon};
pub use splats::{SplatQueue, Splats};
pub(crate) use sums::{Sums, add_all};
pub use tail_index::Peakedness;
pub use trust::{Distrust, Reason, Trust};
pub use units::Units;
