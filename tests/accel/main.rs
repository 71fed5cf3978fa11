//! The acceleration backends against geometry: which triangle does a ray hit, and what must never happen.

mod agreement;
mod brute_force;
mod edge_cases;
mod filters;
mod scenes;
mod segments;
mod watertight;
