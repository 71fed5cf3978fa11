//! Markov chains that sample a density known up to a factor: states, kernels that propose new ones, the chain that accepts or rejects
//! them. It knows nothing of light: what a state is and what it is worth is its user's.
//!
//! To sample something, give its state a [`State::log_target`] and write a [`Kernel`] or several: each leaves the target as it is on its
//! own, so that any [`Mixture`] does. A chain's numbers are functions of its address, whoever runs it. Where states are points of a unit
//! cube whose dimension is not known before, [`primary`] has them and the kernels for them. What a chain's numbers say of the error of
//! an estimate is nothing that can be trusted: that comes from independent chains.

mod chain;
mod numbers;
pub mod primary;
mod resample;
mod small_step;

pub use chain::{Chain, Kernel, KernelCounts, Mixture, State};
pub use numbers::Numbers;
pub use resample::stratified;
pub use small_step::SmallStep;

#[cfg(test)]
mod tests;
