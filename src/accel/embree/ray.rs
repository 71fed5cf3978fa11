//! Rays and hits in Embree's layout.

use crate::geometry::{Hit, Ray};
use embree4_sys::{RTC_INVALID_GEOMETRY_ID, RTCHit, RTCRay, RTCRayHit};

/// Returns `ray` without a hit.
#[inline]
pub(super) fn query(ray: &Ray) -> RTCRayHit {
    debug_assert!(ray.t_min >= 0.0 || ray.t_min.is_nan(), "Embree sorts by distance as if there were no negative ones");
    let [org_x, org_y, org_z] = ray.origin.to_array();
    let [dir_x, dir_y, dir_z] = ray.direction.to_array();
    let (tnear, tfar, time, mask) = (ray.t_min, ray.t_max, ray.state.time, u32::MAX);
    let none = RTC_INVALID_GEOMETRY_ID;
    RTCRayHit {
        ray: RTCRay { org_x, org_y, org_z, tnear, dir_x, dir_y, dir_z, time, tfar, mask, id: 0, flags: 0 },
        hit: RTCHit {
            Ng_x: 0.0,
            Ng_y: 0.0,
            Ng_z: 0.0,
            u: 0.0,
            v: 0.0,
            primID: none,
            geomID: none,
            instID: [none],
            instPrimID: [none],
        },
    }
}

/// Returns the result of a query.
#[inline]
pub(super) fn hit(hit: &RTCHit) -> Option<Hit> {
    (hit.geomID != RTC_INVALID_GEOMETRY_ID).then(|| named(hit.primID, hit.geomID, hit.instID[0]))
}

/// Returns the hit with Embree's ids: an object is an instance or, without one, a geometry of the top scene.
#[inline]
pub(super) fn named(primitive: u32, geometry: u32, instance: u32) -> Hit {
    Hit { object: if instance == RTC_INVALID_GEOMETRY_ID { geometry } else { instance }, primitive }
}
