//! Regression scenes, each with its right value: every backend, every method that sees the light.
//! scenes/met/README.md says what each file is and where its value comes from.

mod cases;
mod pictures;
mod render;
