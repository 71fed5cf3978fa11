//! Walks that lengthen part of a path, and what is joined of them.

use super::super::Common;
use super::state::{Draft, PathState};
use crate::bsdf::shading::folds;
use crate::bsdf::{Folds, Lobes, Shading};
use crate::geometry::Ray;
use crate::light::EmissionNumbers;
use crate::mcmc::Numbers;
use crate::path::{Emitter, Node, Tally, Walk};
use crate::sampling::{Independent, unit_f32};
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use crate::transport::Transport;
use glam::{DVec3, Vec3};

/// A number for what takes f32.
pub(super) fn single(numbers: &mut Numbers) -> f32 {
    unit_f32((numbers.bits() >> 32) as u32)
}

fn pair(numbers: &mut Numbers) -> [f32; 2] {
    [single(numbers), single(numbers)]
}

/// What is needed to go on.
pub(super) struct Walker<'w, 'a> {
    pub(super) common: &'w Common<'a>,
    pub(super) numbers: &'w mut Numbers,
    pub(super) tally: &'w mut Tally,
}

/// Vertices and edges of a path from one of its ends on.
#[derive(Default)]
pub(super) struct Part {
    /// From the end inward, the end not among them.
    pub(super) nodes: Vec<Node>,
    /// One to each node, as light flows.
    pub(super) directions: Vec<DVec3>,
}

/// Where an edge leads. It is taken apart where it is made, so that it need not be small.
#[allow(clippy::large_enum_variant)]
pub(super) enum Met {
    Surface(Node),
    Outside,
}

impl Part {
    /// x_{k−1} … x_b.
    pub(super) fn from_camera(x: &PathState, b: usize) -> Self {
        let (path, k) = (x.path(), x.k());
        let nodes = path.nodes()[b - 1..].iter().rev().cloned().collect();
        Part { nodes, directions: path.directions()[b..k].iter().rev().copied().collect() }
    }

    /// x₁ … x_{a−1}.
    pub(super) fn from_light(x: &PathState, a: usize) -> Self {
        let path = x.path();
        Part { nodes: path.nodes()[..a - 1].to_vec(), directions: path.directions()[..a - 1].to_vec() }
    }

    /// The path of `light`, one edge in the direction `across`, and `camera`.
    pub(super) fn join(emitter: Emitter, light: Part, across: DVec3, camera: Part) -> Draft {
        let (mut nodes, mut directions) = (light.nodes, light.directions);
        nodes.extend(camera.nodes.into_iter().rev());
        directions.push(across);
        directions.extend(camera.directions.into_iter().rev());
        Draft { emitter, nodes, directions }
    }
}

impl Walker<'_, '_> {
    /// Where `ray` of the camera or of anything else leads.
    fn follow(&mut self, mut walk: Walk) -> Option<Met> {
        let mut sampler = Independent::new(self.numbers.address());
        let Some(mut point) = walk.arrive(&mut sampler, self.tally) else { return Some(Met::Outside) };
        let surface = self.common.scene.surface(&mut point, walk.ray.bodies).into_owned();
        point.consistent.then_some(Met::Surface(Node { point, bodies: walk.ray.bodies, surface, lobe: Lobes::SMOOTH }))
    }

    /// Along a ray that is not the camera's.
    pub(super) fn along(&mut self, ray: Ray) -> Option<Met> {
        self.follow(Walk::from_light(self.common.scene, ray, Spectrum::ONE))
    }

    /// From `node` in the direction `w`.
    pub(super) fn leave(&mut self, node: &Node, w: Vec3) -> Option<Met> {
        let bodies = self.common.scene.bodies_toward(&node.point, node.bodies, w);
        self.along(Ray { bodies, ..node.point.spawn(w) })
    }

    /// Through a film position.
    pub(super) fn through_film(&mut self, film: [f32; 2]) -> Option<(DVec3, Met)> {
        let ray = self.common.camera.ray(film);
        Some((-ray.direction.as_dvec3(), self.follow(Walk::new(self.common.scene, ray))?))
    }

    /// Anywhere on the film.
    pub(super) fn film(&mut self) -> [f32; 2] {
        let u = pair(self.numbers);
        self.common.region.at(u)
    }

    /// Leaves `node` by its own choice, which it keeps; `known` leads to where the walk came from.
    pub(super) fn scatter(&mut self, node: &mut Node, known: Vec3, toward: Transport) -> Option<(Vec3, Met)> {
        let shading = Shading::new(&node.point, &node.surface, known, toward)?;
        let [u, v] = pair(self.numbers);
        let scatter = shading.sample([single(self.numbers), u, v])?;
        node.lobe = if scatter.density.is_delta() { scatter.lobe } else { Lobes::SMOOTH };
        Some((scatter.direction, self.leave(node, scatter.direction)?))
    }

    /// Leaves `node` toward the light through the Dirac component `lobe`; `None` if it has none.
    pub(super) fn back_through(&mut self, node: &mut Node, known: Vec3, lobe: Lobes) -> Option<(Vec3, Met)> {
        self.through(node, known, Transport::Light, lobe, Folds { source: false, view: false })
    }

    /// Leaves `node` toward the camera through the Dirac component by which light leaves `like` along `wo`.
    pub(super) fn through_like(&mut self, node: &mut Node, known: Vec3, like: &Node, wo: Vec3) -> Option<(Vec3, Met)> {
        let folds = folds(&like.point, &like.surface, wo, like.lobe)?;
        self.through(node, known, Transport::Camera, like.lobe, folds)
    }

    fn through(&mut self, node: &mut Node, known: Vec3, toward: Transport, lobe: Lobes, folds: Folds) -> Option<(Vec3, Met)> {
        let direction = Shading::new(&node.point, &node.surface, known, toward)?.dirac(lobe, folds)?;
        node.lobe = lobe;
        Some((direction, self.leave(node, direction)?))
    }

    /// One vertex more toward the light; where that leads outside the scene only the edge is added, and `false` returned.
    pub(super) fn lengthen(&mut self, part: &mut Part) -> Option<bool> {
        let (w, met) = match part.nodes.last_mut() {
            None => {
                let film = self.film();
                self.through_film(film)?
            }
            Some(node) => {
                let known = part.directions.last()?.as_vec3();
                let (w, met) = self.scatter(node, known, Transport::Light)?;
                (-w.as_dvec3(), met)
            }
        };
        part.directions.push(w);
        Some(part.add(met))
    }

    /// One vertex more toward the camera.
    pub(super) fn lengthen_light(&mut self, part: &mut Part) -> Option<()> {
        let known = -part.directions.last()?.as_vec3();
        let (w, met) = self.scatter(part.nodes.last_mut()?, known, Transport::Camera)?;
        part.directions.push(w.as_dvec3());
        part.add(met).then_some(())
    }

    /// A light as it emits, and the first vertex that it falls on.
    pub(super) fn emit(&mut self) -> Option<(Emitter, Part)> {
        let scene = self.common.scene;
        let (index, _) = scene.lights().choose_emitter(single(self.numbers))?;
        let light = &scene.lights().all()[index];
        let numbers = EmissionNumbers { side: single(self.numbers), position: pair(self.numbers), direction: pair(self.numbers) };
        let emitted = light.emit(scene.ball(), &numbers)?;
        let density = light.emission_density(scene.ball(), emitted.ray.direction);
        let emitter = Emitter::of_emission(index, &emitted, &density);
        let mut part = Part { nodes: Vec::new(), directions: vec![emitted.ray.direction.as_dvec3()] };
        let met = self.along(Emitter::ray(scene, &emitted))?;
        part.add(met).then_some((emitter, part))
    }

    /// A light as `node` chooses it, and the direction in which it shines.
    pub(super) fn sample_light(&mut self, node: &Node) -> Option<(Emitter, DVec3)> {
        Emitter::chosen(self.common.scene, &node.point, single(self.numbers), pair(self.numbers))
    }
}

impl Part {
    /// Adds what an edge met; whether that is a surface.
    pub(super) fn add(&mut self, met: Met) -> bool {
        match met {
            Met::Surface(node) => {
                self.nodes.push(node);
                true
            }
            Met::Outside => false,
        }
    }

    /// The light that its last edge found, at a surface or outside the scene; it is taken away together with that edge's direction.
    pub(super) fn found_light(&mut self, scene: &Scene, is_surface: bool) -> Option<(Emitter, DVec3)> {
        let w = self.directions.pop()?;
        let emitter = if is_surface {
            Emitter::at(scene, &self.nodes.pop()?.point, w.as_vec3())
        } else {
            Emitter::outside(scene, -w.as_vec3())
        };
        Some((emitter?, w))
    }
}
