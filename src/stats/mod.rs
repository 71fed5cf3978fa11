//! Statistics: moments, estimates with intervals, hypothesis tests at a stated level, corrections for multiple tests,
//! heavy tails ([`pareto`]). All computations are f64 and deterministic; distribution functions come from `statrs`.

mod estimate;
mod hypothesis;
mod moments;
mod multiple;
pub mod pareto;
mod power_law;
mod skewed;
mod student;
#[cfg(test)]
pub(crate) mod test_random;

pub use estimate::Estimate;
pub use hypothesis::{TestResult, t_test, welch_test};
pub use moments::{Moments, third_cumulant_of_mean};
pub use multiple::holm;
pub use power_law::{PowerLaw, WeightedPoint};
pub use skewed::{Skewness, detectable_difference, skewed_quantile, skewed_welch_test};
pub use student::{student_p_value, student_quantile};
