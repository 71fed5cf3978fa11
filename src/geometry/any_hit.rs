//! Filters that decide while a ray travels whether a candidate hit counts (alpha masks).

use super::{Hit, Ray};

/// A stateless filter on candidate hits. A backend may ask about one candidate more than once and in any order, so the
/// answer must depend on the arguments only. Backends ask only about objects with [`super::Object::filtered`] set.
pub trait AnyHit: Sync {
    /// Whether this filter can reject anything at all; if not, backends leave it out of the traversal.
    const FILTERS: bool = true;
    /// Whether the candidate counts as a hit.
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
