//! A point of one repetition.

use serde::Serialize;

/// State of a render at one sample count.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Mark {
    /// Samples per pixel.
    pub spp: u64,
    /// Processor time (user and system) in seconds, from the pilot on.
    pub cpu_seconds: f64,
    /// Wall-clock time in seconds.
    pub wall_seconds: f64,
    /// relMSE against the reference. The reference's noise is subtracted if known: 0 or less means that the error is
    /// lost in it.
    pub relmse: f64,
    /// Number of rays so far.
    pub rays: u64,
}
