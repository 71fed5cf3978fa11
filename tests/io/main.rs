//! Reading scene files: real ones, small ones made here, and broken ones.

mod animation;
mod bounds;
mod corpus;
mod defects;
mod environments;
mod formats;
mod geometry;
mod hierarchy;
mod materials;
mod samples;
mod support;
