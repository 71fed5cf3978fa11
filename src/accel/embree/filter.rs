//! Filter of a query: connects Embree's callback to the caller's [`AnyHit`].

use super::ray::named;
use crate::geometry::{AnyHit, Hit, Ray};
use embree4_sys::{
    RTC_INVALID_GEOMETRY_ID, RTCFilterFunctionN, RTCFilterFunctionNArguments, RTCHit, RTCRayQueryContext,
};
use std::any::Any;
use std::mem::offset_of;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

// The three ids that the callback reads at once.
const IDS: usize = offset_of!(RTCHit, primID);
const _: () = assert!(offset_of!(RTCHit, geomID) == IDS + 4 && offset_of!(RTCHit, instID) == IDS + 8);

/// Query context passed through Embree to the callback. Embree knows only its first member.
#[repr(C)]
pub(super) struct Filter<'a, A> {
    context: RTCRayQueryContext,
    /// The world-space ray: inside an instance Embree's own is in object space.
    ray: &'a Ray,
    any: &'a A,
    /// By object: whether the filter applies. An instanced mesh may be shared with objects without a filter.
    filtered: &'a [bool],
    panic: Option<Box<dyn Any + Send>>,
}

impl<'a, A: AnyHit> Filter<'a, A> {
    /// The function that Embree calls on candidate hits of a query with the context [`Self::context`].
    pub(super) const CALLBACK: RTCFilterFunctionN = Some(on_candidate::<A>);

    #[inline]
    pub(super) fn new(ray: &'a Ray, any: &'a A, filtered: &'a [bool]) -> Self {
        let none = RTC_INVALID_GEOMETRY_ID;
        Filter { context: RTCRayQueryContext { instID: [none], instPrimID: [none] }, ray, any, filtered, panic: None }
    }

    /// Returns the context for Embree, as a pointer that is valid for the whole filter.
    #[inline]
    pub(super) fn context(&mut self) -> *mut RTCRayQueryContext {
        (&raw mut *self).cast()
    }

    /// Returns the caller's answer. After a panic every candidate is accepted, which ends the query soonest.
    fn accepts(&mut self, hit: Hit) -> bool {
        if self.panic.is_some() || self.filtered.get(hit.object as usize) != Some(&true) {
            return true;
        }
        // No inconsistent state is observed: the panic resumes as soon as Embree returns.
        let answer = catch_unwind(AssertUnwindSafe(|| self.any.accepts(self.ray, hit)));
        answer.unwrap_or_else(|panic| {
            self.panic = Some(panic);
            true
        })
    }
}

/// Resumes a panic of the caller's filter: unwinding must not pass through Embree.
#[inline]
pub(super) fn resume_panic<A>(filter: Option<Filter<'_, A>>) {
    if let Some(panic) = filter.and_then(|filter| filter.panic) {
        resume_unwind(panic);
    }
}

/// # Safety
/// Called by Embree within a single-ray query whose context is that of a `Filter<A>`.
unsafe extern "C" fn on_candidate<A: AnyHit>(arguments: *const RTCFilterFunctionNArguments) {
    // SAFETY: Embree passes arguments that are valid during the call.
    let arguments = unsafe { &*arguments };
    // SAFETY: the context is the first member of a `Filter<A>` in C layout, `Filter::context` gave a pointer to the
    // whole of it, and Embree does not touch the context while its callback runs.
    let filter = unsafe { &mut *arguments.context.cast::<Filter<'_, A>>() };
    // SAFETY: a single-ray query has N = 1, where `RTCHitN` begins as `RTCHit` does: the ids stand side by side.
    let [primitive, geometry, instance] = unsafe { arguments.hit.wrapping_byte_add(IDS).cast::<[u32; 3]>().read() };
    if !filter.accepts(named(primitive, geometry, instance)) {
        // SAFETY: `valid` points to N = 1 flags for the callback to clear.
        unsafe { *arguments.valid = 0 };
    }
}
