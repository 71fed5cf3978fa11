//! Ray intersection: one trait, one enum of backends. To add a backend, implement [`Intersector`] in a new file, and
//! add a variant to [`Backend`] and to [`Accel`]. An intersector of the caller's own is a [`CustomIntersector`].

pub mod bvh;
mod custom;
#[cfg(feature = "embree")]
pub mod embree;
mod packet;
mod placed;
mod ray_class;

pub use custom::{CustomIntersector, FilterFn, HitFilter};
pub use packet::Packet;
pub use ray_class::RayClass;

use crate::error::Result;
use crate::geometry::{AnyHit, Geometry, Hit, Hits, Ray, Rays};

/// Ray queries against committed geometry.
pub trait Intersector: Send + Sync {
    /// Returns the first hit along the ray that `any` accepts.
    fn closest(&self, ray: &Ray, any: &impl AnyHit) -> Option<Hit>;
    /// Returns whether the ray has any hit that `any` accepts.
    fn occluded(&self, ray: &Ray, any: &impl AnyHit) -> bool;
    /// Writes the first hits of `rays` that `any` accepts to `hits`. A backend may trace rays together.
    fn closest_all(&self, rays: &Rays, _coherence: Coherence, any: &impl AnyHit, hits: &mut Hits) {
        closest_of_each(self, rays, any, hits);
    }
    /// Writes to `occluded` which of `rays` have any hit that `any` accepts. A backend may trace rays together, and
    /// overwrite what follows.
    fn occluded_all(&self, rays: &Rays, _coherence: Coherence, any: &impl AnyHit, occluded: &mut [bool]) {
        occluded_of_each(self, rays, any, occluded);
    }
}

/// [`Intersector::closest_all`] ray by ray.
fn closest_of_each(of: &(impl Intersector + ?Sized), rays: &Rays, any: &impl AnyHit, hits: &mut Hits) {
    (0..rays.len()).for_each(|at| hits.set(at, of.closest(&rays.ray(at), any)));
}

/// [`Intersector::occluded_all`] ray by ray.
fn occluded_of_each(of: &(impl Intersector + ?Sized), rays: &Rays, any: &impl AnyHit, occluded: &mut [bool]) {
    (0..rays.len()).for_each(|at| occluded[at] = of.occluded(&rays.ray(at), any));
}

/// Whether consecutive rays of a batch take similar ways: a hint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coherence {
    /// Camera rays, in a scene that the caches hold.
    Coherent,
    /// All others.
    Incoherent,
}

/// Build quality of the acceleration structure.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Default,
    Hash,
    serde::Serialize,
    serde::Deserialize,
    strum::VariantArray,
    strum::IntoStaticStr,
    strum::EnumMessage,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Build {
    /// Fastest queries and builds; edges may leak.
    Fast,
    /// Watertight edges.
    #[default]
    Robust,
    /// Watertight edges, least memory.
    Compact,
    /// Watertight edges, slow build with spatial splits, fast queries.
    High,
}

/// Intersection backend.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    serde::Serialize,
    serde::Deserialize,
    strum::VariantArray,
    strum::IntoStaticStr,
    strum::EnumMessage,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Backend {
    /// Intel Embree 4, the fastest for `path`, whose rays go in packets.
    Embree,
    /// Pure Rust: trees built by obvhs; the fastest for `bdpt` and chains, whose rays go one by one.
    Obvhs,
}

impl Backend {
    /// Backends compiled into this program, the default first.
    pub const AVAILABLE: &[Backend] =
        if cfg!(feature = "embree") { &[Backend::Embree, Backend::Obvhs] } else { &[Backend::Obvhs] };

    /// Returns the memory per triangle in bytes during construction, measured with two million triangles and rounded
    /// up.
    pub fn building_bytes(self) -> u64 {
        match self {
            Backend::Embree => 150,
            Backend::Obvhs => 450,
        }
    }
}

/// Returns the version of the Embree library found by the loader; `None` if the program was built without Embree.
///
/// # Errors
/// (inside) The cause, if the Embree library cannot be used.
pub fn embree_version() -> Option<Result<String>> {
    #[cfg(feature = "embree")]
    let version = Some(embree::version());
    #[cfg(not(feature = "embree"))]
    let version = None;
    version
}

impl Default for Backend {
    fn default() -> Self {
        Backend::AVAILABLE[0]
    }
}

/// The backend in use. The cost of the match is not measurable next to a ray query.
pub enum Accel {
    /// Intel Embree 4.
    #[cfg(feature = "embree")]
    Embree(embree::EmbreeScene),
    /// Pure Rust.
    Obvhs(bvh::BvhScene),
    /// The caller's own.
    Custom(Box<dyn CustomIntersector>),
}

impl Accel {
    /// Builds `backend` over `geometry` with `threads` threads. Must be called from outside the rayon pool.
    ///
    /// # Errors
    /// A usage error for a backend that is not compiled in. Errors of the backend: no device, too little memory,
    /// geometry beyond its range.
    pub fn build(geometry: &Geometry, backend: Backend, build: Build, threads: usize) -> Result<Accel> {
        match backend {
            #[cfg(feature = "embree")]
            Backend::Embree => Ok(Accel::Embree(embree::EmbreeScene::build(geometry, build, threads)?)),
            #[cfg(not(feature = "embree"))]
            Backend::Embree => {
                let _ = threads;
                Err(crate::error::Error::usage("this étendue was built without Embree: use --backend obvhs"))
            }
            Backend::Obvhs => Ok(Accel::Obvhs(bvh::BvhScene::build(geometry, build)?)),
        }
    }

    /// Returns the memory of the acceleration structure in bytes, as reported by the backend.
    pub fn bytes(&self) -> usize {
        match self {
            #[cfg(feature = "embree")]
            Accel::Embree(scene) => scene.bytes(),
            Accel::Obvhs(scene) => scene.bytes(),
            Accel::Custom(custom) => custom.bytes(),
        }
    }

    /// Returns the type of the backend.
    pub fn backend(&self) -> Backend {
        match self {
            #[cfg(feature = "embree")]
            Accel::Embree(_) => Backend::Embree,
            Accel::Obvhs(_) => Backend::Obvhs,
            Accel::Custom(custom) => custom.backend(),
        }
    }

    /// Returns the widths of packets for which the backend and the processor are made, the widest last; none for a
    /// backend without packets.
    pub fn packets(&self) -> &'static [Packet] {
        match self {
            #[cfg(feature = "embree")]
            Accel::Embree(scene) => scene.packets(),
            Accel::Obvhs(_) | Accel::Custom(_) => &[],
        }
    }

    /// Sets the width of packets, for tests and measurements. A backend without packets ignores it.
    pub fn set_packet(&mut self, packet: Packet) {
        match self {
            #[cfg(feature = "embree")]
            Accel::Embree(scene) => scene.set_packet(packet),
            Accel::Obvhs(_) | Accel::Custom(_) => _ = packet,
        }
    }

    /// Tells an intersector of the caller's own the class of this thread's next rays.
    #[inline]
    pub fn announce(&self, class: RayClass) {
        if let Accel::Custom(custom) = self {
            custom.announce(class);
        }
    }
}

impl Intersector for Accel {
    #[inline]
    fn closest(&self, ray: &Ray, any: &impl AnyHit) -> Option<Hit> {
        match self {
            #[cfg(feature = "embree")]
            Accel::Embree(scene) => scene.closest(ray, any),
            Accel::Obvhs(scene) => scene.closest(ray, any),
            Accel::Custom(scene) => custom::with_filter(any, |filter| scene.closest(ray, filter)),
        }
    }

    #[inline]
    fn occluded(&self, ray: &Ray, any: &impl AnyHit) -> bool {
        match self {
            #[cfg(feature = "embree")]
            Accel::Embree(scene) => scene.occluded(ray, any),
            Accel::Obvhs(scene) => scene.occluded(ray, any),
            Accel::Custom(scene) => custom::with_filter(any, |filter| scene.occluded(ray, filter)),
        }
    }

    fn closest_all(&self, rays: &Rays, coherence: Coherence, any: &impl AnyHit, hits: &mut Hits) {
        match self {
            #[cfg(feature = "embree")]
            Accel::Embree(scene) => scene.closest_all(rays, coherence, any, hits),
            Accel::Obvhs(scene) => scene.closest_all(rays, coherence, any, hits),
            Accel::Custom(_) => closest_of_each(self, rays, any, hits),
        }
    }

    fn occluded_all(&self, rays: &Rays, coherence: Coherence, any: &impl AnyHit, occluded: &mut [bool]) {
        match self {
            #[cfg(feature = "embree")]
            Accel::Embree(scene) => scene.occluded_all(rays, coherence, any, occluded),
            Accel::Obvhs(scene) => scene.occluded_all(rays, coherence, any, occluded),
            Accel::Custom(_) => occluded_of_each(self, rays, any, occluded),
        }
    }
}
