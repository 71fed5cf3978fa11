//! Raw bindings to Embree 4, generated at build time from the installed headers. No logic: `etendue::accel::embree` is
//! the safe side. Reference: the manual of Embree 4.

#[allow(
    missing_docs,
    non_camel_case_types,
    non_snake_case,
    non_upper_case_globals,
    unreachable_pub,
    unsafe_code,
    clippy::all
)]
mod bindings {
    include!(concat!(env!("OUT_DIR"), "/bindings.rs"));
}

pub use bindings::*;

/// The id of no geometry, primitive or instance: a C macro with a cast, which bindgen leaves out.
pub const RTC_INVALID_GEOMETRY_ID: u32 = u32::MAX;

// What the safe side relies on. The library was compiled from the same headers, so a difference means that clang read
// them otherwise than the library's compiler did.
const _: () = {
    use std::mem::{align_of, offset_of, size_of};
    assert!(RTC_VERSION >= 40300 && RTC_VERSION < 50000);
    assert!(RTC_MAX_INSTANCE_LEVEL_COUNT == 1);
    assert!(size_of::<RTCRay>() == 48 && align_of::<RTCRay>() == 16);
    assert!(size_of::<RTCHit>() == 48 && align_of::<RTCHit>() == 16);
    assert!(size_of::<RTCRayHit>() == 96 && align_of::<RTCRayHit>() == 16);
    assert!(offset_of!(RTCRay, tfar) == 32 && offset_of!(RTCRayHit, hit) == 48);
    assert!(offset_of!(RTCHit, primID) == 20 && offset_of!(RTCHit, geomID) == 24 && offset_of!(RTCHit, instID) == 28);
    assert!(size_of::<RTCRayQueryContext>() == 8 && align_of::<RTCRayQueryContext>() == 4);
    assert!(size_of::<RTCBounds>() == 32 && align_of::<RTCBounds>() == 16);
    let pointer = size_of::<usize>();
    assert!(size_of::<RTCFilterFunctionNArguments>() == 6 * pointer);
    assert!(offset_of!(RTCFilterFunctionNArguments, N) == 5 * pointer);
    assert!(RTC_MIN_WIDTH == 0);
    assert!(size_of::<RTCIntersectArguments>() == 8 + 3 * pointer);
    assert!(size_of::<RTCOccludedArguments>() == size_of::<RTCIntersectArguments>());
    assert!(
        offset_of!(RTCIntersectArguments, context) == 8 && offset_of!(RTCIntersectArguments, filter) == 8 + pointer
    );
};
