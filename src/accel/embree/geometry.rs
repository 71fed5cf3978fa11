//! Geometries and committed scenes. A geometry is a triangle mesh or an instance of a scene, and a scene has
//! geometries.

use super::device::Device;
use super::filter::Filter;
use crate::error::Result;
use crate::geometry::{AnyHit, Ray, TriangleMesh};
use embree4_sys::{
    RTCBufferType, RTCFeatureFlags, RTCFormat, RTCGeometry, RTCGeometryType, RTCIntersectArguments,
    RTCOccludedArguments, RTCRay, RTCRayHit, RTCRayQueryFlags, RTCScene, rtcCommitGeometry, rtcIntersect1,
    rtcNewGeometry, rtcOccluded1, rtcReleaseGeometry, rtcReleaseScene, rtcSetGeometryEnableFilterFunctionFromArguments,
    rtcSetGeometryInstancedScene, rtcSetGeometryTransform, rtcSetSharedGeometryBuffer,
};
use glam::{Affine3A, Vec3};
use std::ptr;
use std::sync::Arc;

// Strides passed to Embree.
const _: () = assert!(size_of::<Vec3>() == 12 && size_of::<[u32; 3]>() == 12);

/// An Embree geometry with the data that it points to.
pub(super) struct Shape {
    raw: RTCGeometry,
    _source: Source,
}

/// Held by a shape only to keep it alive. Embree counts references to an instanced scene, but not to the meshes in it.
#[expect(dead_code, reason = "held for its lifetime")]
enum Source {
    Mesh(Arc<TriangleMesh>),
    EmbreeScene(Arc<Committed>),
}

// SAFETY: a shape is only changed before it is attached, by the thread that makes it; afterwards it is only released,
// and Embree counts references atomically.
unsafe impl Send for Shape {}
// SAFETY: no method of a shared shape changes it.
unsafe impl Sync for Shape {}

impl Shape {
    /// Returns a shape that reads the arrays of `mesh`; queries call their filter for it if it is `filtered`.
    pub(super) fn mesh(device: &Device, mesh: &Arc<TriangleMesh>, filtered: bool) -> Result<Shape> {
        let shape = Shape::new(device, RTCGeometryType::RTC_GEOMETRY_TYPE_TRIANGLE, Source::Mesh(Arc::clone(mesh)))?;
        // Embree reads 16 bytes at each position, and the padding is what follows the last.
        let positions = &mesh.padded_positions()[..mesh.positions().len()];
        // SAFETY: a `Vec3` is three f32; the shape holds the mesh, which never changes and is padded.
        unsafe { shape.share(RTCBufferType::RTC_BUFFER_TYPE_VERTEX, RTCFormat::RTC_FORMAT_FLOAT3, positions) };
        // SAFETY: a triangle is three u32 below the number of positions, which `TriangleMesh::new` checks.
        unsafe { shape.share(RTCBufferType::RTC_BUFFER_TYPE_INDEX, RTCFormat::RTC_FORMAT_UINT3, mesh.triangles()) };
        // SAFETY: the geometry is live and not yet attached.
        unsafe { rtcSetGeometryEnableFilterFunctionFromArguments(shape.raw, filtered) };
        shape.committed(device)
    }

    /// Returns an instance of `scene` at `placement`.
    pub(super) fn instance(device: &Device, scene: &Arc<Committed>, placement: &Affine3A) -> Result<Shape> {
        let shape =
            Shape::new(device, RTCGeometryType::RTC_GEOMETRY_TYPE_INSTANCE, Source::EmbreeScene(Arc::clone(scene)))?;
        // SAFETY: both handles are live, and the shape holds the scene.
        unsafe { rtcSetGeometryInstancedScene(shape.raw, scene.raw()) };
        let columns: [f32; 12] = placement.to_cols_array();
        // SAFETY: Embree copies four columns of three f32.
        unsafe {
            rtcSetGeometryTransform(shape.raw, 0, RTCFormat::RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.as_ptr().cast());
        }
        shape.committed(device)
    }

    pub(super) fn raw(&self) -> RTCGeometry {
        self.raw
    }

    fn new(device: &Device, kind: RTCGeometryType, source: Source) -> Result<Shape> {
        // SAFETY: the device is live.
        let raw = unsafe { rtcNewGeometry(device.raw(), kind) };
        let shape = Shape { raw, _source: source };
        device.check("make a geometry")?;
        Ok(shape)
    }

    /// Lets Embree read `elements` in place.
    ///
    /// # Safety
    /// `format` describes `T`; the elements neither move nor change while the shape lives, and 16 bytes may be read at
    /// each.
    unsafe fn share<T>(&self, buffer: RTCBufferType, format: RTCFormat, elements: &[T]) {
        let (start, stride) = (elements.as_ptr().cast(), size_of::<T>());
        // SAFETY: the geometry is live; the caller answers for the elements.
        unsafe { rtcSetSharedGeometryBuffer(self.raw, buffer, 0, format, start, 0, stride, elements.len()) };
    }

    fn committed(self, device: &Device) -> Result<Shape> {
        // SAFETY: the geometry is live and complete.
        unsafe { rtcCommitGeometry(self.raw) };
        device.check("set up a geometry")?;
        Ok(self)
    }
}

impl Drop for Shape {
    fn drop(&mut self) {
        // SAFETY: this is the reference that `new` got (Embree ignores null with an error code); it is released once.
        unsafe { rtcReleaseGeometry(self.raw) };
    }
}

/// A reference to an Embree scene.
pub(super) struct SceneHandle(pub(super) RTCScene);

// SAFETY: Embree's manual allows queries of a committed scene from any thread; only the builder of a scene, which has
// the sole handle, changes one, and references are counted atomically.
unsafe impl Send for SceneHandle {}
// SAFETY: as above; nothing changes a scene through a shared handle.
unsafe impl Sync for SceneHandle {}

impl Drop for SceneHandle {
    fn drop(&mut self) {
        // SAFETY: this is the reference that `rtcNewScene` gave, and it is released once.
        unsafe { rtcReleaseScene(self.0) };
    }
}

/// A committed scene, immutable from here on, with everything that Embree points to.
pub(super) struct Committed {
    // Released before the shapes, and these before the meshes that they point to.
    handle: SceneHandle,
    _shapes: Vec<Shape>,
}

impl Committed {
    /// A scene that Embree has committed, and the shapes attached to it.
    pub(super) fn new(handle: SceneHandle, shapes: Vec<Shape>) -> Self {
        Committed { handle, _shapes: shapes }
    }

    pub(super) fn raw(&self) -> RTCScene {
        self.handle.0
    }

    /// Writes the closest hit that `filter` accepts into `query`.
    #[inline]
    pub(super) fn intersect<A: AnyHit>(&self, query: &mut RTCRayHit, filter: Option<&mut Filter<'_, A, Ray>>) {
        let Some(filter) = filter else {
            // SAFETY: the scene is committed, the query is laid out and aligned as Embree's headers say; null is the
            // default.
            return unsafe { rtcIntersect1(self.handle.0, query, ptr::null_mut()) };
        };
        let mut arguments = RTCIntersectArguments {
            flags: RTCRayQueryFlags::RTC_RAY_QUERY_FLAG_INCOHERENT,
            feature_mask: RTCFeatureFlags::RTC_FEATURE_FLAG_ALL,
            context: filter.context(),
            filter: Filter::<A, Ray>::CALLBACK,
            intersect: None,
        };
        // SAFETY: as above; the context is that of a `Filter<A, Ray>` that outlives the call, as the callback requires.
        unsafe { rtcIntersect1(self.handle.0, query, &raw mut arguments) }
    }

    /// Sets the last parameter of `query` to −∞ if there is a hit that `filter` accepts.
    #[inline]
    pub(super) fn occluded<A: AnyHit>(&self, query: &mut RTCRay, filter: Option<&mut Filter<'_, A, Ray>>) {
        let Some(filter) = filter else {
            // SAFETY: the scene is committed, the query is laid out and aligned as Embree's headers say; null is the
            // default.
            return unsafe { rtcOccluded1(self.handle.0, query, ptr::null_mut()) };
        };
        let mut arguments = RTCOccludedArguments {
            flags: RTCRayQueryFlags::RTC_RAY_QUERY_FLAG_INCOHERENT,
            feature_mask: RTCFeatureFlags::RTC_FEATURE_FLAG_ALL,
            context: filter.context(),
            filter: Filter::<A, Ray>::CALLBACK,
            occluded: None,
        };
        // SAFETY: as above; the context is that of a `Filter<A, Ray>` that outlives the call, as the callback requires.
        unsafe { rtcOccluded1(self.handle.0, query, &raw mut arguments) }
    }
}
