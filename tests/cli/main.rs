//! The real binary, driven as people and farms drive it.

#![allow(clippy::unwrap_used)]

mod backends;
mod compare;
mod bench_methods;
mod end_to_end;
mod environments;
mod run;
mod signals;
mod targets;
mod usage;
