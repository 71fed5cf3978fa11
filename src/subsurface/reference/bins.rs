//! Radial bins.

/// Rings at equal ratios of radii.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bins {
    /// Inner radius of the first ring, in mean free paths.
    pub first: f64,
    /// Outer radius of the last ring.
    pub last: f64,
    /// Number of rings.
    pub count: usize,
}

impl Bins {
    /// Returns the inner radius of ring `i`, the outer one of ring `i` − 1.
    pub fn edge(&self, i: usize) -> f64 {
        self.first * (self.last / self.first).powf(i as f64 / self.count as f64)
    }

    /// Returns the ring that contains a radius, given squared.
    pub(super) fn of_squared(&self, squared: f64) -> Option<usize> {
        let x = 0.5 * (squared / (self.first * self.first)).ln() / (self.last / self.first).ln();
        let i = (x * self.count as f64).floor();
        (i >= 0.0 && i < self.count as f64).then_some(i as usize)
    }
}
