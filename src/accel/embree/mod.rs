//! The Embree 4 backend: packets as wide as the registers, watertight across edges with every [`Build`] but
//! `Fast`.
//!
//! Objects without a placement are in the top scene; placed ones are instances of one scene per mesh. In both cases an
//! object's index in [`Geometry`] is its Embree geometry id in the top scene, so that hits need no lookup table. Embree
//! reads the meshes' own arrays, which the scene keeps alive.
//!
//! Limits: no motion blur; a ray's time is passed on but has no effect. Rays that graze edges may give different hits
//! on different instruction sets. As measured, directions shorter than 1e-15 lose hits, and components above 1e38 lose
//! some hits and create false ones. The floating-point environment is unchanged (FTZ and DAZ off). Reference: Embree's
//! manual.

// The only unsafe code of this crate: calls into a C library, each with the fact that makes it sound.
#![allow(unsafe_code)]

mod device;
mod error;
mod filter;
mod geometry;
mod packet;
mod ray;
mod scene;

use crate::accel::{Build, Coherence, Intersector, Packet, closest_of_each, occluded_of_each, placed};
use crate::error::Result;
use crate::geometry::{AnyHit, Geometry, Hit, Hits, Ray, Rays};
use filter::{Filter, Source};
use geometry::Committed;
use scene::SceneBuilder;
use std::sync::Arc;

pub use device::Device;

/// Committed geometry under Embree. It is immutable, so that any number of threads may query it.
pub struct EmbreeScene {
    top: Committed,
    /// By object: whether the filter applies.
    filtered: Box<[bool]>,
    any_filtered: bool,
    packet: Packet,
    device: Arc<Device>,
}

impl EmbreeScene {
    /// Builds acceleration structures over `geometry` with `threads` threads (0: all available). Embree has its own
    /// threads: call it from outside the rayon pool.
    ///
    /// # Errors
    /// A scene error if an object has a singular placement or exceeds ±1.8e18; a memory error; an internal error if an
    /// object refers to a missing mesh or Embree's version does not match the bindings.
    pub fn build(geometry: &Geometry, build: Build, threads: usize) -> Result<EmbreeScene> {
        let device = Arc::new(Device::new(threads)?);
        let mut top = SceneBuilder::new(&device)?;
        let mut prototypes = vec![None; geometry.meshes.len()];
        placed::bounds(geometry)?; // refuses what is out of range
        for (index, object) in geometry.objects.iter().enumerate() {
            let mesh = placed::mesh(geometry, index)?;
            let Some(placement) = &object.placement else {
                top.attach_mesh(index, mesh, object.filtered)?;
                continue;
            };
            let prototype = &mut prototypes[object.mesh as usize];
            let instanced = match prototype {
                Some(instanced) => instanced,
                None => prototype.insert(prototype_of(geometry, object.mesh, &device, build)?),
            };
            top.attach_instance(index, instanced, placement, object.filtered)?;
        }
        let filtered: Box<[bool]> = geometry.objects.iter().map(|object| object.filtered).collect();
        let any_filtered = filtered.contains(&true);
        let packet = device.packets().last().copied().unwrap_or(Packet::One);
        Ok(EmbreeScene { top: top.commit(build)?, filtered, any_filtered, packet, device })
    }

    /// Returns the memory of Embree's acceleration structures in bytes, without the meshes.
    pub fn bytes(&self) -> usize {
        self.device.bytes()
    }

    /// Returns Embree's version at run time, such as `4.3.3`.
    pub fn version(&self) -> String {
        self.device.version()
    }

    /// Returns the widths of packets for which the processor has registers, the widest last.
    pub fn packets(&self) -> &'static [Packet] {
        self.device.packets()
    }

    /// Sets the width of packets, for tests and measurements; at first it is the widest of [`Self::packets`]. Packets
    /// that are wider than the registers are slow.
    pub fn set_packet(&mut self, packet: Packet) {
        self.packet = packet;
    }

    /// Returns the filter of a query; `None` if it has no effect.
    #[inline]
    fn filter<'a, A: AnyHit, S: Source>(&'a self, rays: &'a S, any: &'a A) -> Option<Filter<'a, A, S>> {
        (A::FILTERS && self.any_filtered).then(|| Filter::new(rays, any, &self.filtered))
    }
}

/// Returns the version of the library found by the loader.
///
/// # Errors
/// If the library cannot be used.
pub fn version() -> Result<String> {
    Ok(Device::new(1)?.version())
}

impl Intersector for EmbreeScene {
    /// Embree requires `ray.t_min` ≥ 0. The answer for a ray that is not finite or has no direction is unspecified.
    #[inline]
    fn closest(&self, ray: &Ray, any: &impl AnyHit) -> Option<Hit> {
        let mut query = ray::query(ray);
        let mut filter = self.filter(ray, any);
        self.top.intersect(&mut query, filter.as_mut());
        filter::resume_panic(filter);
        ray::hit(&query.hit)
    }

    /// As for `closest`.
    #[inline]
    fn occluded(&self, ray: &Ray, any: &impl AnyHit) -> bool {
        let mut query = ray::query(ray).ray;
        let mut filter = self.filter(ray, any);
        self.top.occluded(&mut query, filter.as_mut());
        filter::resume_panic(filter);
        // Embree marks an occluded ray by a last parameter of −∞.
        query.tfar < ray.t_max
    }

    /// Rays go in packets as wide as the processor's registers.
    fn closest_all(&self, rays: &Rays, coherence: Coherence, any: &impl AnyHit, hits: &mut Hits) {
        let filter = self.filter(rays, any);
        let alone = |at: usize| self.closest(&rays.ray(at), any);
        match self.packet {
            Packet::Sixteen => packet::closest16(&self.top, rays, coherence, filter, alone, hits),
            Packet::Eight => packet::closest8(&self.top, rays, coherence, filter, alone, hits),
            Packet::One => closest_of_each(self, rays, any, hits),
        }
    }

    /// As for `closest_all`.
    fn occluded_all(&self, rays: &Rays, coherence: Coherence, any: &impl AnyHit, occluded: &mut [bool]) {
        let filter = self.filter(rays, any);
        match self.packet {
            Packet::Sixteen => packet::occluded16(&self.top, rays, coherence, filter, occluded),
            Packet::Eight => packet::occluded8(&self.top, rays, coherence, filter, occluded),
            Packet::One => occluded_of_each(self, rays, any, occluded),
        }
    }
}

/// Returns the scene that is instanced by every placed object of mesh `index`.
fn prototype_of(geometry: &Geometry, index: u32, device: &Arc<Device>, build: Build) -> Result<Arc<Committed>> {
    let mut placed = geometry.objects.iter().filter(|object| object.mesh == index && object.placement.is_some());
    let mut scene = SceneBuilder::new(device)?;
    scene.attach_mesh(0, &geometry.meshes[index as usize], placed.any(|object| object.filtered))?;
    Ok(Arc::new(scene.commit(build)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Attributes, Object, Opaque, TriangleMesh};
    use glam::{Affine3A, Vec3};

    #[test]
    fn a_dropped_scene_gives_everything_back() {
        let triangle =
            TriangleMesh::new("t", vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]], Attributes::default());
        let mesh = Arc::new(triangle.expect("valid"));
        let object = |placement| Object { mesh: 0, placement, filtered: true };
        let placed = object(Some(Affine3A::from_translation(Vec3::Z)));
        let objects = vec![object(None), placed.clone(), placed];
        let geometry = Geometry { meshes: vec![Arc::clone(&mesh)], objects };
        let scene = EmbreeScene::build(&geometry, Build::Robust, 1).expect("builds");
        drop(geometry);
        assert!(scene.occluded(&Ray::new(Vec3::new(0.2, 0.2, 2.0), Vec3::NEG_Z), &Opaque), "it keeps what it reads");
        assert!(scene.bytes() > 0 && Arc::strong_count(&mesh) > 1);
        let device = Arc::clone(&scene.device);
        drop(scene);
        assert_eq!((device.bytes(), Arc::strong_count(&mesh), Arc::strong_count(&device)), (0, 1, 1));
    }
}
