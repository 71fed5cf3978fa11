//! The binary as a process: arguments, files, exit codes, signals.

#![allow(clippy::unwrap_used)]

mod backends;
mod batch;
mod bench_methods;
mod bench_rays;
mod compare;
mod end_to_end;
mod environments;
mod faults;
mod frames;
mod lamps;
mod media;
mod notes;
mod one_hash;
mod run;
mod signals;
mod targets;
mod techniques;
mod usage;
mod verify;
