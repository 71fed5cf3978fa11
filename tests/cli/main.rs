//! The real binary, driven as people and farms drive it.

#![allow(clippy::unwrap_used)]

// What renders needs a backend.
#[cfg(feature = "embree")]
mod end_to_end;
#[cfg(feature = "embree")]
mod environments;
#[cfg_attr(not(feature = "embree"), allow(dead_code))]
mod run;
#[cfg(feature = "embree")]
mod signals;
mod usage;
