//! The end of a path on a light, however it was found.

use crate::geometry::SurfacePoint;
use crate::light::{EmissionDensity, Emitted, End, Light, LightSample};
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use glam::Vec3;

/// The end of a path on a light.
#[derive(Debug, Clone, Copy)]
pub struct Emitter {
    /// Index of the light.
    pub index: usize,
    /// Where on it.
    pub end: End,
    /// What leaves it along the path: radiance, the intensity of a point, the irradiance of parallel light.
    pub radiance: Spectrum,
}

impl Emitter {
    /// Where light `index` `emitted` with `density`.
    pub fn of_emission(index: usize, emitted: &Emitted, density: &EmissionDensity) -> Self {
        let cos = if let End::Surface { ng, .. } = emitted.end { emitted.ray.direction.dot(ng).abs() } else { 1.0 };
        let radiance = emitted.power * ((density.end * density.ray) as f32 / cos);
        Emitter { index, end: emitted.end, radiance }
    }

    /// Where light `index` was sampled by the point `p`.
    pub fn of_sample(index: usize, sample: &LightSample, p: Vec3) -> Self {
        let falloff = if let End::Point(at) = sample.end { at.distance_squared(p) } else { 1.0 };
        Emitter { index, end: sample.end, radiance: sample.radiance * falloff }
    }

    /// The light at `point`, as it shines along the unit direction `wo`; `None` if there is none.
    pub fn at(scene: &Scene, point: &SurfacePoint, wo: Vec3) -> Option<Self> {
        let (index, Light::Area(area)) = scene.light_at(point)? else { return None };
        let radiance = area.radiance(point.barycentric, wo);
        let end = End::Surface { p: point.p, error: point.error, ng: point.ng };
        (!radiance.is_black()).then_some(Emitter { index, end, radiance })
    }

    /// What surrounds the scene, as it shines from where the unit direction `w` leads to.
    pub fn outside(scene: &Scene, w: Vec3) -> Option<Self> {
        let (index, environment) = scene.lights().environment()?;
        let (radiance, _) = environment.along(w);
        (!radiance.is_black()).then_some(Emitter { index, end: End::Infinity, radiance })
    }
}
