//! étendue: a physically based CPU renderer. It reads glTF, writes EXR and estimates the error of every image.
//!
//! [`Scene::load`] and [`Render`] are the facade. The command line, `etendue`, is built on them.
//!
//! # A picture of a file
#![doc = concat!("```\n", include_str!("../examples/render.rs"), "```")]
//! # A scene that is described in code
#![doc = concat!("```\n", include_str!("../examples/own_scene.rs"), "```")]
//! # An integrator of the caller's own
#![doc = concat!("```\n", include_str!("../examples/own_integrator.rs"), "```")]
//! # Stability
//!
//! The items at the root of the crate are stable, as are [`film::Film`], [`integrator::Integrator`], the errors and the
//! settings ([`session::SettingsPatch`]). All others serve the program and its tests, and may change with any version.
//!
//! # Modules
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
pub mod named;
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
pub mod medium;
pub mod subsurface;
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
#[cfg(feature = "cli")]
pub mod lab;
// floor 11
#[cfg(feature = "cli")]
pub mod cli;

pub use error::{Error, Result};
pub use integrator::Method;
pub use scene::Scene;
pub use scene::description::Description;
pub use session::{Image, Render};

/// The vectors and matrices of scene descriptions.
pub use glam;

#[doc = include_str!("references.md")]
pub mod references {}
