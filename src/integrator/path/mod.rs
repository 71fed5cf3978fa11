//! Path tracing in three variants over one random walk: `path-naive`, `path-nee`, `path`.
//!
//! - `path-naive` samples directions uniformly and never samples lights: simple and slow. A reference.
//! - `path-nee` combines BSDF sampling and next-event estimation. Emission hit by BSDF sampling counts only where light
//!   sampling is impossible. Noisy where glossy surfaces reflect large lights.
//! - `path` weights both techniques by the power heuristic [Veach97 §9.2]. The default.
//!
//! Caustics from small lights and light through ajar doors converge slowly in all three.

mod batch;
mod diffusion;
mod equiangular;
mod media;

pub(super) use batch::{BatchedPath, knows};
pub(super) use diffusion::known_solids;

use super::camera_pass::Radiance;
use crate::bsdf::{Lobes, Scattering, Shading, ShadingSample};
use crate::camera::CameraSample;
use crate::geometry::{Hit, Local, SurfacePoint};
use crate::light::{ChosenLight, Light, LightSample, LightSampleContext};
use crate::path::{PreviousVertex, RandomWalk, TraceStats};
use crate::sampling::{Density, Discrete, Pdf, Sampler, Slot, power, warp};
use crate::scene::{Edge, EdgeEnd, Scene};
use crate::spectrum::Spectrum;
use crate::subsurface::DiffusionModel;
use crate::transport::TransportMode;
use diffusion::DiffusionBodies;
use glam::Vec3;

/// Sampling of directions and lights in a path tracer, and the MIS weights of both techniques.
pub(super) trait Strategy: Send + Sync {
    /// Whether lights are sampled at all.
    const SAMPLES_LIGHTS: bool = true;
    /// Whether lights that are sampled also count where scattering hits them.
    const HITS_LIGHTS: bool = false;
    /// Samples a direction, by default from the BSDF.
    #[inline]
    fn scatter(shading: &Shading, u: [f32; 3]) -> Option<ShadingSample> {
        shading.sample(u)
    }
    /// Returns the MIS weight of a light sample of density `light`; `scattering` is the BSDF density of its direction.
    fn mis_weight_light(light: f32, scattering: f32) -> f32;
    /// Returns the MIS weight of a BSDF sample of density `scattering` that hits a light; `light` is the light sampling
    /// density.
    fn mis_weight_scattering(scattering: f32, light: f32) -> f32;
}

/// Uniform directions, no light sampling.
pub(super) struct Naive;
/// BSDF sampling and next-event estimation, each light by one technique.
pub(super) struct NextEvent;
/// BSDF sampling and next-event estimation, combined.
pub(super) struct Combined;

impl Strategy for Naive {
    const SAMPLES_LIGHTS: bool = false;
    /// Samples uniformly over the hemisphere of ns on the side of `wo`, or over the sphere if the surface transmits.
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
    fn mis_weight_light(_: f32, _: f32) -> f32 {
        0.0
    }
    fn mis_weight_scattering(_: f32, _: f32) -> f32 {
        1.0
    }
}

impl Strategy for NextEvent {
    #[inline]
    fn mis_weight_light(_: f32, _: f32) -> f32 {
        1.0
    }
    #[inline]
    fn mis_weight_scattering(_: f32, _: f32) -> f32 {
        0.0
    }
}

impl Strategy for Combined {
    const HITS_LIGHTS: bool = true;
    #[inline]
    fn mis_weight_light(light: f32, scattering: f32) -> f32 {
        power(light, scattering)
    }
    #[inline]
    fn mis_weight_scattering(scattering: f32, light: f32) -> f32 {
        power(scattering, light)
    }
}

/// Probability of getting through empty space.
pub(super) const CERTAIN: f32 = 1.0;

/// The radiance estimator of a path tracer.
pub(super) struct PathTracer<'a, S: Strategy> {
    scene: &'a Scene,
    max_depth: u32,
    /// Whether the directly visible environment is left out.
    transparent: bool,
    /// Bodies in which a diffusion model replaces the walk.
    diffusion: Option<DiffusionBodies>,
    strategy: std::marker::PhantomData<S>,
}

impl<'a, S: Strategy> PathTracer<'a, S> {
    pub(super) fn new(scene: &'a Scene, max_depth: Option<u32>, transparent: bool) -> Self {
        let max_depth = max_depth.unwrap_or(u32::MAX);
        PathTracer { scene, max_depth, transparent, diffusion: None, strategy: std::marker::PhantomData }
    }

    /// Replaces walks in bodies by `model`, if there is one.
    pub(super) fn diffusing(self, model: Option<DiffusionModel>) -> Self {
        PathTracer { diffusion: model.map(|model| DiffusionBodies::new(self.scene, model)), ..self }
    }

    /// Returns the MIS weight of emission hit by BSDF sampling. `pdf` is the light sampling density of the direction,
    /// without the selection probability of the light; `chance` is the probability of getting through media.
    #[inline]
    fn mis_weight_bsdf(
        &self,
        departure: &PreviousVertex,
        light: usize,
        pdf: impl FnOnce() -> f32,
        chance: f32,
        tally: &mut TraceStats,
    ) -> f32 {
        match departure {
            PreviousVertex::Scattered(from, Density::Smooth(scattering)) => {
                let lights = self.scene.lights();
                let pmf = tally.selection.time_of(lights, || lights.pmf(from, light)).value();
                S::mis_weight_scattering(scattering.value() * chance, pmf * pdf())
            }
            PreviousVertex::Scattered(_, Density::Delta(_)) | PreviousVertex::Camera | PreviousVertex::Light => 1.0,
        }
    }

    /// Returns the weighted emission toward the walk of the primitive `hit` at the point `p` with these barycentric
    /// weights. `chance` is the probability of getting there through media.
    #[inline]
    fn emitted(
        &self,
        walk: &RandomWalk,
        hit: Hit,
        p: Vec3,
        barycentric: [f32; 2],
        chance: f32,
        tally: &mut TraceStats,
    ) -> Spectrum {
        let Some((index, Light::Area(light))) = self.scene.light_of(hit) else { return Spectrum::ZERO };
        let wi = walk.ray.direction;
        let radiance = light.radiance(barycentric, -wi);
        if radiance.is_black() || !walk.sees(light) {
            return Spectrum::ZERO;
        }
        let pdf = |from: &LightSampleContext| light.pdf_li(from.p, p, wi).value();
        let share = match &walk.departure {
            PreviousVertex::Scattered(from, _) => {
                self.mis_weight_bsdf(&walk.departure, index, || pdf(from), chance, tally)
            }
            PreviousVertex::Camera | PreviousVertex::Light => 1.0,
        };
        walk.beta * radiance * share
    }

    /// Returns the weighted radiance of the environment, reached with probability `chance` through media.
    #[inline]
    fn background(&self, walk: &RandomWalk, chance: f32, tally: &mut TraceStats) -> Spectrum {
        let Some((index, environment)) = self.scene.lights().environment() else { return Spectrum::ZERO };
        if self.transparent && matches!(walk.departure, PreviousVertex::Camera) {
            return Spectrum::ZERO;
        }
        let (radiance, pdf) = environment.along(walk.ray.direction);
        walk.beta * radiance * self.mis_weight_bsdf(&walk.departure, index, || pdf.value(), chance, tally)
    }

    /// Returns the receiver for which lights are selected at `shading`.
    #[inline]
    fn receiver(&self, shading: &Shading) -> LightSampleContext {
        if self.scene.lights().is_by_receiver() { shading.into() } else { shading.point.into() }
    }

    /// Samples a light for next-event estimation. Returns the edge to it and the contribution of the sample if nothing
    /// blocks the edge.
    #[inline]
    fn light_sample(
        &self,
        shading: &Shading,
        receiver: &LightSampleContext,
        walk: &RandomWalk,
        sampler: &mut impl Sampler,
        tally: &mut TraceStats,
    ) -> Option<(Edge, Spectrum)> {
        let lights = self.scene.lights();
        let u = sampler.u2(walk.bounce, Slot::LightPoint);
        let choose = || lights.choose(receiver, u, || sampler.u1(walk.bounce, Slot::LightPick));
        let ChosenLight { index, pmf, u } = tally.selection.time_of(lights, choose)?;
        // Borrowed, not moved out of the options: a copy of what was just written stalls.
        let Some(sample) = &lights.all()[index].sample_li(receiver, u) else { return None };
        let Some(scattering) = &shading.scattering(sample.wi) else { return None };
        let weight = light_weight::<S>(scattering, sample, pmf);
        let edge = Edge::new(self.scene, shading.point, walk.ray.state, sample.wi, EdgeEnd::Light(sample.end));
        Some((edge, walk.beta * scattering.f_cos * sample.radiance * weight))
    }

    /// Leaves the vertex of `walk` at `point`: samples a light, of which `light` gets the edge and the contribution if
    /// nothing blocks the edge, and then a direction. Returns whether the walk goes on.
    #[inline(always)] // see RandomWalk::arrive
    fn leave(
        &self,
        walk: &mut RandomWalk,
        point: &mut SurfacePoint,
        sampler: &mut impl Sampler,
        tally: &mut TraceStats,
        light: impl FnOnce(&Edge, Spectrum, &mut TraceStats),
    ) -> bool {
        let surface = self.scene.surface(point, walk.ray.state.bodies);
        let wo = -walk.ray.direction;
        let Some(shading) = &Shading::new(point, &surface, wo, TransportMode::Radiance) else { return false };
        let receiver = self.receiver(shading);
        if S::SAMPLES_LIGHTS && shading.lobes().intersects(Lobes::SMOOTH) {
            if let Some((edge, contribution)) = &self.light_sample(shading, &receiver, walk, sampler, tally) {
                light(edge, *contribution, tally);
            }
        }
        let Some(scatter) = &S::scatter(shading, walk.scattering_numbers(&surface, sampler)) else { return false };
        walk.depart(point, receiver, scatter);
        walk.survives(sampler, tally)
    }
}

/// Returns the MIS weight of a light sample, whose light is selected with probability `pmf`, divided by its density.
#[inline]
pub(super) fn light_weight<S: Strategy>(scattering: &Scattering, sample: &LightSample, pmf: Pdf<Discrete>) -> f32 {
    match sample.density {
        Density::Delta(probability) => (pmf.value() * probability).recip(),
        Density::Smooth(pdf) => {
            let density = pdf.choose(pmf).value();
            S::mis_weight_light(density, scattering.pdf.value()) / density
        }
    }
}

impl<S: Strategy> Radiance for PathTracer<'_, S> {
    fn radiance<P: Sampler>(
        &self,
        camera: &CameraSample,
        sampler: &mut P,
        _: impl FnOnce() -> P,
        _: &mut impl FnMut([f32; 2], Spectrum),
        tally: &mut TraceStats,
    ) -> Spectrum {
        if self.scene.features().flights() {
            return self.radiance_in_media(camera, sampler, tally);
        }
        let mut walk = RandomWalk::from_camera(self.scene, camera);
        let mut total = Spectrum::ZERO;
        loop {
            let Some(mut point) = walk.arrive(sampler, tally) else {
                return total + self.background(&walk, CERTAIN, tally);
            };
            total += self.emitted(&walk, point.hit, point.p, point.barycentric, CERTAIN, tally);
            if walk.depth >= self.max_depth {
                return total;
            }
            let next_event = |edge: &Edge, light: Spectrum, tally: &mut TraceStats| {
                let through = self.scene.transmittance(edge, &mut tally.shadows);
                if !through.is_black() {
                    total += light * through;
                }
            };
            if !self.leave(&mut walk, &mut point, sampler, tally, next_event) {
                return total;
            }
        }
    }
}
