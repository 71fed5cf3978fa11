//! Samplers, densities and values of scattering models and warps against each other, and against what physics asks.
//! Statistical tests state their family-wise level and have fixed seeds; `ETENDUE_TEST_DEEP=1` takes more samples.

// Lobes are disjoint, so their sums are exact.
#![allow(clippy::float_cmp)]

mod bounds;
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
mod media;
mod models;
mod monte_carlo;
mod punctual;
mod shading;
mod textbook;
mod textured;
mod triangles;
mod walks;
mod warps;
