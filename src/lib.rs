//! étendue: a physically based CPU renderer. glTF in, EXR out, and every image carries its error.
//!
//! Modules are listed in floor order: a module imports its own folder and lower floors only, and siblings on one floor
//! do not import each other (`tests/architecture.rs` checks it; ARCHITECTURE.md draws it).

// Tests compare floats exactly where arithmetic is exact.
#![cfg_attr(test, allow(clippy::float_cmp))]

// Scenes that integration tests have, for unit tests as well: they speak of the crate by its name.
#[cfg(test)]
extern crate self as etendue;
#[cfg(test)]
#[allow(dead_code)]
#[path = "../tests/agreement/studio.rs"]
mod studio;

// floor 1
pub mod defects;
pub mod error;
pub mod numeric;
pub mod pages;
pub mod parallel;
// floor 2
pub mod sampling;
pub mod spectrum;
pub mod stats;
// floor 3
pub mod geometry;
pub mod mcmc;
// floor 4
pub mod accel;
pub mod texture;
pub mod transport;
// floor 5
pub mod bsdf;
pub mod camera;
pub mod film;
pub mod light;
// floor 6
pub mod scene;
// floor 7
pub mod path;
// floor 8
pub mod integrator;
pub mod io;
// floor 9
pub mod render;
// floor 10
pub mod cli;

#[doc = include_str!("references.md")]
pub mod references {}
