//! Pictures of the integrators against closed forms, stored references of other renderers, and each other.
//!
//! Every judgement is a hypothesis test whose level is said where it is made; seeds are fixed, so a right renderer
//! never fails by chance twice. `ETENDUE_TEST_DEEP=1` runs the long versions (`make test-deep`).

#[cfg(feature = "embree")]
mod backends;
mod batches;
mod bidirectional;
mod bodies;
mod chains;
mod closed_forms;
mod coverage;
mod diffusion;
mod enclosures;
mod environments;
mod equilibrium;
mod exact;
mod extremes;
mod hard_cases;
mod hidden_tails;
mod images_of_lights;
mod invariance;
mod lamps;
mod lens;
mod many_lights;
mod meaning;
mod media;
mod moved;
mod picture;
mod pixel_filters;
mod reciprocity;
mod references;
mod rough_bodies;
mod same_mean;
mod sides;
mod slopes;
mod smooth_glass;
mod symmetries;
mod techniques;
mod ten_thousand;
mod textures;
mod touching;
mod trusted;
mod uneven_lights;
mod virtual_lights;
