//! The acceleration backends against geometry: which triangle a ray hits, leaks, and invalid input.

mod agreement;
mod brute_force;
mod edge_cases;
mod exact;
mod filters;
mod hard_cases;
mod judge;
mod judge_tests;
mod packets;
mod scenes;
mod segments;
mod spawned;
mod watertight;
