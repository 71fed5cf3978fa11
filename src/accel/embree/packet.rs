//! Packets of rays, as wide as the processor's registers.

use super::filter::{Filter, resume_panic};
use super::geometry::Committed;
use crate::accel::Coherence;
use crate::geometry::{AnyHit, Hit, Hits, Rays};
use embree4_sys::{
    RTC_INVALID_GEOMETRY_ID, RTCFeatureFlags, RTCIntersectArguments, RTCOccludedArguments, RTCRay8, RTCRay16,
    RTCRayHit8, RTCRayHit16, RTCRayQueryFlags, rtcIntersect8, rtcIntersect16, rtcOccluded8, rtcOccluded16,
};
use std::mem::zeroed;
use std::ptr::null_mut;

/// Lanes of a packet that hold a ray: −1, else 0. Aligned as the widest packet wants.
#[repr(C, align(64))]
struct Valid<const N: usize>([i32; N]);

impl<const N: usize> Valid<N> {
    /// Marks the rays from `at` on that are finite and have points. With [`Coherence::Coherent`] any other would take
    /// hits from its neighbours, and Embree calls a ray occluded that ends before its origin.
    #[inline]
    fn of(rays: &Rays, at: usize) -> Self {
        // NaN where a coordinate is not finite. Loops and not closures by lane: the compiler vectorises them.
        let mut zeros = [0.0; N];
        for column in rays.origin.iter().chain(&rays.direction) {
            zeros.iter_mut().zip(&column[at..at + N]).for_each(|(zero, x)| *zero += x * 0.0);
        }
        let mut valid = [0; N];
        for (lane, (&zero, &t_max)) in zeros.iter().zip(&rays.t_max[at..at + N]).enumerate() {
            valid[lane] = -i32::from((at + lane < rays.len()) & (zero >= 0.0) & (t_max >= 0.0));
        }
        Valid(valid)
    }
}

/// Least magnitude whose reciprocal Embree computes (its `min_rcp_input`).
const LEAST_RECIPROCAL: f32 = 1e-18;

/// Returns Embree's flag for the `N` rays from `at` on. Embree sorts coherent rays into octants by their signs, but has
/// the reciprocal of a small negative component positive. Such a ray would be outside the frustum of its octant.
#[inline]
fn flags<const N: usize>(coherence: Coherence, rays: &Rays, at: usize) -> RTCRayQueryFlags {
    let is_odd = |x: f32| (x < 0.0) & (x > -LEAST_RECIPROCAL);
    let any_odd = |column: &Vec<f32>| column[at..at + N].iter().fold(false, |any, &x| any | is_odd(x));
    if coherence == Coherence::Coherent && !rays.direction.iter().any(any_odd) {
        RTCRayQueryFlags::RTC_RAY_QUERY_FLAG_COHERENT
    } else {
        RTCRayQueryFlags::RTC_RAY_QUERY_FLAG_INCOHERENT
    }
}

/// Barycentric distance to a side below which a hit may be a tie. Hits of two triangles on both sides of an edge have the
/// same distance, and which of them a coherent packet finds depends on its other rays. Embree accepts hits an ulp outside,
/// which may be a thousand times further inside a neighbour of a thousandth of the size.
const EDGE: f32 = 1e-4;

/// Marks lanes with hits so close to a side of their triangles that they may be ties: −1, else 0.
#[inline]
fn ties<const N: usize>(u: &[f32; N], v: &[f32; N], geometry: &[u32; N]) -> [i32; N] {
    let mut ties = [0; N];
    for (lane, tie) in ties.iter_mut().enumerate() {
        let (u, v) = (u[lane], v[lane]);
        let is_near = (u < EDGE) | (v < EDGE) | (u + v > 1.0 - EDGE);
        *tie = -i32::from(is_near & (geometry[lane] != RTC_INVALID_GEOMETRY_ID));
    }
    ties
}

/// Loads the rays from `at` on into a packet.
macro_rules! fill {
    ($n:literal, $query:expr, $rays:ident, $at:ident) => {
        $query.org_x.copy_from_slice(&$rays.origin[0][$at..$at + $n]);
        $query.org_y.copy_from_slice(&$rays.origin[1][$at..$at + $n]);
        $query.org_z.copy_from_slice(&$rays.origin[2][$at..$at + $n]);
        $query.dir_x.copy_from_slice(&$rays.direction[0][$at..$at + $n]);
        $query.dir_y.copy_from_slice(&$rays.direction[1][$at..$at + $n]);
        $query.dir_z.copy_from_slice(&$rays.direction[2][$at..$at + $n]);
        $query.tfar.copy_from_slice(&$rays.t_max[$at..$at + $n]);
        $query.mask = [u32::MAX; $n];
        $query.id = std::array::from_fn(|lane| ($at + lane) as u32);
    };
}

macro_rules! packets {
    ($n:literal, $closest:ident $intersect:ident $rayhit:ident, $occluded:ident $occlude:ident $ray:ident) => {
        /// Finds the hits of `rays` that the filter accepts. Where there may be a tie, `alone` returns the hit of the ray
        /// by itself, so that hits do not depend on how rays are packed.
        pub(super) fn $closest<A: AnyHit>(
            scene: &Committed,
            rays: &Rays,
            coherence: Coherence,
            mut filter: Option<Filter<'_, A, Rays>>,
            alone: impl Fn(usize) -> Option<Hit>,
            hits: &mut Hits,
        ) {
            let mut arguments = RTCIntersectArguments {
                flags: RTCRayQueryFlags::RTC_RAY_QUERY_FLAG_INCOHERENT,
                feature_mask: RTCFeatureFlags::RTC_FEATURE_FLAG_ALL,
                context: filter.as_mut().map_or(null_mut(), Filter::context),
                filter: filter.as_ref().and(Filter::<A, Rays>::CALLBACK),
                intersect: None,
            };
            // SAFETY: plain numbers, for which zeros are values.
            let mut query: $rayhit = unsafe { zeroed() };
            for at in (0..rays.len()).step_by($n) {
                let valid = Valid::<$n>::of(rays, at);
                arguments.flags = flags::<$n>(coherence, rays, at);
                fill!($n, query.ray, rays, at);
                query.hit.geomID = [RTC_INVALID_GEOMETRY_ID; $n];
                query.hit.primID = [RTC_INVALID_GEOMETRY_ID; $n];
                query.hit.instID[0] = [RTC_INVALID_GEOMETRY_ID; $n];
                // SAFETY: the scene is committed, mask and query are laid out and aligned as Embree's headers say; the
                // context is null or that of a `Filter<A, Rays>` that outlives the call, as its callback requires.
                unsafe { $intersect(valid.0.as_ptr(), scene.raw(), &raw mut query, &raw mut arguments) };
                let (geometry, instance) = (query.hit.geomID, query.hit.instID[0]);
                let object = |lane: usize| {
                    if instance[lane] == RTC_INVALID_GEOMETRY_ID { geometry[lane] } else { instance[lane] }
                };
                let objects: [u32; $n] = std::array::from_fn(object);
                hits.objects[at..at + $n].copy_from_slice(&objects);
                hits.primitives[at..at + $n].copy_from_slice(&query.hit.primID);
                let ties = ties(&query.hit.u, &query.hit.v, &geometry);
                if ties.iter().fold(0, |any, tie| any | tie) != 0 {
                    (0..$n).filter(|&lane| ties[lane] != 0).for_each(|lane| hits.set(at + lane, alone(at + lane)));
                }
            }
            resume_panic(filter);
        }

        /// Finds which of `rays` have a hit that the filter accepts.
        pub(super) fn $occluded<A: AnyHit>(
            scene: &Committed,
            rays: &Rays,
            coherence: Coherence,
            mut filter: Option<Filter<'_, A, Rays>>,
            occluded: &mut [bool],
        ) {
            let mut arguments = RTCOccludedArguments {
                flags: RTCRayQueryFlags::RTC_RAY_QUERY_FLAG_INCOHERENT,
                feature_mask: RTCFeatureFlags::RTC_FEATURE_FLAG_ALL,
                context: filter.as_mut().map_or(null_mut(), Filter::context),
                filter: filter.as_ref().and(Filter::<A, Rays>::CALLBACK),
                occluded: None,
            };
            // SAFETY: plain numbers, for which zeros are values.
            let mut query: $ray = unsafe { zeroed() };
            for at in (0..rays.len()).step_by($n) {
                let valid = Valid::<$n>::of(rays, at);
                arguments.flags = flags::<$n>(coherence, rays, at);
                fill!($n, query, rays, at);
                // SAFETY: as for the closest hit.
                unsafe { $occlude(valid.0.as_ptr(), scene.raw(), &raw mut query, &raw mut arguments) };
                let marked: [bool; $n] = std::array::from_fn(|lane| query.tfar[lane] < rays.t_max[at + lane]);
                occluded[at..at + $n].copy_from_slice(&marked);
            }
            resume_panic(filter);
        }
    };
}

packets!(16, closest16 rtcIntersect16 RTCRayHit16, occluded16 rtcOccluded16 RTCRay16);
packets!(8, closest8 rtcIntersect8 RTCRayHit8, occluded8 rtcOccluded8 RTCRay8);
