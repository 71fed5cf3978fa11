//! étendue: a physically based CPU renderer. It reads glTF, writes EXR and estimates the error of every image.
//!
//! Modules are listed by layer, called floors. A module imports only its own folder and lower floors; siblings on a
//! floor do not import each other. `tests/architecture` enforces this; ARCHITECTURE.md draws it.

// Tests compare floats exactly where arithmetic is exact.
#![cfg_attr(test, allow(clippy::float_cmp))]

// Scenes for tests refer to the crate by name, also where a unit test compiles them (integrator/metropolis).
#[cfg(test)]
extern crate self as etendue;

// floor 1
pub mod error;
pub mod huge_vec;
pub mod numeric;
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
pub mod session;
// floor 10
pub mod batch;
pub mod lab;
// floor 11
pub mod cli;

#[doc = include_str!("references.md")]
pub mod references {}
