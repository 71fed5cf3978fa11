//! Filter of a query: connects Embree's callback to the caller's [`AnyHit`].

use super::ray::named;
use crate::geometry::{AnyHit, Hit, Ray, Rays};
use embree4_sys::{
    RTC_INVALID_GEOMETRY_ID, RTCFilterFunctionN, RTCFilterFunctionNArguments, RTCHit, RTCRay, RTCRayQueryContext,
};
use std::any::Any;
use std::mem::offset_of;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

// Arrays of a packet of N lanes follow each other as the fields of a single ray or hit do, each N words long.
const ID: usize = offset_of!(RTCRay, id) / 4;
const PRIMITIVE: usize = offset_of!(RTCHit, primID) / 4;
const GEOMETRY: usize = offset_of!(RTCHit, geomID) / 4;
const INSTANCE: usize = offset_of!(RTCHit, instID) / 4;

/// The world-space rays of a query. Embree's own are in object space inside an instance.
pub(super) trait Source {
    /// Returns the ray of number `id` in the query.
    fn ray(&self, id: usize) -> Ray;
}

impl Source for Ray {
    #[inline]
    fn ray(&self, _: usize) -> Ray {
        *self
    }
}

impl Source for Rays {
    #[inline]
    fn ray(&self, id: usize) -> Ray {
        Rays::ray(self, id)
    }
}

/// Query context passed through Embree to the callback. Embree knows only its first member.
#[repr(C)]
pub(super) struct Filter<'a, A, S> {
    context: RTCRayQueryContext,
    rays: &'a S,
    any: &'a A,
    /// By object: whether the filter applies. An instanced mesh may be shared with objects without a filter.
    filtered: &'a [bool],
    panic: Option<Box<dyn Any + Send>>,
}

impl<'a, A: AnyHit, S: Source> Filter<'a, A, S> {
    /// The function that Embree calls on candidate hits of a query with the context [`Self::context`].
    pub(super) const CALLBACK: RTCFilterFunctionN = Some(on_candidate::<A, S>);

    #[inline]
    pub(super) fn new(rays: &'a S, any: &'a A, filtered: &'a [bool]) -> Self {
        let none = RTC_INVALID_GEOMETRY_ID;
        Filter { context: RTCRayQueryContext { instID: [none], instPrimID: [none] }, rays, any, filtered, panic: None }
    }

    /// Returns the context for Embree, as a pointer that is valid for the whole filter.
    #[inline]
    pub(super) fn context(&mut self) -> *mut RTCRayQueryContext {
        (&raw mut *self).cast()
    }

    /// Returns the caller's answer. After a panic every candidate is accepted, which ends the query soonest.
    fn accepts(&mut self, id: usize, hit: Hit) -> bool {
        if self.panic.is_some() || self.filtered.get(hit.object as usize) != Some(&true) {
            return true;
        }
        // No inconsistent state is observed: the panic resumes as soon as Embree returns.
        let answer = catch_unwind(AssertUnwindSafe(|| self.any.accepts(&self.rays.ray(id), hit)));
        answer.unwrap_or_else(|panic| {
            self.panic = Some(panic);
            true
        })
    }
}

/// Resumes a panic of the caller's filter: unwinding must not pass through Embree.
#[inline]
pub(super) fn resume_panic<A, S>(filter: Option<Filter<'_, A, S>>) {
    if let Some(panic) = filter.and_then(|filter| filter.panic) {
        resume_unwind(panic);
    }
}

/// # Safety
/// Called by Embree within a query whose context is that of a `Filter<A, S>`.
unsafe extern "C" fn on_candidate<A: AnyHit, S: Source>(arguments: *const RTCFilterFunctionNArguments) {
    // SAFETY: Embree passes arguments that are valid during the call.
    let arguments = unsafe { &*arguments };
    // SAFETY: the context is the first member of a `Filter<A, S>` in C layout, `Filter::context` gave a pointer to the
    // whole of it, and Embree does not touch the context while its callback runs.
    let filter = unsafe { &mut *arguments.context.cast::<Filter<'_, A, S>>() };
    let lanes = arguments.N as usize;
    let (rays, hits) = (arguments.ray.cast::<u32>(), arguments.hit.cast::<u32>());
    for lane in 0..lanes {
        // SAFETY: `valid` points to N flags, which the callback may read and clear.
        let valid = unsafe { &mut *arguments.valid.wrapping_add(lane) };
        if *valid == 0 {
            continue;
        }
        // SAFETY: ray and hit hold N lanes of each field, in the order of the fields: see `ID`.
        let id = unsafe { *rays.wrapping_add(ID * lanes + lane) };
        let field = |field: usize| {
            // SAFETY: as above.
            unsafe { *hits.wrapping_add(field * lanes + lane) }
        };
        if !filter.accepts(id as usize, named(field(PRIMITIVE), field(GEOMETRY), field(INSTANCE))) {
            *valid = 0;
        }
    }
}
