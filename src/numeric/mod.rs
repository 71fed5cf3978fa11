//! Numbers: the scalar types that transport code is generic over, and error-free arithmetic.

mod eft;
mod scalar;
mod ulp;

pub use eft::{difference_of_products, gamma};
pub use scalar::Scalar;
pub use ulp::{BELOW_ONE, next_down, next_up};
