//! Numbers: the scalar types that transport code is generic over, and neighbours of floats.

mod scalar;
mod ulp;

pub use scalar::Scalar;
pub use ulp::{BELOW_ONE, next_down, next_up};
