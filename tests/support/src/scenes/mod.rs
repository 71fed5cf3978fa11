//! Scenes for tests. The unit tests of src/integrator/metropolis compile this folder once more (see there).

pub mod studio;
pub mod worlds;
