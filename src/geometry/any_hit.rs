//! Any-hit filters, evaluated during traversal (alpha masks).

use super::{Hit, Ray};

/// A stateless filter on candidate hits. A backend may evaluate it more than once per candidate and in any order, so
/// that the result must depend on the arguments only. Backends call it only for objects with
/// [`super::Object::filtered`] set.
pub trait AnyHit: Sync {
    /// Whether this filter can reject anything; otherwise backends omit it from traversal.
    const FILTERS: bool = true;
    /// Returns whether the candidate is a hit.
    fn accepts(&self, ray: &Ray, hit: Hit) -> bool;
}

/// The filter that accepts every hit.
#[derive(Debug, Clone, Copy)]
pub struct Opaque;

impl AnyHit for Opaque {
    const FILTERS: bool = false;
    #[inline]
    fn accepts(&self, _: &Ray, _: Hit) -> bool {
        true
    }
}
