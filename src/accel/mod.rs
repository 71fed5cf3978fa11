//! Which primitive does a ray hit: one trait, one enum of backends. To add a backend, write one file that implements
//! [`Intersector`] and give it a variant in [`Backend`] and in [`Accel`].

pub mod bvh;
#[cfg(feature = "embree")]
pub mod embree;
pub mod equivalence;
pub mod hard_cases;
mod placed;
mod ray_class;
mod recorder;

pub use ray_class::RayClass;
pub use recorder::{Query, Question, Recorder};

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

/// Whose ray queries are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Backend {
    /// Intel Embree 4, the fastest.
    Embree,
    /// Pure Rust: trees built by obvhs.
    Obvhs,
}

impl Backend {
    /// Those that this program was built with, the default first.
    pub const AVAILABLE: &[Backend] =
        if cfg!(feature = "embree") { &[Backend::Embree, Backend::Obvhs] } else { &[Backend::Obvhs] };

    /// Bytes that a triangle takes while the acceleration structure is built, measured with two million of them and rounded up.
    pub fn building_bytes(self) -> u64 {
        match self {
            Backend::Embree => 150,
            Backend::Obvhs => 450,
        }
    }

    /// Its name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Backend::Embree => "embree",
            Backend::Obvhs => "obvhs",
        }
    }
}

/// The version of Embree that the loader found; `None` where the program was built without it.
///
/// # Errors
/// (inside) An Embree that this program cannot use, and why.
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

/// The backend in use. The match costs nothing that could be measured beside a ray query.
pub enum Accel {
    /// Intel Embree 4.
    #[cfg(feature = "embree")]
    Embree(embree::Scene),
    /// Pure Rust.
    Obvhs(bvh::Scene),
    /// One of them, with its questions noted.
    Recorded(Box<Recorder<Accel>>),
}

impl Accel {
    /// Builds `backend` over `geometry` with `threads` threads. Call it from outside the rayon pool.
    ///
    /// # Errors
    /// A usage error for a backend that this program was built without; what the backend reports: no device, too little
    /// memory, geometry beyond its reach.
    pub fn build(geometry: &Geometry, backend: Backend, build: Build, threads: usize) -> Result<Accel> {
        match backend {
            #[cfg(feature = "embree")]
            Backend::Embree => Ok(Accel::Embree(embree::Scene::build(geometry, build, threads)?)),
            #[cfg(not(feature = "embree"))]
            Backend::Embree => {
                let _ = threads;
                Err(crate::error::Error::usage("this étendue was built without Embree: use --backend obvhs"))
            }
            Backend::Obvhs => Ok(Accel::Obvhs(bvh::Scene::build(geometry, build)?)),
        }
    }

    /// Bytes that the acceleration structure takes, as far as the backend tells.
    pub fn bytes(&self) -> usize {
        match self {
            #[cfg(feature = "embree")]
            Accel::Embree(scene) => scene.bytes(),
            Accel::Obvhs(scene) => scene.bytes(),
            Accel::Recorded(recorder) => recorder.inner().bytes(),
        }
    }

    /// Which backend it is.
    pub fn backend(&self) -> Backend {
        match self {
            #[cfg(feature = "embree")]
            Accel::Embree(_) => Backend::Embree,
            Accel::Obvhs(_) => Backend::Obvhs,
            Accel::Recorded(recorder) => recorder.inner().backend(),
        }
    }

    /// Says what the next rays are for, to a backend that notes its questions; any other does not listen.
    #[inline]
    pub fn announce(&self, class: RayClass) {
        if let Accel::Recorded(recorder) = self {
            recorder.announce(class);
        }
    }

    /// The same backend, noting what it is asked.
    #[must_use]
    pub fn recorded(self) -> Accel {
        Accel::Recorded(Box::new(Recorder::new(self)))
    }

    /// The backend that [`Accel::recorded`] was called on, and what it was asked.
    #[must_use]
    pub fn questions(self) -> (Accel, Vec<Question>) {
        match self {
            Accel::Recorded(recorder) => recorder.finish(),
            silent => (silent, Vec::new()),
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
            Accel::Recorded(recorder) => recorder.closest(ray, any),
        }
    }

    #[inline]
    fn occluded(&self, ray: &Ray, any: &impl AnyHit) -> bool {
        match self {
            #[cfg(feature = "embree")]
            Accel::Embree(scene) => scene.occluded(ray, any),
            Accel::Obvhs(scene) => scene.occluded(ray, any),
            Accel::Recorded(recorder) => recorder.occluded(ray, any),
        }
    }

    fn bounds(&self) -> Bounds {
        match self {
            #[cfg(feature = "embree")]
            Accel::Embree(scene) => scene.bounds(),
            Accel::Obvhs(scene) => scene.bounds(),
            Accel::Recorded(recorder) => recorder.bounds(),
        }
    }
}
