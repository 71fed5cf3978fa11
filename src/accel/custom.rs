//! Intersectors of the caller's own: another acceleration structure, or a wrapper that counts or records queries.

use super::{Backend, RayClass};
use crate::geometry::{AnyHit, Hit, Ray};

/// Filter of candidate hits, as a function: see [`AnyHit`].
pub type HitFilter<'a> = dyn Fn(&Ray, Hit) -> bool + Sync + 'a;

/// [`super::Intersector`] without generics. Filters apply only to objects with
/// [`filtered`](crate::geometry::Object::filtered) set; without a filter every candidate is a hit.
pub trait CustomIntersector: Send + Sync {
    /// Returns the first hit along the ray that `filter` accepts.
    fn closest(&self, ray: &Ray, filter: Option<&HitFilter<'_>>) -> Option<Hit>;
    /// Returns whether the ray has any hit that `filter` accepts.
    fn occluded(&self, ray: &Ray, filter: Option<&HitFilter<'_>>) -> bool;
    /// Returns the backend that reports name.
    fn backend(&self) -> Backend;
    /// Returns the memory in bytes.
    fn bytes(&self) -> usize {
        0
    }
    /// The next rays of this thread are of `class`. Only a hint.
    fn announce(&self, _class: RayClass) {}
}

/// Calls `ask` with the filter as a function; with `None` if it rejects nothing.
pub(super) fn with_filter<A: AnyHit, T>(any: &A, ask: impl FnOnce(Option<&HitFilter<'_>>) -> T) -> T {
    let accepts = |ray: &Ray, hit: Hit| any.accepts(ray, hit);
    ask(if A::FILTERS { Some(&accepts) } else { None })
}

/// A function as [`AnyHit`].
pub struct FilterFn<'a>(pub &'a HitFilter<'a>);

impl AnyHit for FilterFn<'_> {
    fn accepts(&self, ray: &Ray, hit: Hit) -> bool {
        (self.0)(ray, hit)
    }
}
