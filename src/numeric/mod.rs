//! Numbers: the scalar types that transport code is generic over, and error-free arithmetic.

mod eft;
mod scalar;

pub use eft::{difference_of_products, gamma};
pub use scalar::Scalar;
