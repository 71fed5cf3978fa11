//! What the test binaries of étendue share: scenes, random numbers, hypothesis tests, quadrature. It is no part of the
//! product: étendue has it as a dev-dependency.

pub mod backward;
pub mod chi_square;
pub mod estimators;
pub mod folders;
pub mod forge;
pub mod levels;
pub mod methods;
pub mod quadrature;
pub mod random;
pub mod scenes;
pub mod slope;

pub use scenes::{studio, worlds};

/// Whether the long versions of tests run: `ETENDUE_TEST_DEEP=1`.
pub fn deep() -> bool {
    std::env::var_os("ETENDUE_TEST_DEEP").is_some_and(|v| v != "0")
}
