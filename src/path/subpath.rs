//! A subpath with connectible vertices. It carries the partial MIS sums, in either direction.
//!
//! Usage: `arrive`, connect the vertex, `depart`, repeat.

use super::Emitter;
use super::mis::{EdgeOrigin, MisEdge, MisStrategy, PartialMis};
use super::{PreviousVertex, RandomWalk, TraceStats};
use crate::bsdf::{Bsdf, Lobes, Shading, Surface};
use crate::camera::Camera;
use crate::geometry::{Bodies, Ray, SurfacePoint};
use crate::light::{EmitterPoint, LeRandom, LightSampleContext};
use crate::sampling::{Discrete, Pdf, Sampler, Slot};
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use crate::transport::TransportMode;
use glam::Vec3;
use std::borrow::Cow;

/// Surface vertex of a subpath.
pub struct Vertex<'a> {
    /// Surface point.
    pub point: SurfacePoint,
    /// Scattering model.
    pub surface: Cow<'a, Surface>,
    /// Unit direction to the previous vertex.
    pub known: Vec3,
    /// Throughput of the walk up to this vertex.
    pub beta: Spectrum,
    /// See [`RandomWalk::survival`].
    pub survival: f32,
    /// Bodies in which the walk arrived.
    pub bodies: Bodies,
    /// Partial MIS sums of earlier techniques.
    pub sums: PartialMis,
    /// Transport mode of the walk.
    pub mode: TransportMode,
}

impl Vertex<'_> {
    /// Returns the BSDF for the known direction; `None` if it lies on different sides of the shading and geometric
    /// normals.
    #[inline]
    pub fn shading(&self) -> Option<Shading<'_>> {
        Shading::new(&self.point, &self.surface, self.known, self.mode)
    }

    /// Whether a smooth lobe exists, so that connections can carry light.
    #[inline]
    pub fn is_connectible(&self) -> bool {
        self.surface.lobes().intersects(Lobes::SMOOTH)
    }

    /// Returns the bodies of an edge that leaves along `w`.
    #[inline]
    pub fn bodies_toward(&self, scene: &Scene, w: Vec3) -> Bodies {
        scene.bodies_toward(&self.point, self.bodies, w)
    }
}

/// End of a subpath edge. Callers destructure it at once, so that its size does not matter.
#[allow(clippy::large_enum_variant)]
pub enum Arrival<'a> {
    /// At a surface.
    Surface(Vertex<'a>),
    /// Outside the scene, with the partial MIS sums.
    Infinity(PartialMis),
}

/// A random walk with the MIS state of its current edge.
pub struct Subpath<'a> {
    scene: &'a Scene,
    weights: MisStrategy,
    /// The random walk.
    pub walk: RandomWalk<'a>,
    link: MisEdge,
}

impl<'a> Subpath<'a> {
    /// Starts a subpath along the camera ray `ray`.
    #[inline]
    pub fn from_camera(scene: &'a Scene, weights: &MisStrategy, ray: Ray) -> Self {
        // The density is known at the end of the edge: see `arrive`.
        Subpath { scene, weights: *weights, walk: RandomWalk::new(scene, ray), link: weights.from_camera() }
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
        let emitted = light.sample_le(scene.ball(), &numbers)?;
        let power = emitted.power / pmf.value();
        let (start, receiver) = match emitted.end {
            EmitterPoint::Surface { p, ng, .. } => (EdgeOrigin::Surface { p, ng }, LightSampleContext { p, ng }),
            EmitterPoint::Point(p) => (EdgeOrigin::Point(p), LightSampleContext { p, ng: emitted.ray.direction }),
            EmitterPoint::Distant => {
                (EdgeOrigin::Distant, LightSampleContext { p: emitted.ray.origin, ng: emitted.ray.direction })
            }
        };
        let density = light.pdf_le(scene.ball(), emitted.ray.direction);
        // Tangential emission: about one random number in 2²³ yields it. It has no density and carries no light.
        if density.direction <= 0.0 {
            return None;
        }
        let end = |pmf: Pdf<Discrete>| f64::from(pmf.value()) * density.position;
        // The selection probability of next-event estimation is evaluated at the receiver. Any receiver will do, as
        // long as the choice does not depend on it.
        let direct = end(scene.lights().pmf(&receiver, index));
        let link = weights.from_light(end(pmf), density.direction, direct, light.is_dirac(), start);
        let emitter = Emitter::of_emission(index, &emitted, &density);
        let walk = RandomWalk::from_light(scene, Emitter::ray(scene, &emitted), power);
        Some((Subpath { scene, weights: *weights, walk, link }, emitter))
    }

    /// Traces the current edge to its end.
    #[inline]
    pub fn arrive(&mut self, camera: &Camera, sampler: &mut impl Sampler, tally: &mut TraceStats) -> Arrival<'a> {
        let Some(mut point) = self.walk.arrive(sampler, tally) else {
            return Arrival::Infinity(self.weights.escape(&self.link, self.walk.ray.direction));
        };
        if let PreviousVertex::Camera = self.walk.departure {
            self.link.forward = camera.sample_wi(point.p).map_or(0.0, |seen| f64::from(seen.importance));
        }
        let sums = self.weights.arrive(&self.link, point.p, point.ng, self.walk.ray.direction);
        let surface = self.scene.surface(&mut point, self.walk.ray.bodies);
        Arrival::Surface(Vertex {
            point,
            surface,
            known: -self.walk.ray.direction,
            beta: self.walk.beta,
            survival: self.walk.survival,
            bodies: self.walk.ray.bodies,
            sums,
            mode: self.walk.mode,
        })
    }

    /// Samples the BSDF at `vertex`, at which the walk has arrived. Returns the sampled component; `None` if nothing
    /// scatters.
    #[inline]
    pub fn depart(&mut self, vertex: &Vertex, shading: &Shading, sampler: &mut impl Sampler) -> Option<Lobes> {
        let scatter = shading.sample(self.walk.scattering_numbers(&vertex.surface, sampler))?;
        let densities = shading.densities(&scatter);
        let SurfacePoint { p, ng, .. } = vertex.point;
        self.link = self.weights.from_vertex(vertex.sums, densities, scatter.density.is_delta(), p, ng);
        self.walk.depart(&vertex.point, &scatter);
        Some(scatter.lobe)
    }

    /// [`Subpath::depart`] followed by Russian roulette; `None` if the walk ends.
    #[inline]
    pub fn go_on(
        &mut self,
        vertex: &Vertex,
        shading: &Shading,
        sampler: &mut impl Sampler,
        tally: &mut TraceStats,
    ) -> Option<Lobes> {
        let lobe = self.depart(vertex, shading, sampler)?;
        self.walk.survives(sampler, tally).then_some(lobe)
    }
}
