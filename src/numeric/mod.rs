//! Numeric types: the scalar trait of generic transport code, and neighbouring floats.

mod scalar;
mod ulp;

pub use scalar::Scalar;
pub use ulp::{BELOW_ONE, next_down, next_up};
