//! Numeric types: the scalar trait of generic transport code, and neighbouring floats; the mean of an image.

mod scalar;
mod ulp;

pub use scalar::Scalar;
pub use ulp::{BELOW_ONE, next_down, next_up};

/// Returns the mean of `values`, summed in their order; 0 without values.
pub fn mean(values: &[f32]) -> f64 {
    values.iter().copied().map(f64::from).sum::<f64>() / values.len().max(1) as f64
}
