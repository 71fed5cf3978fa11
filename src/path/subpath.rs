//! A subpath with connectible vertices. It carries the partial MIS sums, in either direction.
//!
//! Usage: `arrive`, connect the vertex, `depart`, repeat.

use super::mis::{FlightPdfs, MisEdge, MisStrategy, PartialMis};
use super::{
    Emitter, FlightEnd, Flown, PhaseAt, PreviousVertex, RandomWalk, Scatterer, SurfaceVertex, TraceStats, Vertex,
};
use crate::bsdf::{Lobes, Scattering, Shading, Surface};
use crate::camera::{Camera, CameraSample, LensPoint};
use crate::geometry::SurfacePoint;
use crate::light::{EmitterPoint, LeRandom, LightSampleContext};
use crate::medium::PhaseSample;
use crate::sampling::{Density, Sampler, Slot};
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use crate::transport::TransportMode;
use glam::Vec3;
use std::borrow::Cow;

/// Vertex of a subpath beyond its endpoint.
pub struct SubpathVertex<'a> {
    /// The vertex.
    pub vertex: Vertex<'a>,
    /// Unit direction to the previous vertex.
    pub known: Vec3,
    /// Throughput of the walk up to this vertex.
    pub beta: Spectrum,
    /// See [`RandomWalk::survival`].
    pub survival: f32,
    /// Partial MIS sums of earlier techniques.
    pub sums: PartialMis,
    /// Transport mode of the walk.
    pub mode: TransportMode,
}

impl SubpathVertex<'_> {
    /// Returns scattering toward `w`, and the density with which a walk that arrives from there leaves along
    /// [`SubpathVertex::known`].
    #[inline]
    pub(super) fn scattering(&self, w: Vec3) -> Option<(Scattering, f64)> {
        match &self.vertex {
            Vertex::Surface(SurfaceVertex { point, surface, .. }) => {
                // Borrowed, not moved out of the options: a copy of what was just written stalls.
                let Some(shading) = &Shading::new(point, surface, self.known, self.mode) else { return None };
                Some((shading.scattering(w)?, f64::from(shading.reverse_pdf(w).value())))
            }
            Vertex::Medium(point) => {
                let scattering = PhaseAt::new(point, self.known).scattering(w);
                Some((scattering, f64::from(scattering.pdf.value())))
            }
            Vertex::Camera(_) | Vertex::Light(_) => None,
        }
    }

    /// See [`Vertex::scatterer`].
    #[inline]
    pub fn scatterer(&self) -> Option<Scatterer<'_>> {
        self.vertex.scatterer(self.known, self.mode)
    }
}

/// End of a subpath edge. Callers destructure it at once, so that its size does not matter.
#[allow(clippy::large_enum_variant)]
pub enum Arrival<'a> {
    /// At a vertex that scatters.
    Vertex(SubpathVertex<'a>),
    /// Outside the scene, with the partial MIS sums.
    Infinity(PartialMis),
}

impl<'a> Arrival<'a> {
    /// Returns the vertex; `None` outside the scene.
    pub fn vertex(self) -> Option<SubpathVertex<'a>> {
        match self {
            Arrival::Vertex(vertex) => Some(vertex),
            Arrival::Infinity(_) => None,
        }
    }
}

/// A random walk with the MIS state of its current edge.
pub struct Subpath<'a> {
    scene: &'a Scene,
    weights: MisStrategy,
    /// The random walk.
    pub walk: RandomWalk<'a>,
    /// What the media on the current edge emit toward its start, times the throughput there; black before its end is
    /// known.
    pub emitted: Spectrum,
    link: MisEdge,
    start: Start,
}

/// Endpoint of a subpath, until its receiver is known.
#[derive(Debug, Clone, Copy)]
enum Start {
    Camera(LensPoint),
    /// A light by its index, its point, and the densities of both under emission sampling: probability and density of
    /// the point.
    Light(usize, EmitterPoint, [f64; 2]),
}

impl<'a> Subpath<'a> {
    /// Starts a subpath at the camera.
    #[inline]
    pub fn from_camera(scene: &'a Scene, weights: &MisStrategy, sample: &CameraSample) -> Self {
        // The density is known at the end of the edge: see `arrive`.
        let walk = RandomWalk::from_camera(scene, sample);
        Subpath {
            scene,
            weights: *weights,
            walk,
            emitted: Spectrum::ZERO,
            link: weights.from_camera(),
            start: Start::Camera(sample.lens),
        }
    }

    /// Starts a subpath from a sampled light. Returns it with its emitter endpoint; `None` if the sample emits nothing.
    pub fn from_light(scene: &'a Scene, weights: &MisStrategy, sampler: &mut impl Sampler) -> Option<(Self, Emitter)> {
        let (index, pmf) = scene.lights().choose_emitter(sampler.u1(0, Slot::LightPick))?;
        let light = &scene.lights().all()[index];
        let numbers = LeRandom {
            side: sampler.u1(0, Slot::Lobe),
            position: sampler.u2(0, Slot::LightPoint),
            direction: sampler.u2(0, Slot::Direction),
        };
        let (emitted, density, emitter) = Emitter::emitting(scene, index, &numbers)?;
        let power = emitted.power / pmf.value();
        // Tangential emission: about one random number in 2²³ yields it. It has no density and carries no light.
        if density.direction <= 0.0 {
            return None;
        }
        let end = f64::from(pmf.value()) * density.position;
        let origin = Vertex::Light(emitted.end).origin();
        let link = weights.from_light(end, density.direction, light.is_dirac(), origin);
        let walk = RandomWalk::from_light(scene, emitter.ray(scene, &emitted), power);
        let start = Start::Light(index, emitted.end, [f64::from(pmf.value()), density.position]);
        Some((Subpath { scene, weights: *weights, walk, emitted: Spectrum::ZERO, link, start }, emitter))
    }

    /// Traces the current edge to its end.
    #[inline]
    pub fn arrive(&mut self, camera: &Camera, sampler: &mut impl Sampler, tally: &mut TraceStats) -> Arrival<'a> {
        if self.scene.features().flights() {
            return self.fly(camera, sampler, tally);
        }
        let Some(mut point) = self.walk.arrive(sampler, tally) else {
            return Arrival::Infinity(self.weights.escape(&self.link, self.walk.ray.direction, FlightPdfs::CERTAIN));
        };
        let (surface, sums) = self.on_surface(camera, &mut point, FlightPdfs::CERTAIN);
        let RandomWalk { beta, survival, mode, ray, .. } = self.walk;
        // The vertex is large. Made in the expression that returns it, it is not moved.
        Arrival::Vertex(SubpathVertex {
            vertex: Vertex::Surface(SurfaceVertex { point, surface, state: ray.state }),
            known: -ray.direction,
            beta,
            survival,
            sums,
            mode,
        })
    }

    /// Does [`Subpath::arrive`] in a scene with media that scatter.
    fn fly(&mut self, camera: &Camera, sampler: &mut impl Sampler, tally: &mut TraceStats) -> Arrival<'a> {
        let Flown { end, through, emitted } = self.walk.fly(sampler, tally);
        self.emitted = emitted;
        let pdfs = |end| FlightPdfs::new(through, self.link.start.extinction(), end);
        let w = self.walk.ray.direction;
        let (vertex, sums) = match end {
            Some(FlightEnd::Surface(mut point)) => {
                let (surface, sums) = self.on_surface(camera, &mut point, pdfs(Spectrum::ONE));
                (Vertex::Surface(SurfaceVertex { point, surface, state: self.walk.ray.state }), sums)
            }
            Some(FlightEnd::Medium(point)) => {
                let flight = pdfs(point.extinction);
                self.complete(camera, &LightSampleContext::from(&point), w);
                (Vertex::Medium(point), self.weights.arrive(&self.link, point.p, 1.0, w, flight))
            }
            None => return Arrival::Infinity(self.weights.escape(&self.link, w, pdfs(Spectrum::ONE))),
        };
        let RandomWalk { beta, survival, mode, .. } = self.walk;
        Arrival::Vertex(SubpathVertex { vertex, known: -w, beta, survival, sums, mode })
    }

    /// Arrives on the surface at `point` in a flight with the densities `flight`; returns the scattering model and the
    /// partial MIS sums.
    #[inline(always)] // see RandomWalk::arrive
    fn on_surface(
        &mut self,
        camera: &Camera,
        point: &mut SurfacePoint,
        flight: FlightPdfs,
    ) -> (Cow<'a, Surface>, PartialMis) {
        let (w, state) = (self.walk.ray.direction, self.walk.ray.state);
        self.complete(camera, &LightSampleContext::from(&*point), w);
        let sums = self.weights.arrive(&self.link, point.p, point.cos(w), w, flight);
        (self.scene.surface(point, state.bodies), sums)
    }

    /// Computes what the first edge of the subpath could not know before its end: the density of a camera ray at
    /// `receiver`, and that of a light sample from there to the light.
    #[inline]
    fn complete(&mut self, camera: &Camera, receiver: &LightSampleContext, w: Vec3) {
        match (&self.walk.departure, &self.start) {
            (PreviousVertex::Camera, &Start::Camera(lens)) => {
                let seen = camera.sample_wi(receiver.p, lens);
                self.link.forward = seen.map_or(0.0, |seen| f64::from(seen.importance));
            }
            (PreviousVertex::Light, &Start::Light(index, ref end, [pmf, position])) => {
                let direct = self.scene.lights().end_pdf_li(receiver, index, end, -w, position);
                self.weights.received(&mut self.link, direct, pmf * position);
            }
            _ => {}
        }
    }

    /// Samples the direction in which the walk leaves `vertex`, at which it has arrived. Returns the sampled component;
    /// `None` if nothing scatters.
    #[inline]
    pub fn depart(
        &mut self,
        vertex: &SubpathVertex,
        scatterer: &Scatterer,
        sampler: &mut impl Sampler,
    ) -> Option<Lobes> {
        match (&vertex.vertex, scatterer) {
            (Vertex::Surface(SurfaceVertex { point, surface, .. }), Scatterer::Surface(shading)) => {
                let scatter = shading.sample(self.walk.scattering_numbers(surface, sampler))?;
                let densities = shading.densities(&scatter);
                let origin = vertex.vertex.origin();
                self.link = self.weights.from_vertex(vertex.sums, densities, scatter.density.is_delta(), origin);
                self.walk.depart(point, LightSampleContext::from(point), &scatter);
                Some(scatter.lobe)
            }
            (Vertex::Medium(point), Scatterer::Medium(phase)) => {
                let PhaseSample { direction, pdf } = phase.sample(sampler.u2(self.walk.bounce, Slot::Direction));
                let densities = [f64::from(pdf.value()); 2];
                self.link = self.weights.from_vertex(vertex.sums, densities, false, vertex.vertex.origin());
                self.walk.scatter_in_medium(point, direction, Density::Smooth(pdf));
                Some(Lobes::SMOOTH)
            }
            _ => None,
        }
    }

    /// [`Subpath::depart`] followed by Russian roulette; `None` if the walk ends.
    #[inline]
    pub fn go_on(
        &mut self,
        vertex: &SubpathVertex,
        scatterer: &Scatterer,
        sampler: &mut impl Sampler,
        tally: &mut TraceStats,
    ) -> Option<Lobes> {
        let lobe = self.depart(vertex, scatterer, sampler)?;
        self.walk.survives(sampler, tally).then_some(lobe)
    }
}
