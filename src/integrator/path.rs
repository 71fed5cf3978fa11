//! Path tracing in three strengths over one walk: `path-naive`, `path-nee`, `path`.
//!
//! - `path-naive` samples directions uniformly and never samples lights: as simple as it can be, and slow. A reference.
//! - `path-nee` samples directions by the BSDF and lights by next-event estimation; light found by chance counts only where
//!   light sampling could not have found it. Noisy where glossy surfaces mirror large lights.
//! - `path` weights both techniques by the power heuristic [Veach97 §9.2]. The default.
//!
//! Caustics from small lights and light through ajar doors are slow in all three.

use super::camera_pass::Radiance;
use crate::bsdf::{Lobes, Scattering, Shading, ShadingSample};
use crate::defects::{Defect, planted};
use crate::geometry::{Local, Ray, SurfacePoint};
use crate::light::{Light, LightSample, Receiver};
use crate::path::{Departure, Tally, Walk, toward_light};
use crate::sampling::{Density, Discrete, Pdf, Sampler, Slot, balance, power, warp};
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use crate::transport::Transport;

/// How a path tracer samples directions and lights, and what share each technique has.
pub(super) trait Strategy: Send + Sync {
    /// Whether lights are sampled at all.
    const SAMPLES_LIGHTS: bool = true;
    /// A direction to go on: by the BSDF.
    #[inline]
    fn scatter(shading: &Shading, u: [f32; 3]) -> Option<ShadingSample> {
        shading.sample(u)
    }
    /// Share of a light sample of density `light` that scattering would have made with density `scattering`.
    fn share_of_light(light: f32, scattering: f32) -> f32;
    /// Share of light found by scattering with density `scattering` that light sampling would have found with `light`.
    fn share_of_scattering(scattering: f32, light: f32) -> f32;
}

/// Uniform directions, no light sampling.
pub(super) struct Naive;
/// BSDF sampling and next-event estimation, each light by one technique.
pub(super) struct NextEvent;
/// BSDF sampling and next-event estimation, combined.
pub(super) struct Combined;

impl Strategy for Naive {
    const SAMPLES_LIGHTS: bool = false;
    /// Uniform over the hemisphere of ns on the side of the surface where `wo` is, or over the sphere where the surface transmits.
    fn scatter(shading: &Shading, [_, u, v]: [f32; 3]) -> Option<ShadingSample> {
        let frame = shading.point.frame;
        if shading.lobes().intersects(Lobes::TRANSMIT) {
            let wi = frame.to_world(Local::from(warp::uniform_sphere([u, v])));
            Some(shading.along(wi, warp::uniform_sphere_pdf()))
        } else {
            let w = warp::uniform_hemisphere([u, v]);
            let wi = frame.to_world(Local::new(w.x, w.y, w.z.copysign(shading.known().dot(shading.point.ng))));
            Some(shading.along(wi, warp::uniform_hemisphere_pdf()))
        }
    }
    fn share_of_light(_: f32, _: f32) -> f32 {
        0.0
    }
    fn share_of_scattering(_: f32, _: f32) -> f32 {
        1.0
    }
}

impl Strategy for NextEvent {
    #[inline]
    fn share_of_light(_: f32, _: f32) -> f32 {
        1.0
    }
    #[inline]
    fn share_of_scattering(_: f32, _: f32) -> f32 {
        0.0
    }
}

impl Strategy for Combined {
    #[inline]
    fn share_of_light(light: f32, scattering: f32) -> f32 {
        power(light, scattering)
    }
    #[inline]
    fn share_of_scattering(scattering: f32, light: f32) -> f32 {
        if planted(Defect::MixedHeuristics) { balance(scattering, light) } else { power(scattering, light) }
    }
}

/// The radiance estimator of a path tracer.
pub(super) struct PathTracer<'a, S: Strategy> {
    scene: &'a Scene,
    max_depth: u32,
    /// Whether the environment is left out where the camera sees it directly.
    transparent: bool,
    strategy: std::marker::PhantomData<S>,
}

impl<'a, S: Strategy> PathTracer<'a, S> {
    pub(super) fn new(scene: &'a Scene, max_depth: Option<u32>, transparent: bool) -> Self {
        let max_depth = max_depth.unwrap_or(u32::MAX);
        PathTracer { scene, max_depth, transparent, strategy: std::marker::PhantomData }
    }

    /// Light that scattering found, times its share: `density(reference, light index)` is what light sampling would have had.
    #[inline]
    fn share_of_hit(&self, departure: &Departure, light: usize, pdf: impl FnOnce() -> f32) -> f32 {
        match departure {
            Departure::Surface(from, Density::Smooth(scattering)) => {
                let pmf = if planted(Defect::LightPmfNotInHit) { 1.0 } else { self.scene.lights().pmf(from, light).value() };
                S::share_of_scattering(scattering.value(), pmf * pdf())
            }
            Departure::Surface(_, Density::Delta(_)) if planted(Defect::EmissionLostAfterDirac) => 0.0,
            Departure::Surface(_, Density::Delta(_)) | Departure::Camera | Departure::Light => 1.0,
        }
    }

    /// What the surface at `point` emits toward the walk.
    #[inline]
    fn emitted(&self, walk: &Walk, point: &SurfacePoint) -> Spectrum {
        let Some((index, Light::Area(light))) = self.scene.light_at(point) else { return Spectrum::ZERO };
        let wi = walk.ray.direction;
        let radiance = light.radiance(point.barycentric, -wi);
        if radiance.is_black() || !walk.sees(light) {
            return Spectrum::ZERO;
        }
        let pdf = |from: &Receiver| {
            if planted(Defect::HitPdfOverArea) {
                return light.pdf_toward(1.0, point.ng).value();
            }
            light.pdf_toward((point.p - from.p).length_squared(), wi).value()
        };
        let share = match &walk.departure {
            Departure::Surface(from, _) => self.share_of_hit(&walk.departure, index, || pdf(from)),
            Departure::Camera | Departure::Light => 1.0,
        };
        walk.beta * radiance * share
    }

    /// What arrives from outside the scene.
    #[inline]
    fn background(&self, walk: &Walk) -> Spectrum {
        let Some((index, environment)) = self.scene.lights().environment() else { return Spectrum::ZERO };
        if self.transparent && matches!(walk.departure, Departure::Camera) {
            return Spectrum::ZERO;
        }
        let (radiance, pdf) = environment.along(walk.ray.direction);
        walk.beta * radiance * self.share_of_hit(&walk.departure, index, || pdf.value())
    }

    /// Light from one sampled light, scattered at `point`.
    #[inline]
    fn direct(&self, shading: &Shading, walk: &Walk, sampler: &mut impl Sampler, tally: &mut Tally) -> Spectrum {
        let (lights, receiver) = (self.scene.lights(), Receiver::from(shading.point));
        let Some((index, pmf)) = lights.choose(&receiver, sampler.u1(walk.bounce, Slot::LightPick)) else {
            return Spectrum::ZERO;
        };
        let mut u = sampler.u2(walk.bounce, Slot::LightPoint);
        if planted(Defect::LightPickReused) {
            u[0] = sampler.u1(walk.bounce, Slot::LightPick);
        }
        let Some(sample) = lights.all()[index].sample_toward(&receiver, u) else { return Spectrum::ZERO };
        let Some(scattering) = shading.scattering(sample.wi) else { return Spectrum::ZERO };
        let weight = Self::light_weight(&scattering, &sample, pmf);
        let segment = toward_light(self.scene, shading.point, walk.ray.bodies, &sample);
        let through = self.scene.transmittance(&Ray { time: walk.ray.time, ..segment }, &mut tally.shadows);
        walk.beta * scattering.f_cos * sample.radiance * through * weight
    }

    /// Share of the light sample over its density.
    #[inline]
    fn light_weight(scattering: &Scattering, sample: &LightSample, pmf: Pdf<Discrete>) -> f32 {
        match sample.density {
            Density::Delta(probability) => (pmf.value() * probability).recip(),
            Density::Smooth(pdf) => {
                let density = if planted(Defect::LightPmfNotInSample) { pdf.value() } else { pdf.choose(pmf).value() };
                S::share_of_light(density, scattering.pdf.value()) / density
            }
        }
    }
}

impl<S: Strategy> Radiance for PathTracer<'_, S> {
    fn radiance<P: Sampler>(
        &self,
        ray: Ray,
        sampler: &mut P,
        _: impl FnOnce() -> P,
        _: &mut impl FnMut([f32; 2], Spectrum),
        tally: &mut Tally,
    ) -> Spectrum {
        let mut walk = Walk::new(self.scene, ray);
        let mut total = Spectrum::ZERO;
        loop {
            let Some(mut point) = walk.arrive(sampler, tally) else { return total + self.background(&walk) };
            total += self.emitted(&walk, &point);
            if walk.depth >= self.max_depth.saturating_add(u32::from(planted(Defect::DepthOneMore))) {
                return total;
            }
            let surface = self.scene.surface(&mut point, walk.ray.bodies);
            let wo = -walk.ray.direction;
            let Some(shading) = Shading::new(&point, &surface, wo, Transport::Light) else { return total };
            if S::SAMPLES_LIGHTS && shading.lobes().intersects(Lobes::SMOOTH) {
                total += self.direct(&shading, &walk, sampler, tally);
            }
            let Some(scatter) = S::scatter(&shading, walk.scattering_numbers(&surface, sampler)) else { return total };
            walk.depart(&point, &scatter);
            if !walk.survives(sampler, tally) {
                return total;
            }
        }
    }
}
