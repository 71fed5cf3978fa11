//! Samplers, densities and values of scattering models and warps against each other, and against what physics asks.
//! Statistical tests state their family-wise level and have fixed seeds; `ETENDUE_TEST_DEEP=1` takes more samples.

// Lobes are disjoint, so their sums are exact.
#![allow(clippy::float_cmp)]

#[path = "../support/backward.rs"]
mod backward;
#[path = "../support/chi_square.rs"]
mod chi_square;
#[path = "../support/deep.rs"]
mod deep;
#[path = "../support/quadrature.rs"]
mod quadrature;
#[path = "../support/random.rs"]
mod random;
#[path = "../support/slope.rs"]
mod slope;

mod cameras;
mod choices;
mod distributions;
mod emission;
mod environments;
mod furnace;
mod grazing;
mod identities;
mod inverses;
mod lights;
mod models;
mod monte_carlo;
mod punctual;
mod shading;
mod textbook;
mod warps;
