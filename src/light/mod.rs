//! Lights. One kind a file; to add one, write it and give it a variant in [`Light`].
//!
//! Every light answers the same two questions for a point that it may illuminate: sample a direction toward yourself, and
//! with which density would you have sampled this one. Which light is asked is [`Lights`]'s choice.

mod area;
mod choose;
mod emit;
mod environment;
mod lat_long;
mod punctual;
mod sky;

pub use area::{AreaLight, Coverage, Emission};
pub use choose::Lights;
pub use emit::{Ball, EmissionDensity, EmissionNumbers, Emitted};
pub use environment::Environment;
pub use lat_long::LatLong;
pub use punctual::{DirectionalLight, PointLight, SpotLight};
pub use sky::Sky;

use crate::geometry::{Hit, SurfacePoint};
use crate::sampling::Density;
use crate::spectrum::Spectrum;
use glam::Vec3;

/// A point that light may fall on, as far as the choice of a light may look at it.
#[derive(Debug, Clone, Copy)]
pub struct Receiver {
    /// Position.
    pub p: Vec3,
    /// Geometric normal.
    pub ng: Vec3,
}

impl From<&SurfacePoint> for Receiver {
    #[inline]
    fn from(point: &SurfacePoint) -> Self {
        Receiver { p: point.p, ng: point.ng }
    }
}

/// Where the segment to a light ends.
#[derive(Debug, Clone, Copy)]
pub enum End {
    /// At a point on a surface with geometric normal `ng`, known within `error`.
    Surface {
        /// The point.
        p: Vec3,
        /// See [`crate::geometry::Triangle::point`].
        error: f32,
        /// Its unit normal.
        ng: Vec3,
        /// Its primitive, if another one touches it; [`Hit::NONE`] otherwise.
        touched: Hit,
    },
    /// At a point in space.
    Point(Vec3),
    /// Nowhere: outside the scene.
    Infinity,
}

/// A direction toward a light.
#[derive(Debug, Clone, Copy)]
pub struct LightSample {
    /// Unit direction from the illuminated point to the light.
    pub wi: Vec3,
    /// Smooth: radiance along `wi`. Dirac: irradiance on a surface perpendicular to it.
    pub radiance: Spectrum,
    /// Density of `wi` for this light; Dirac lights have probability 1.
    pub density: Density,
    /// The other end of the segment that must be free.
    pub end: End,
}

/// A light source.
#[derive(Debug)]
pub enum Light {
    /// A point.
    Point(PointLight),
    /// A cone from a point.
    Spot(SpotLight),
    /// Parallel light from infinity.
    Directional(DirectionalLight),
    /// An emitting triangle.
    Area(AreaLight),
    /// What surrounds the scene.
    Environment(Environment),
}

impl Light {
    /// A direction from `at` toward this light; `None` if it cannot illuminate `at` that way.
    #[inline]
    pub fn sample_toward(&self, at: &Receiver, u: [f32; 2]) -> Option<LightSample> {
        match self {
            Light::Point(light) => light.sample_toward(at.p),
            Light::Spot(light) => light.sample_toward(at.p),
            Light::Directional(light) => Some(light.sample()),
            Light::Area(light) => light.sample_toward(at.p, u),
            Light::Environment(light) => light.sample(u),
        }
    }

    /// Power in watts (mean over the lanes) that it sends into a scene of bounding radius `radius`.
    pub fn power(&self, radius: f32) -> f64 {
        match self {
            Light::Point(light) => light.power(),
            Light::Spot(light) => light.power(),
            Light::Directional(light) => light.power(radius),
            Light::Area(light) => light.power(),
            Light::Environment(light) => light.power(radius),
        }
    }

    /// The largest radiance (mean over the lanes) that a ray finds on it, by magnitude; `None` where none can find it.
    pub fn largest_radiance(&self) -> Option<f64> {
        match self {
            Light::Area(light) => (!light.is_only_seen()).then(|| light.largest_radiance()),
            Light::Environment(light) => Some(light.largest_radiance()),
            Light::Point(_) | Light::Spot(_) | Light::Directional(_) => None,
        }
    }

    /// Whether it is seen and lights nothing.
    #[inline]
    pub fn is_only_seen(&self) -> bool {
        matches!(self, Light::Area(light) if light.is_only_seen())
    }

    /// Whether a scattered ray can never find it.
    pub fn is_dirac(&self) -> bool {
        matches!(self, Light::Point(_) | Light::Spot(_) | Light::Directional(_))
    }
}
