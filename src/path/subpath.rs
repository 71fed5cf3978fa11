//! A walk whose vertices can be connected: it carries what multiple importance sampling must know, in either direction.
//!
//! Use it as `arrive`, connect the vertex, `depart`, and again.

use super::Emitter;
use super::mis::{Link, Start, Sums, Weights};
use super::{Departure, Tally, Walk};
use crate::bsdf::{Bsdf, Lobes, Shading, Surface};
use crate::camera::Camera;
use crate::defects::{Defect, planted};
use crate::geometry::{Bodies, Ray, SurfacePoint};
use crate::light::{EmissionNumbers, End, Receiver};
use crate::sampling::{Discrete, Pdf, Sampler, Slot};
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use crate::transport::Transport;
use glam::Vec3;
use std::borrow::Cow;

/// A point of a surface that a walk has come to.
pub struct Vertex<'a> {
    /// Where.
    pub point: SurfacePoint,
    /// How it scatters.
    pub surface: Cow<'a, Surface>,
    /// The unit direction to the vertex before.
    pub known: Vec3,
    /// The walk's throughput up to here.
    pub beta: Spectrum,
    /// See [`Walk::survival`].
    pub survival: f32,
    /// The bodies that the walk came through.
    pub bodies: Bodies,
    /// What it knows of earlier techniques.
    pub sums: Sums,
    /// The end of the path that its walk goes toward.
    pub toward: Transport,
}

impl Vertex<'_> {
    /// Scattering from the direction that is known; `None` where the two normals have it on different sides.
    #[inline]
    pub fn shading(&self) -> Option<Shading<'_>> {
        Shading::new(&self.point, &self.surface, self.known, self.toward)
    }

    /// Whether it scatters into directions that a walk did not choose.
    #[inline]
    pub fn is_connectible(&self) -> bool {
        self.surface.lobes().intersects(Lobes::SMOOTH)
    }

    /// The bodies of an edge that leaves along `w`.
    #[inline]
    pub fn bodies_toward(&self, scene: &Scene, w: Vec3) -> Bodies {
        scene.bodies_toward(&self.point, self.bodies, w)
    }
}

/// How a subpath's edge ends. It is taken apart where it is made, so that it need not be small.
#[allow(clippy::large_enum_variant)]
pub enum Arrival<'a> {
    /// At a surface.
    Surface(Vertex<'a>),
    /// Outside the scene, with what is known there.
    Infinity(Sums),
}

/// A walk and what weights need of its current edge.
pub struct Subpath<'a> {
    scene: &'a Scene,
    weights: Weights,
    /// The walk itself.
    pub walk: Walk<'a>,
    link: Link,
}

impl<'a> Subpath<'a> {
    /// Along the camera ray `ray`.
    #[inline]
    pub fn from_camera(scene: &'a Scene, weights: &Weights, ray: Ray) -> Self {
        // The density is known where the edge ends: see `arrive`.
        Subpath { scene, weights: *weights, walk: Walk::new(scene, ray), link: weights.from_camera() }
    }

    /// Along a ray of some light, and where it left that light; `None` where it is dark.
    pub fn from_light(scene: &'a Scene, weights: &Weights, sampler: &mut impl Sampler) -> Option<(Self, Emitter)> {
        let (index, pmf) = scene.lights().choose_emitter(sampler.u1(0, Slot::LightPick))?;
        let light = &scene.lights().all()[index];
        let numbers = EmissionNumbers {
            side: sampler.u1(0, Slot::Lobe),
            position: sampler.u2(0, Slot::LightPoint),
            direction: sampler.u2(0, Slot::Direction),
        };
        let emitted = light.emit(scene.ball(), &numbers)?;
        let power = emitted.power / pmf.value();
        let (start, receiver) = match emitted.end {
            End::Surface { p, ng, .. } => (Start::Surface { p, ng }, Receiver { p, ng }),
            End::Point(p) => (Start::Point(p), Receiver { p, ng: emitted.ray.direction }),
            End::Infinity => (Start::Far, Receiver { p: emitted.ray.origin, ng: emitted.ray.direction }),
        };
        let density = light.emission_density(scene.ball(), emitted.ray.direction);
        // Along the surface of the light: one number in 2²³ leads there, and what has no density carries nothing.
        if density.ray <= 0.0 && !planted(Defect::GrazingEmission) {
            return None;
        }
        let end = |pmf: Pdf<Discrete>| f64::from(pmf.value()) * density.end;
        // What receivers choose by is known at the receiver: until choices depend on it any will do.
        let direct = end(scene.lights().pmf(&receiver, index));
        let link = weights.from_light(end(pmf), density.ray, direct, light.is_dirac(), start);
        let emitter = Emitter::of_emission(index, &emitted, &density);
        let walk = Walk::from_light(scene, Emitter::ray(scene, &emitted), power);
        Some((Subpath { scene, weights: *weights, walk, link }, emitter))
    }

    /// Follows the edge to its end.
    #[inline]
    pub fn arrive(&mut self, camera: &Camera, sampler: &mut impl Sampler, tally: &mut Tally) -> Arrival<'a> {
        let Some(mut point) = self.walk.arrive(sampler, tally) else {
            return Arrival::Infinity(self.weights.leave(&self.link, self.walk.ray.direction));
        };
        if let Departure::Camera = self.walk.departure {
            self.link.forward = camera.seen(point.p).map_or(0.0, |seen| f64::from(seen.magnification));
        }
        let ng = if planted(Defect::WeightsByShadingNormal) { point.frame.n } else { point.ng };
        let sums = self.weights.arrive(&self.link, point.p, ng, self.walk.ray.direction);
        let surface = self.scene.surface(&mut point, self.walk.ray.bodies);
        Arrival::Surface(Vertex {
            point,
            surface,
            known: -self.walk.ray.direction,
            beta: self.walk.beta,
            survival: self.walk.survival,
            bodies: self.walk.ray.bodies,
            sums,
            toward: self.walk.toward,
        })
    }

    /// Leaves `vertex`, where it has arrived, through the component that is returned; `None` where nothing scatters.
    #[inline]
    pub fn depart(&mut self, vertex: &Vertex, shading: &Shading, sampler: &mut impl Sampler) -> Option<Lobes> {
        let scatter = shading.sample(self.walk.scattering_numbers(&vertex.surface, sampler))?;
        let densities = shading.densities(&scatter);
        let SurfacePoint { p, ng, .. } = vertex.point;
        self.link = self.weights.from_vertex(vertex.sums, densities, scatter.density.is_delta(), p, ng);
        self.walk.depart(&vertex.point, &scatter);
        Some(scatter.lobe)
    }

    /// [`Subpath::depart`] and Russian roulette; `None` where the walk ends.
    #[inline]
    pub fn go_on(&mut self, vertex: &Vertex, shading: &Shading, sampler: &mut impl Sampler, tally: &mut Tally) -> Option<Lobes> {
        let lobe = self.depart(vertex, shading, sampler)?;
        self.walk.survives(sampler, tally).then_some(lobe)
    }
}
