//! Embree scenes under construction: shapes are attached, then the scene is committed.

use super::device::Device;
use super::geometry::{Committed, SceneHandle, Shape};
use crate::accel::Build;
use crate::error::{Error, Kind, Result};
use crate::geometry::TriangleMesh;
use embree4_sys::{
    RTC_INVALID_GEOMETRY_ID, RTCBuildQuality, RTCSceneFlags, rtcAttachGeometryByID, rtcCommitScene, rtcNewScene,
    rtcSetSceneBuildQuality, rtcSetSceneFlags,
};
use glam::Affine3A;
use std::sync::Arc;

/// A scene under construction.
pub(super) struct SceneBuilder {
    handle: SceneHandle,
    shapes: Vec<Shape>,
    filtered: bool,
    device: Arc<Device>,
}

impl SceneBuilder {
    /// Returns an empty scene.
    pub(super) fn new(device: &Arc<Device>) -> Result<Self> {
        // SAFETY: the device is live.
        let handle = SceneHandle(unsafe { rtcNewScene(device.raw()) });
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
        Ok(Committed::new(self.handle, self.shapes))
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
