//! Radial bins, and estimates with standard errors.

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

/// A mean with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The mean.
    pub value: f64,
    /// Its standard error, from the scatter of batches.
    pub standard_error: f64,
}

impl Estimate {
    /// Returns the estimate from the means of equal batches, two at least.
    pub(super) fn of_batches(batches: &[f64]) -> Self {
        let n = batches.len() as f64;
        let value = batches.iter().sum::<f64>() / n;
        let squares: f64 = batches.iter().map(|x| (x - value).powi(2)).sum();
        Estimate { value, standard_error: (squares / (n * (n - 1.0))).sqrt() }
    }

    /// Returns the distance from the exact value in standard errors.
    pub fn sigmas(&self, exact: f64) -> f64 {
        (self.value - exact) / self.standard_error
    }
}
