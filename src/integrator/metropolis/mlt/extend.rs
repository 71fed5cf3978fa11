//! Subpath extension and joining for path mutations.

use super::super::ChainContext;
use crate::bsdf::shading::folds;
use crate::bsdf::{Folds, Lobes, Shading};
use crate::camera::LensPoint;
use crate::geometry::Ray;
use crate::light::LeRandom;
use crate::mcmc::Numbers;
use crate::path::{Emitter, FlightEnd, PathVertex, RandomWalk, Scatterer, SurfaceVertex, TraceStats, Vertex};
use crate::sampling::{IndependentSampler, unit_f32};
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use crate::transport::TransportMode;
use glam::{DVec3, Vec3};
use std::borrow::Cow;

/// Returns a random number in f32.
pub(super) fn single(numbers: &mut Numbers) -> f32 {
    unit_f32((numbers.bits() >> 32) as u32)
}

fn pair(numbers: &mut Numbers) -> [f32; 2] {
    [single(numbers), single(numbers)]
}

/// State for sampling further vertices.
pub(super) struct SubpathSampler<'w, 'a> {
    pub(super) common: &'w ChainContext<'a>,
    pub(super) numbers: &'w mut Numbers,
    pub(super) tally: &'w mut TraceStats,
}

/// Vertices and edges of a path, from one of its ends.
#[derive(Default)]
pub(super) struct SubpathBuffer {
    /// Point of the camera's lens, if the endpoint is the camera.
    pub(super) lens: LensPoint,
    /// Vertices from the endpoint inward, without the endpoint.
    pub(super) nodes: Vec<PathVertex>,
    /// One direction per vertex, in the direction of light flow.
    pub(super) directions: Vec<DVec3>,
}

/// End of a traced edge. Callers destructure it at once, so that its size does not matter.
#[allow(clippy::large_enum_variant)]
pub(super) enum RayEnd {
    Vertex(PathVertex),
    Outside,
}

impl SubpathBuffer {
    /// Starts at the point `lens` of the camera's lens.
    pub(super) fn at_camera(lens: LensPoint) -> Self {
        SubpathBuffer { lens, ..SubpathBuffer::default() }
    }
}

impl SubpathSampler<'_, '_> {
    /// Traces the current edge of `walk` to its end.
    fn follow(&mut self, mut walk: RandomWalk) -> Option<RayEnd> {
        let mut sampler = IndependentSampler::new(self.numbers.address());
        let end = if self.common.scene.features().flights() {
            walk.fly(&mut sampler, self.tally).end
        } else {
            walk.arrive(&mut sampler, self.tally).map(FlightEnd::Surface)
        };
        let vertex = match end {
            None => return Some(RayEnd::Outside),
            Some(FlightEnd::Medium(point)) => Vertex::Medium(point),
            Some(FlightEnd::Surface(mut point)) => {
                let state = walk.ray.state;
                let surface = Cow::Owned(self.common.scene.surface(&mut point, state.bodies).into_owned());
                if !point.consistent {
                    return None;
                }
                Vertex::Surface(SurfaceVertex { point, surface, state })
            }
        };
        Some(RayEnd::Vertex(PathVertex { vertex, lobe: Lobes::SMOOTH }))
    }

    /// Traces a ray that does not start at the camera.
    pub(super) fn along(&mut self, ray: Ray) -> Option<RayEnd> {
        self.follow(RandomWalk::from_light(self.common.scene, ray, Spectrum::ONE))
    }

    /// Traces the edge from `node` in the direction `w`.
    pub(super) fn leave(&mut self, node: &PathVertex, w: Vec3) -> Option<RayEnd> {
        self.along(node.vertex.spawn(self.common.scene, w)?)
    }

    /// Traces the camera ray from a point of the lens through a raster position.
    pub(super) fn through_film(&mut self, film: [f32; 2], lens: LensPoint) -> Option<(DVec3, RayEnd)> {
        let sample = self.common.camera.sample_ray(film, lens, 0.0);
        let walk = RandomWalk::from_camera(self.common.scene, &sample);
        Some((-sample.ray.direction.as_dvec3(), self.follow(walk)?))
    }

    /// Samples a point of the camera's lens.
    pub(super) fn lens(&mut self) -> LensPoint {
        self.common.camera.sample_lens(|| pair(self.numbers))
    }

    /// Samples a raster position uniformly.
    pub(super) fn film(&mut self) -> [f32; 2] {
        let u = pair(self.numbers);
        self.common.region.at(u)
    }

    /// Samples scattering at `node` and stores the component in it; `known` points to the previous vertex.
    pub(super) fn scatter(
        &mut self,
        node: &mut PathVertex,
        known: Vec3,
        mode: TransportMode,
    ) -> Option<(Vec3, RayEnd)> {
        let [u, v] = pair(self.numbers);
        let (direction, lobe) = match node.vertex.scatterer(known, mode)? {
            Scatterer::Surface(shading) => {
                let scatter = shading.sample([single(self.numbers), u, v])?;
                (scatter.direction, if scatter.density.is_delta() { scatter.lobe } else { Lobes::SMOOTH })
            }
            Scatterer::Medium(phase) => (phase.sample([u, v]).direction, Lobes::SMOOTH),
        };
        node.lobe = lobe;
        Some((direction, self.leave(node, direction)?))
    }

    /// Leaves `node` toward the light through the Dirac component `lobe`; `None` if the surface lacks it.
    pub(super) fn back_through(&mut self, node: &mut PathVertex, known: Vec3, lobe: Lobes) -> Option<(Vec3, RayEnd)> {
        self.through(node, known, TransportMode::Radiance, lobe, Folds { source: false, view: false })
    }

    /// Leaves `node` toward the camera through the Dirac component by which light leaves `like` along `wo`.
    pub(super) fn through_like(
        &mut self,
        node: &mut PathVertex,
        known: Vec3,
        like: &PathVertex,
        wo: Vec3,
    ) -> Option<(Vec3, RayEnd)> {
        let SurfaceVertex { point, surface, .. } = like.vertex.surface()?;
        let folds = folds(point, surface, wo, like.lobe)?;
        self.through(node, known, TransportMode::Importance, like.lobe, folds)
    }

    fn through(
        &mut self,
        node: &mut PathVertex,
        known: Vec3,
        mode: TransportMode,
        lobe: Lobes,
        folds: Folds,
    ) -> Option<(Vec3, RayEnd)> {
        let SurfaceVertex { point, surface, .. } = node.vertex.surface()?;
        let direction = Shading::new(point, surface, known, mode)?.dirac(lobe, folds)?;
        node.lobe = lobe;
        Some((direction, self.leave(node, direction)?))
    }

    /// Adds a vertex toward the light. Outside the scene only the edge is added, and `false` returned.
    pub(super) fn lengthen(&mut self, part: &mut SubpathBuffer) -> Option<bool> {
        let (w, met) = match part.nodes.last_mut() {
            None => {
                let film = self.film();
                self.through_film(film, part.lens)?
            }
            Some(node) => {
                let known = part.directions.last()?.as_vec3();
                let (w, met) = self.scatter(node, known, TransportMode::Radiance)?;
                (-w.as_dvec3(), met)
            }
        };
        part.directions.push(w);
        Some(part.add(met))
    }

    /// Adds a vertex toward the camera.
    pub(super) fn lengthen_light(&mut self, part: &mut SubpathBuffer) -> Option<()> {
        let known = -part.directions.last()?.as_vec3();
        let (w, met) = self.scatter(part.nodes.last_mut()?, known, TransportMode::Importance)?;
        part.directions.push(w.as_dvec3());
        part.add(met).then_some(())
    }

    /// Samples emission, and returns the endpoint with the first vertex hit.
    pub(super) fn sample_le(&mut self) -> Option<(Emitter, SubpathBuffer)> {
        let scene = self.common.scene;
        let (index, _) = scene.lights().choose_emitter(single(self.numbers))?;
        let numbers =
            LeRandom { side: single(self.numbers), position: pair(self.numbers), direction: pair(self.numbers) };
        let (emitted, _, emitter) = Emitter::emitting(scene, index, &numbers)?;
        let directions = vec![emitted.ray.direction.as_dvec3()];
        let mut part = SubpathBuffer { directions, ..SubpathBuffer::default() };
        let met = self.along(emitter.ray(scene, &emitted))?;
        part.add(met).then_some((emitter, part))
    }

    /// Samples a light from `node`, and returns the endpoint with its emission direction.
    pub(super) fn sample_light(&mut self, node: &PathVertex) -> Option<(Emitter, DVec3)> {
        Emitter::chosen(self.common.scene, &node.vertex.context()?, pair(self.numbers), || single(self.numbers))
    }
}

impl SubpathBuffer {
    /// Adds the end of an edge. Returns whether it is on a surface.
    pub(super) fn add(&mut self, met: RayEnd) -> bool {
        match met {
            RayEnd::Vertex(node) => {
                self.nodes.push(node);
                true
            }
            RayEnd::Outside => false,
        }
    }

    /// Returns the emitter hit by the last edge, on a surface or on the environment, and removes it together with the
    /// direction of this edge.
    pub(super) fn found_light(&mut self, scene: &Scene, is_surface: bool) -> Option<(Emitter, DVec3)> {
        let w = self.directions.pop()?;
        let emitter = if is_surface {
            Emitter::at(scene, &self.nodes.pop()?.vertex.surface()?.point, w.as_vec3())
        } else {
            Emitter::outside(scene, -w.as_vec3())
        };
        Some((emitter?, w))
    }
}
