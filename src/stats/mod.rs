//! Statistics: moments, estimates with intervals, hypothesis tests at a stated level, corrections for multiple tests,
//! errors of functions of means and of series ([`jackknife`](jackknife()), [`chains`]), heavy tails ([`pareto`]), image
//! metrics ([`image`]). All computations are f64 and deterministic; distribution functions come from `statrs`.

pub mod chains;
mod chi_squared;
mod estimate;
mod hypothesis;
pub mod image;
mod jackknife;
mod moments;
mod multiple;
pub mod pareto;
mod power_law;
mod skewed;
mod student;
#[cfg(test)]
pub(crate) mod test_random;

pub use chi_squared::{chi_squared_p_value, chi_squared_test};
pub use estimate::Estimate;
pub use hypothesis::{TestResult, t_test, welch_test, z_test};
pub use jackknife::{Jackknife, jackknife};
pub use moments::{Moments, third_cumulant_of_mean};
pub use multiple::{holm, sidak_level, sidak_p_value};
pub use power_law::{PowerLaw, WeightedPoint};
pub use skewed::{Skewness, detectable_difference, skewed_quantile, skewed_welch_test};
pub use student::{student_p_value, student_quantile};
