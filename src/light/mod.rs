//! Lights. One kind a file; to add one, write it and give it a variant in [`Light`].
//!
//! Every light implements two operations for a receiver: it samples a direction toward itself, and it evaluates the
//! density of a given direction. [`Lights`] selects the light.

mod area;
mod by_receiver;
mod choose;
mod emission;
mod emission_table;
mod emit;
mod environment;
mod lat_long;
mod light_cuts;
mod parts;
mod punctual;
mod sky;
mod solid_angle;
mod tree;

pub use area::{AreaLight, AreaLightRow, AreaLightSamples};
pub use choose::{ChosenLight, LightChoice, Lights, Receivers};
pub use emission::{Coverage, Emission};
pub use emit::{BoundingSphere, LePdf, LeRandom, LeSample};
pub use environment::Environment;
pub use lat_long::EnvironmentMap;
pub use light_cuts::LightCuts;
pub use punctual::{DirectionalLight, PointLight, SpotLight};
pub use sky::ConstantEnvironment;
pub use tree::{Cone, Cut, GroupValues, LightGroup, LightTree, Reach};

use crate::geometry::{Bounds, Hit, SurfacePoint};
use crate::sampling::Density;
use crate::spectrum::Spectrum;
use crate::transport::ScatteringOutline;
use etendue_lanes::Float;
use glam::Vec3;
use std::f64::consts::PI;

/// Receiver of light, with the data on which the selection of a light may depend.
#[derive(Debug, Clone, Copy)]
pub struct LightSampleContext {
    /// Position.
    pub p: Vec3,
    /// Geometric normal; zero in a medium.
    pub ng: Vec3,
    /// How it scatters.
    pub scattering: ScatteringOutline,
}

impl LightSampleContext {
    /// The origin, in a medium.
    const NOWHERE: LightSampleContext = LightSampleContext::new(Vec3::ZERO, Vec3::ZERO);

    /// Returns the receiver at `p` with the geometric normal `ng`, of which no more is known.
    #[inline]
    pub const fn new(p: Vec3, ng: Vec3) -> Self {
        LightSampleContext { p, ng, scattering: ScatteringOutline::UNKNOWN }
    }

    /// Returns the receiver with a known scattering.
    #[inline]
    pub fn scattering(self, scattering: ScatteringOutline) -> Self {
        LightSampleContext { scattering, ..self }
    }

    /// Returns factors of the signed cosine to the normal, of whose products the greater counts: equal ones if light
    /// arrives from one side, else of both signs.
    #[inline]
    fn sides(&self) -> [f32; 2] {
        if self.scattering.transmits {
            return [1.0, -1.0];
        }
        [1.0f32.copysign(self.scattering.wo.dot(self.ng)); 2]
    }
}

impl From<&SurfacePoint> for LightSampleContext {
    #[inline]
    fn from(point: &SurfacePoint) -> Self {
        LightSampleContext::new(point.p, point.ng)
    }
}

/// Endpoint of a segment to a light.
#[derive(Debug, Clone, Copy)]
pub enum EmitterPoint {
    /// A point on a surface with geometric normal `ng`, known within `error`.
    Surface {
        /// The point.
        p: Vec3,
        /// See [`crate::geometry::Triangle::point`].
        error: f32,
        /// Its unit normal.
        ng: Vec3,
        /// Its primitive, if in contact with another one; [`Hit::NONE`] otherwise.
        touched: Hit,
    },
    /// A point in space.
    Point(Vec3),
    /// At infinity, outside the scene.
    Distant,
}

impl From<&SurfacePoint> for EmitterPoint {
    #[inline]
    fn from(point: &SurfacePoint) -> Self {
        let SurfacePoint { p, error, ng, .. } = *point;
        EmitterPoint::Surface { p, error, ng, touched: point.touched() }
    }
}

/// A sampled direction toward a light.
#[derive(Debug, Clone, Copy)]
pub struct LightSample {
    /// Unit direction from the receiver to the light.
    pub wi: Vec3,
    /// Smooth: radiance along `wi`. Dirac: irradiance on a surface perpendicular to it.
    pub radiance: Spectrum,
    /// Density of `wi` for this light; Dirac lights have probability 1.
    pub density: Density,
    /// Endpoint of the shadow ray.
    pub end: EmitterPoint,
}

/// A direction toward the environment in each lane.
#[derive(Debug, Clone, Copy)]
pub struct EnvironmentSamples<F: Float> {
    /// Unit directions.
    pub wi: etendue_lanes::Vec3<F>,
    /// Radiance.
    pub radiance: Spectrum<F>,
    /// Densities per solid angle.
    pub pdf: F,
    /// Lanes with light.
    pub valid: F::Mask,
}

/// A light source.
#[derive(Debug)]
pub enum Light {
    /// A point light.
    Point(PointLight),
    /// A spot light.
    Spot(SpotLight),
    /// Parallel light from infinity.
    Directional(DirectionalLight),
    /// An emitting triangle.
    Area(AreaLight),
    /// The environment.
    Environment(Environment),
}

impl Light {
    /// Returns the point around which its light falls off like 1/d²; `None` at infinity, for a light that does not
    /// illuminate, and for a triangle with edges longer than a twentieth of the scene's radius.
    #[inline]
    pub fn pivot(&self) -> Option<Vec3> {
        match self {
            Light::Point(point) => Some(point.position),
            Light::Spot(spot) => Some(spot.position()),
            Light::Area(light) => light.pivot(),
            Light::Directional(_) | Light::Environment(_) => None,
        }
    }

    /// Samples a direction from `at` toward this light; `None` if the sample cannot illuminate `at`.
    #[inline]
    pub fn sample_li(&self, at: &LightSampleContext, u: [f32; 2]) -> Option<LightSample> {
        match self {
            Light::Point(light) => light.sample_li(at.p),
            Light::Spot(light) => light.sample_li(at.p),
            Light::Directional(light) => Some(light.sample()),
            Light::Area(light) => light.sample_li(at.p, u),
            Light::Environment(light) => light.sample(u),
        }
    }

    /// Returns the density of the endpoint `end`, in the direction `wi`, in [`Light::sample_li`] from `at` over that in
    /// emission sampling, [`LePdf::position`].
    #[inline]
    pub fn end_pdf_ratio(&self, at: &LightSampleContext, end: &EmitterPoint, wi: Vec3) -> f64 {
        match (self, end) {
            (Light::Area(light), EmitterPoint::Surface { p, .. }) => light.end_pdf_ratio(at.p, *p, wi),
            // Directions from infinity are sampled alike, and the others have one point.
            _ => 1.0,
        }
    }

    /// Returns the box around the points where the light's rays begin; `None` at infinity.
    pub fn bounds(&self) -> Option<Bounds> {
        match self {
            Light::Point(light) => Some(Bounds::around([light.position])),
            Light::Spot(light) => Some(Bounds::around([light.position()])),
            Light::Area(light) => Some(light.bounds()),
            Light::Directional(_) | Light::Environment(_) => None,
        }
    }

    /// Returns where it shines, for the light tree; `None` at infinity and for a light that does not illuminate.
    pub fn reach(&self) -> Option<Reach> {
        match self {
            Light::Point(light) => light.reach(),
            Light::Spot(light) => light.reach(),
            Light::Area(light) => light.reach(),
            Light::Directional(_) | Light::Environment(_) => None,
        }
    }

    /// Returns the irradiance (mean over lanes) of light from infinity on a surface that faces it; `None` for lights
    /// with a place.
    fn distant_irradiance(&self) -> Option<f64> {
        match self {
            Light::Directional(light) => Some(light.power(1.0) / PI),
            // That of a uniform one of equal power.
            Light::Environment(light) => Some(light.power(1.0) / (4.0 * PI)),
            Light::Point(_) | Light::Spot(_) | Light::Area(_) => None,
        }
    }

    /// Returns the power in watts (mean over lanes) emitted into a scene of bounding radius `radius`.
    pub fn power(&self, radius: f32) -> f64 {
        match self {
            Light::Point(light) => light.power(),
            Light::Spot(light) => light.power(),
            Light::Directional(light) => light.power(radius),
            Light::Area(light) => light.power(),
            Light::Environment(light) => light.power(radius),
        }
    }

    /// Returns the approximate largest radiance (mean over lanes) along a ray that hits the light; `None` for Dirac
    /// lights.
    pub fn largest_radiance(&self) -> Option<f64> {
        match self {
            Light::Area(light) => (!light.is_only_seen()).then(|| light.largest_radiance()),
            Light::Environment(light) => Some(light.largest_radiance()),
            Light::Point(_) | Light::Spot(_) | Light::Directional(_) => None,
        }
    }

    /// Whether the light is visible but does not illuminate.
    #[inline]
    pub fn is_only_seen(&self) -> bool {
        matches!(self, Light::Area(light) if light.is_only_seen())
    }

    /// Whether BSDF sampling can never hit the light.
    pub fn is_dirac(&self) -> bool {
        matches!(self, Light::Point(_) | Light::Spot(_) | Light::Directional(_))
    }
}
