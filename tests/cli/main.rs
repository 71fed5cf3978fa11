//! The real binary, driven as people and farms drive it.

#![allow(clippy::unwrap_used)]

mod backends;
mod end_to_end;
mod environments;
mod run;
mod signals;
mod usage;
mod verify;
