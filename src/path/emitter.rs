//! The end of a path on a light, however it was found.

use crate::defects::{Defect, planted};
use crate::geometry::{Bodies, Ray, SurfacePoint};
use crate::light::{EmissionDensity, Emitted, End, Light, LightSample, Receiver};
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use glam::{DVec3, Vec3};

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

    /// The ray of what a light `emitted`, in the bodies where it starts.
    pub fn ray(scene: &Scene, emitted: &Emitted) -> Ray {
        let bodies =
            if planted(Defect::LightsInVacuum) { Bodies::NONE } else { scene.bodies_of_light(&emitted.end, &emitted.ray) };
        Ray { bodies, ..emitted.ray }
    }

    /// Where light `index` was sampled by the point `p`.
    pub fn of_sample(index: usize, sample: &LightSample, p: Vec3) -> Self {
        let falloff = if let End::Point(at) = sample.end { at.distance_squared(p) } else { 1.0 };
        Emitter { index, end: sample.end, radiance: sample.radiance * falloff }
    }

    /// A light as `point` chooses it with the numbers `pick` and `u`, and the direction in which it shines.
    pub fn chosen(scene: &Scene, point: &SurfacePoint, pick: f32, u: [f32; 2]) -> Option<(Self, DVec3)> {
        let (lights, receiver) = (scene.lights(), Receiver::from(point));
        let (index, _) = lights.choose(&receiver, pick)?;
        let sample = lights.all()[index].sample_toward(&receiver, u)?;
        Some((Emitter::of_sample(index, &sample, point.p), -sample.wi.as_dvec3()))
    }

    /// The same end, that shone along `before`, as it shines along the unit vector `w` on the position `at`; `None` where it is dark, or
    /// on the other side of a lamp.
    pub fn turned(&self, scene: &Scene, before: DVec3, w: DVec3, at: Vec3) -> Option<Self> {
        match self.end {
            End::Surface { ng, .. } => (w.dot(ng.as_dvec3()) * before.dot(ng.as_dvec3()) > 0.0).then_some(*self),
            End::Point(_) => {
                let sample = scene.lights().all()[self.index].sample_toward(&Receiver { p: at, ng: -w.as_vec3() }, [0.5; 2])?;
                Some(Emitter::of_sample(self.index, &sample, at))
            }
            End::Infinity => Some(*self),
        }
    }

    /// The light at `point`, as it shines along the unit direction `wo`; `None` if there is none.
    pub fn at(scene: &Scene, point: &SurfacePoint, wo: Vec3) -> Option<Self> {
        let (index, Light::Area(area)) = scene.light_at(point)? else { return None };
        let radiance = area.radiance(point.barycentric, wo);
        let end = End::Surface { p: point.p, error: point.error, ng: point.ng, touched: point.touched() };
        (!radiance.is_black()).then_some(Emitter { index, end, radiance })
    }

    /// What surrounds the scene, as it shines from where the unit direction `w` leads to.
    pub fn outside(scene: &Scene, w: Vec3) -> Option<Self> {
        let (index, environment) = scene.lights().environment()?;
        let (radiance, _) = environment.along(w);
        (!radiance.is_black()).then_some(Emitter { index, end: End::Infinity, radiance })
    }
}
