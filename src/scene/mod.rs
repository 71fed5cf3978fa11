//! Scenes: the description as loaded, and what is built from it.

pub mod description;
