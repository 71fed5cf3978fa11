//! Which primitive does a ray hit: one trait, one enum of backends. To add a backend, write one file that implements
//! [`Intersector`] and give it a variant in [`Accel`].

#[cfg(feature = "embree")]
pub mod embree;

use crate::error::Result;
use crate::geometry::{AnyHit, Bounds, Geometry, Hit, Ray};

/// Ray queries against committed geometry.
pub trait Intersector: Send + Sync {
    /// The first hit along the ray that `any` accepts.
    fn closest(&self, ray: &Ray, any: &impl AnyHit) -> Option<Hit>;
    /// Whether anything that `any` accepts is hit at all.
    fn occluded(&self, ray: &Ray, any: &impl AnyHit) -> bool;
    /// The box around everything.
    fn bounds(&self) -> Bounds;
}

/// How much effort goes into the acceleration structure, and what it is tuned for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
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

/// The backend in use. The match costs nothing that could be measured beside a ray query.
pub enum Accel {
    /// Intel Embree 4.
    #[cfg(feature = "embree")]
    Embree(embree::Scene),
}

impl Accel {
    /// Builds the default backend over `geometry` with `threads` threads. Call it from outside the rayon pool.
    ///
    /// # Errors
    /// What the backend reports: no device, too little memory.
    pub fn build(geometry: &Geometry, build: Build, threads: usize) -> Result<Accel> {
        #[cfg(feature = "embree")]
        return Ok(Accel::Embree(embree::Scene::build(geometry, build, threads)?));
        #[cfg(not(feature = "embree"))]
        {
            let _ = (geometry, build, threads);
            Err(crate::error::Error::usage("this étendue was built without a ray-tracing backend"))
        }
    }

    /// Bytes that the acceleration structure takes, as far as the backend tells.
    pub fn bytes(&self) -> usize {
        match *self {
            #[cfg(feature = "embree")]
            Accel::Embree(ref scene) => scene.bytes(),
        }
    }

    /// The backend's name, as reports show it.
    pub fn name(&self) -> &'static str {
        match *self {
            #[cfg(feature = "embree")]
            Accel::Embree(_) => "embree",
        }
    }
}

// Without a backend the enum is empty and no argument is looked at.
#[cfg_attr(not(feature = "embree"), allow(unused_variables))]
impl Intersector for Accel {
    #[inline]
    fn closest(&self, ray: &Ray, any: &impl AnyHit) -> Option<Hit> {
        match *self {
            #[cfg(feature = "embree")]
            Accel::Embree(ref scene) => scene.closest(ray, any),
        }
    }

    #[inline]
    fn occluded(&self, ray: &Ray, any: &impl AnyHit) -> bool {
        match *self {
            #[cfg(feature = "embree")]
            Accel::Embree(ref scene) => scene.occluded(ray, any),
        }
    }

    fn bounds(&self) -> Bounds {
        match *self {
            #[cfg(feature = "embree")]
            Accel::Embree(ref scene) => scene.bounds(),
        }
    }
}
