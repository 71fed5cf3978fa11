//! The emitter endpoint of a path, independent of the technique that sampled it.

use crate::geometry::{Ray, SurfacePoint};
use crate::light::{ChosenLight, EmitterPoint, LePdf, LeRandom, LeSample, Light, LightSample, LightSampleContext};
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use glam::{DVec3, Vec3};

/// Emitter endpoint of a path.
#[derive(Debug, Clone, Copy)]
pub struct Emitter {
    /// Index of the light.
    pub index: usize,
    /// Position on the light.
    pub end: EmitterPoint,
    /// Emitted quantity along the path: radiance, intensity of a point light, or irradiance of parallel light.
    pub radiance: Spectrum,
}

impl Emitter {
    /// Creates the endpoint at which light `index` `emitted` with `density`.
    fn of_emission(index: usize, emitted: &LeSample, density: &LePdf) -> Self {
        let cos =
            if let EmitterPoint::Surface { ng, .. } = emitted.end { emitted.ray.direction.dot(ng).abs() } else { 1.0 };
        let radiance = emitted.power * ((density.position * density.direction) as f32 / cos);
        Emitter { index, end: emitted.end, radiance }
    }

    /// Samples a ray of light `index`. Returns it with its densities and its endpoint; `None` if it carries no light.
    #[inline]
    pub fn emitting(scene: &Scene, index: usize, numbers: &LeRandom) -> Option<(LeSample, LePdf, Self)> {
        let light = &scene.lights().all()[index];
        let emitted = light.sample_le(scene.ball(), numbers)?;
        let density = light.pdf_le(scene.ball(), &emitted.end, emitted.ray.direction);
        let emitter = Emitter::of_emission(index, &emitted, &density);
        Some((emitted, density, emitter))
    }

    /// Returns the ray that its light `emitted`, with the bodies at the ray's origin.
    pub fn ray(&self, scene: &Scene, emitted: &LeSample) -> Ray {
        emitted.ray.carrying(emitted.ray.state.within(scene.bodies_of_light(self.index, &emitted.ray)))
    }

    /// Creates the endpoint of light `index` sampled from the point `p`.
    pub fn of_sample(index: usize, sample: &LightSample, p: Vec3) -> Self {
        let falloff = if let EmitterPoint::Point(at) = sample.end { at.distance_squared(p) } else { 1.0 };
        Emitter { index, end: sample.end, radiance: sample.radiance * falloff }
    }

    /// Chooses a light for `receiver` with the random numbers of [`Lights::choose`](crate::light::Lights::choose). Returns
    /// the endpoint and its emission direction.
    pub fn chosen(
        scene: &Scene,
        receiver: &LightSampleContext,
        u: [f32; 2],
        pick: impl FnOnce() -> f32,
    ) -> Option<(Self, DVec3)> {
        let lights = scene.lights();
        let ChosenLight { index, u, .. } = lights.choose(receiver, u, pick)?;
        let sample = lights.all()[index].sample_li(receiver, u)?;
        Some((Emitter::of_sample(index, &sample, receiver.p), -sample.wi.as_dvec3()))
    }

    /// Returns the same endpoint emitting along the unit vector `w` toward the position `at`, in place of `before`.
    /// `None` if it emits nothing there, or if `w` and `before` lie on different sides of an area light.
    pub fn turned(&self, scene: &Scene, before: DVec3, w: DVec3, at: Vec3) -> Option<Self> {
        match self.end {
            EmitterPoint::Surface { ng, .. } => {
                (w.dot(ng.as_dvec3()) * before.dot(ng.as_dvec3()) > 0.0).then_some(*self)
            }
            EmitterPoint::Point(_) => {
                let sample =
                    scene.lights().all()[self.index].sample_li(&LightSampleContext::new(at, -w.as_vec3()), [0.5; 2])?;
                Some(Emitter::of_sample(self.index, &sample, at))
            }
            EmitterPoint::Distant => Some(*self),
        }
    }

    /// Returns the emitter endpoint at `point` for the unit direction `wo`; `None` if nothing is emitted.
    pub fn at(scene: &Scene, point: &SurfacePoint, wo: Vec3) -> Option<Self> {
        let (index, Light::Area(area)) = scene.light_at(point)? else { return None };
        let radiance = area.radiance(point.barycentric, wo);
        (!radiance.is_black()).then_some(Emitter { index, end: point.into(), radiance })
    }

    /// Returns the endpoint on the environment in the unit direction `w`.
    pub fn outside(scene: &Scene, w: Vec3) -> Option<Self> {
        let (index, environment) = scene.lights().environment()?;
        let (radiance, _) = environment.along(w);
        (!radiance.is_black()).then_some(Emitter { index, end: EmitterPoint::Distant, radiance })
    }
}
