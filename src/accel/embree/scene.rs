//! Embree scenes: shapes are attached, the scene is committed, then queried.

use super::device::Device;
use super::filter::Filter;
use super::geometry::Shape;
use crate::accel::Build;
use crate::error::{Error, Kind, Result};
use crate::geometry::{AnyHit, TriangleMesh};
use embree4_sys::{
    RTC_INVALID_GEOMETRY_ID, RTCBuildQuality, RTCFeatureFlags, RTCIntersectArguments, RTCOccludedArguments, RTCRay,
    RTCRayHit, RTCRayQueryFlags, RTCScene, RTCSceneFlags, rtcAttachGeometryByID, rtcCommitScene, rtcIntersect1,
    rtcNewScene, rtcOccluded1, rtcReleaseScene, rtcSetSceneBuildQuality, rtcSetSceneFlags,
};
use glam::Affine3A;
use std::ptr;
use std::sync::Arc;

/// A reference to an Embree scene.
struct Handle(RTCScene);

// SAFETY: Embree's manual allows queries of a committed scene from any thread; only `SceneBuilder`, which has the sole
// handle, changes one, and references are counted atomically.
unsafe impl Send for Handle {}
// SAFETY: as above; nothing changes a scene through a shared handle.
unsafe impl Sync for Handle {}

impl Drop for Handle {
    fn drop(&mut self) {
        // SAFETY: this is the reference that `rtcNewScene` gave, and it is released once.
        unsafe { rtcReleaseScene(self.0) };
    }
}

/// A scene under construction.
pub(super) struct SceneBuilder {
    handle: Handle,
    shapes: Vec<Shape>,
    filtered: bool,
    device: Arc<Device>,
}

impl SceneBuilder {
    /// Returns an empty scene.
    pub(super) fn new(device: &Arc<Device>) -> Result<Self> {
        // SAFETY: the device is live.
        let handle = Handle(unsafe { rtcNewScene(device.raw()) });
        device.check("make a scene")?;
        Ok(SceneBuilder { handle, shapes: Vec::new(), filtered: false, device: Arc::clone(device) })
    }

    /// Attaches a mesh whose hits have the object index `id`.
    pub(super) fn attach_mesh(&mut self, id: usize, mesh: &Arc<TriangleMesh>, filtered: bool) -> Result<()> {
        let shape = Shape::mesh(&self.device, mesh, filtered)?;
        self.filtered |= filtered;
        self.attach(id, shape)
    }

    /// Attaches an instance whose hits have the object index `id`; `filtered` as for the shapes in `scene`.
    pub(super) fn attach_instance(
        &mut self,
        id: usize,
        scene: &Arc<Committed>,
        m: &Affine3A,
        filtered: bool,
    ) -> Result<()> {
        let shape = Shape::instance(&self.device, scene, m)?;
        self.filtered |= filtered;
        self.attach(id, shape)
    }

    fn attach(&mut self, id: usize, shape: Shape) -> Result<()> {
        let id = u32::try_from(id).ok().filter(|&id| id != RTC_INVALID_GEOMETRY_ID);
        let id = id.ok_or_else(|| Error::new(Kind::Memory, "the scene has more than 2^32 - 1 objects"))?;
        // SAFETY: both handles are live and of one device; the scene keeps a reference.
        unsafe { rtcAttachGeometryByID(self.handle.0, shape.raw(), id) };
        self.shapes.push(shape);
        self.device.check("attach a geometry")
    }

    /// Builds the acceleration structure; nothing can be attached afterwards.
    pub(super) fn commit(self, build: Build) -> Result<Committed> {
        let (mut flags, quality) = effort(build);
        if self.filtered {
            flags |= RTCSceneFlags::RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;
        }
        // SAFETY: the scene is live and this is its only user.
        unsafe { rtcSetSceneFlags(self.handle.0, flags) };
        // SAFETY: as above.
        unsafe { rtcSetSceneBuildQuality(self.handle.0, quality) };
        // SAFETY: as above; every attached geometry is committed and holds what it points to.
        unsafe { rtcCommitScene(self.handle.0) };
        self.device.check("build the acceleration structure")?;
        Ok(Committed { handle: self.handle, _shapes: self.shapes })
    }
}

fn effort(build: Build) -> (RTCSceneFlags, RTCBuildQuality) {
    let robust = RTCSceneFlags::RTC_SCENE_FLAG_ROBUST;
    let medium = RTCBuildQuality::RTC_BUILD_QUALITY_MEDIUM;
    match build {
        Build::Fast => (RTCSceneFlags::RTC_SCENE_FLAG_NONE, medium),
        Build::Robust => (robust, medium),
        Build::Compact => (robust | RTCSceneFlags::RTC_SCENE_FLAG_COMPACT, medium),
        Build::High => (robust, RTCBuildQuality::RTC_BUILD_QUALITY_HIGH),
    }
}

/// A committed scene, immutable from here on, with everything that Embree points to.
pub(super) struct Committed {
    // Released before the shapes, and these before the meshes that they point to.
    handle: Handle,
    _shapes: Vec<Shape>,
}

impl Committed {
    pub(super) fn raw(&self) -> RTCScene {
        self.handle.0
    }

    /// Writes the closest hit that `filter` accepts into `query`.
    #[inline]
    pub(super) fn intersect<A: AnyHit>(&self, query: &mut RTCRayHit, filter: Option<&mut Filter<'_, A>>) {
        let Some(filter) = filter else {
            // SAFETY: the scene is committed, the query is laid out and aligned as Embree's headers say; null is the
            // default.
            return unsafe { rtcIntersect1(self.handle.0, query, ptr::null_mut()) };
        };
        let mut arguments = RTCIntersectArguments {
            flags: RTCRayQueryFlags::RTC_RAY_QUERY_FLAG_INCOHERENT,
            feature_mask: RTCFeatureFlags::RTC_FEATURE_FLAG_ALL,
            context: filter.context(),
            filter: Filter::<A>::CALLBACK,
            intersect: None,
        };
        // SAFETY: as above; the context is that of a `Filter<A>` that outlives the call, as the callback requires.
        unsafe { rtcIntersect1(self.handle.0, query, &raw mut arguments) }
    }

    /// Sets the last parameter of `query` to −∞ if there is a hit that `filter` accepts.
    #[inline]
    pub(super) fn occluded<A: AnyHit>(&self, query: &mut RTCRay, filter: Option<&mut Filter<'_, A>>) {
        let Some(filter) = filter else {
            // SAFETY: the scene is committed, the query is laid out and aligned as Embree's headers say; null is the
            // default.
            return unsafe { rtcOccluded1(self.handle.0, query, ptr::null_mut()) };
        };
        let mut arguments = RTCOccludedArguments {
            flags: RTCRayQueryFlags::RTC_RAY_QUERY_FLAG_INCOHERENT,
            feature_mask: RTCFeatureFlags::RTC_FEATURE_FLAG_ALL,
            context: filter.context(),
            filter: Filter::<A>::CALLBACK,
            occluded: None,
        };
        // SAFETY: as above; the context is that of a `Filter<A>` that outlives the call, as the callback requires.
        unsafe { rtcOccluded1(self.handle.0, query, &raw mut arguments) }
    }
}
