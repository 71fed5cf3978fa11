//! Markov chain Monte Carlo for a density known up to a factor: states, proposal kernels, and the Metropolis–Hastings
//! chain. Independent of light transport: the caller defines states and targets.
//!
//! To sample a density, give its state a [`State::log_target`] and write one or more [`Kernel`]s. Each must leave the
//! target invariant, so that any [`Mixture`] does. The random numbers of a chain are functions of its address and do
//! not depend on threads. [`primary`] provides states and kernels for a unit cube of unknown dimension. Error estimates
//! from a single chain are not reliable; use independent chains.

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
