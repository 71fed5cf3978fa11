//! Do the integrators give the right picture? Closed forms, stored references of other renderers, and each other.
//!
//! Every judgement is a hypothesis test whose level is said where it is made; seeds are fixed, so a right renderer never
//! fails by chance twice. `ETENDUE_TEST_DEEP=1` runs the long versions (`make test-deep`).

#[cfg(feature = "embree")]
mod backends;
mod closed_forms;
mod coverage;
mod enclosures;
mod environments;
mod hard_cases;
mod invariance;
mod lamps;
mod moved;
mod picture;
mod references;
mod sides;
mod studio;
