//! Bidirectional path tracing: a walk from the camera, a walk from a light, and every connection between their vertices and with
//! the two ends, weighted so that each path counts once [Veach97 §10.3]. With connections to the camera alone it is light tracing.
//!
//! Use it where light arrives indirectly or through mirrors and glass: lamps behind shades, caustics, doors ajar. Where lights are
//! sampled well from everywhere the path tracer is faster, since it traces no rays from lights. What only chains of
//! mirrors on both sides of every smooth surface show (a caustic in a mirror, from a point light) no technique finds.

use super::camera_pass::Radiance;
use super::{Options, Prelude};
use crate::bsdf::Shading;
use crate::camera::Camera;
use crate::defects::{Defect, planted};
use crate::geometry::Ray;
use crate::light::Light;
use crate::path::{Arrival, Connection, Departure, Subpath, Sums, Tally, Techniques, Vertex, Walk, Weights};
use crate::path::{connect, next_event, splat};
use crate::sampling::{Sampler, Slot};
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use std::ops::RangeInclusive;

/// Light that a technique of `s` vertices from the light and `t` from the camera found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    pub(super) s: usize,
    pub(super) t: usize,
    /// f(x̄) over the density of the technique and over `survival`.
    pub(super) value: Spectrum,
    /// The technique's share.
    pub(super) weight: f64,
    /// The probability with which roulette let it be found.
    pub(super) survival: f32,
}

/// Where the light of techniques goes.
pub(super) trait Sink {
    /// Adds light to the sample.
    fn add(&mut self, found: Found);
    /// Adds light at a film position.
    fn splat(&mut self, film: [f32; 2], found: Found);
}

/// Roulette on connections begins below this share of a usual pixel. relMSE × CPU seconds at 0, .03, .1, .3, 1: .047, .045, .045, .046,
/// .069 on the modified Cornell box, .30, .28, .27, .26, .27 on the glass caustic, .91, .92, .91, .90, .87 on the ajar door.
const WORTHWHILE: f32 = 0.3;

/// No connection is traced less often than this. Numbers have 24 digits: a share with more would be met by 0 too often, and what is
/// divided by it overflow.
const LEAST_SHARE: f32 = 1.0 / 4096.0;

/// Where the numbers for roulette on connections begin, beyond those of all bounces.
const ROULETTE: u32 = 1 << 30;

/// The estimator.
#[derive(Clone)]
pub(super) struct Bidirectional<'a> {
    scene: &'a Scene,
    camera: Camera,
    weights: Weights,
    /// Scattering events of the shortest and longest paths that it makes.
    events: RangeInclusive<usize>,
    /// What a connection must be worth to be traced for certain: others are by the share that they are worth of it.
    worthwhile: f32,
    /// Whether the environment is left out where the camera sees it directly.
    transparent: bool,
}

impl<'a> Bidirectional<'a> {
    pub(super) fn new(scene: &'a Scene, camera: &Camera, options: &Options, prelude: &Prelude) -> Self {
        let Options { techniques, heuristic, .. } = *options;
        let weights = Weights { techniques, heuristic, light_walks: options.pixels() as f64 };
        let events = 0..=options.max_depth.map_or(usize::MAX, |d| d as usize);
        let worthwhile = WORTHWHILE * prelude.typical;
        let (camera, transparent) = (camera.clone(), options.transparent);
        Bidirectional { scene, camera, weights, events, worthwhile, transparent }
    }

    /// The same for paths of at least `fewest` scattering events.
    pub(super) fn with_fewest_events(self, fewest: usize) -> Self {
        Bidirectional { events: fewest..=*self.events.end(), ..self }
    }

    /// What its weights have in common.
    pub(super) fn weights(&self) -> &Weights {
        &self.weights
    }

    /// Whether a path of `s` vertices from the light and `t` from the camera is short enough and its technique takes part.
    #[inline]
    pub(super) fn wants(&self, s: usize, t: usize) -> bool {
        let events = (s + t).saturating_sub(2) - usize::from(planted(Defect::SplatsOneDeeper) && t == 1);
        self.weights.techniques.has(s, t) && self.events.contains(&events)
    }

    /// All that a sample along the camera ray `ray` finds.
    pub(super) fn sample<S: Sampler>(
        &self,
        ray: Ray,
        sampler: &mut S,
        light: impl FnOnce() -> S,
        sink: &mut impl Sink,
        tally: &mut Tally,
    ) {
        let Techniques { connect, splat, .. } = self.weights.techniques;
        let from_light = if connect || splat { self.light_walk(&mut light(), tally) } else { Vec::new() };
        self.splats(&from_light, sink, tally);
        self.camera_walk(ray, &from_light, sampler, sink, tally);
    }

    /// What the technique of `s` and `t` vertices finds alone, without roulette. It takes the same numbers as [`Bidirectional::sample`].
    pub(super) fn technique(
        &self,
        [s, t]: [usize; 2],
        ray: Ray,
        camera: &mut impl Sampler,
        light: &mut impl Sampler,
        sink: &mut impl Sink,
        tally: &mut Tally,
    ) {
        let y = if s < 2 {
            None
        } else {
            let Some((path, _)) = Subpath::from_light(self.scene, &self.weights, light) else { return };
            let Some(Arrival::Surface(y)) = self.walked(path, s - 1, light, tally).map(|(_, arrival)| arrival) else { return };
            Some(y).filter(Vertex::is_connectible)
        };
        if t == 1 {
            return self.splats(y.as_slice(), sink, tally);
        }
        if s >= 2 && y.is_none() {
            return;
        }
        let path = Subpath::from_camera(self.scene, &self.weights, ray);
        match self.walked(path, t - 1, camera, tally) {
            Some((path, Arrival::Infinity(sums))) if s == 0 => self.background(&path, &sums, sink),
            Some((path, Arrival::Surface(z))) if s == 0 => self.emitted(&path, &z, sink),
            Some((_, Arrival::Surface(z))) if z.is_connectible() => {
                let Some(shading) = z.shading() else { return };
                let found = match &y {
                    Some(y) => connect(self.scene, &self.weights, y, &z, &shading),
                    None => next_event(self.scene, &self.weights, &z, &shading, camera),
                };
                self.traced([s, t], found, sink, tally);
            }
            _ => {}
        }
    }

    /// `path` at the end of its edge number `edge`, or outside the scene there; `None` if it does not come so far.
    fn walked<'s>(
        &self,
        mut path: Subpath<'s>,
        edge: usize,
        sampler: &mut impl Sampler,
        tally: &mut Tally,
    ) -> Option<(Subpath<'s>, Arrival<'s>)> {
        for _ in 1..edge {
            let Arrival::Surface(vertex) = path.arrive(&self.camera, sampler, tally) else { return None };
            path.depart(&vertex, &vertex.shading()?, sampler)?;
        }
        let arrival = path.arrive(&self.camera, sampler, tally);
        Some((path, arrival))
    }

    /// Hands over what was `found`, as far as nothing is in the way.
    fn traced(&self, [s, t]: [usize; 2], found: Option<Connection>, sink: &mut impl Sink, tally: &mut Tally) {
        if let Some(Connection { value, weight, survival, segment }) = found {
            let through = self.scene.transmittance(&segment, &mut tally.shadows);
            sink.add(Found { s, t, value: value * through, weight, survival });
        }
    }

    /// The vertices of a walk from a light that can be connected, each with its number.
    fn light_walk(&self, sampler: &mut impl Sampler, tally: &mut Tally) -> Vec<Vertex<'a>> {
        let mut vertices = Vec::new();
        let Some((mut path, _)) = Subpath::from_light(self.scene, &self.weights, sampler) else { return vertices };
        while let Arrival::Surface(vertex) = path.arrive(&self.camera, sampler, tally) {
            let longest = vertex.sums.index as usize >= *self.events.end();
            let goes_on =
                !longest && vertex.shading().is_some_and(|shading| path.go_on(&vertex, &shading, sampler, tally).is_some());
            if vertex.is_connectible() {
                vertices.push(vertex);
            }
            if !goes_on {
                break;
            }
        }
        vertices
    }

    /// Connects the vertices of a walk from a light with the camera.
    fn splats(&self, from_light: &[Vertex], sink: &mut impl Sink, tally: &mut Tally) {
        for y in from_light {
            let s = y.sums.index as usize + 1;
            if !self.wants(s, 1) {
                continue;
            }
            let Some(found) = splat(self.scene, &self.weights, &self.camera, y) else { continue };
            let through = self.scene.transmittance_to_camera(&found.connection.segment, &mut tally.shadows);
            let Connection { value, weight, survival, .. } = found.connection;
            sink.splat(found.film, Found { s, t: 1, value: value * through, weight, survival });
        }
    }

    /// Walks from the camera and connects each vertex with all that `from_light` has.
    fn camera_walk(&self, ray: Ray, from_light: &[Vertex], sampler: &mut impl Sampler, sink: &mut impl Sink, tally: &mut Tally) {
        let mut path = Subpath::from_camera(self.scene, &self.weights, ray);
        let Techniques { hit, next_event, connect, .. } = self.weights.techniques;
        loop {
            let z = match path.arrive(&self.camera, sampler, tally) {
                Arrival::Surface(vertex) => vertex,
                Arrival::Infinity(sums) => return self.background(&path, &sums, sink),
            };
            self.emitted(&path, &z, sink);
            if !(hit || next_event || connect) || z.sums.index as usize > *self.events.end() {
                return;
            }
            let Some(shading) = z.shading() else { return };
            if z.is_connectible() {
                self.connections(&z, &shading, from_light, sampler, sink, tally);
            }
            if path.go_on(&z, &shading, sampler, tally).is_none() {
                return;
            }
        }
    }

    /// Connects `z` with a light and with each vertex of `from_light`.
    fn connections(
        &self,
        z: &Vertex,
        shading: &Shading,
        from_light: &[Vertex],
        sampler: &mut impl Sampler,
        sink: &mut impl Sink,
        tally: &mut Tally,
    ) {
        let t = z.sums.index as usize + 1;
        if self.wants(1, t) {
            self.traced([1, t], next_event(self.scene, &self.weights, z, shading, sampler), sink, tally);
        }
        for y in from_light {
            let s = y.sums.index as usize + 1;
            if self.wants(s, t) {
                let found = connect(self.scene, &self.weights, y, z, shading);
                self.traced([s, t], found.and_then(|found| self.played(found, sampler, s, t)), sink, tally);
            }
        }
    }

    /// Russian roulette on what `found` is worth, before its ray is traced.
    #[inline]
    fn played(&self, found: Connection, sampler: &mut impl Sampler, s: usize, t: usize) -> Option<Connection> {
        let worth = found.value.max_lane() * found.weight as f32;
        if worth >= self.worthwhile || worth.is_nan() {
            return Some(found);
        }
        let share = (worth / self.worthwhile).max(LEAST_SHARE);
        let u = sampler.u1(ROULETTE + ((s as u32) << 16) + t as u32, Slot::Roulette);
        (u < share).then(|| Connection { value: found.value / share, survival: found.survival * share, ..found })
    }

    /// What the surface at `z` emits toward the walk.
    fn emitted(&self, path: &Subpath, z: &Vertex, sink: &mut impl Sink) {
        let t = z.sums.index as usize + 1;
        let Some((index, light)) = self.scene.light_at(&z.point) else { return };
        let Light::Area(area) = light else { return };
        let radiance = area.radiance(z.point.barycentric, z.known);
        if radiance.is_black() || !self.wants(0, t) || !path.walk.sees(area) {
            return;
        }
        let density = light.emission_density(self.scene.ball(), z.known);
        let [direct, end] = self.probabilities(&path.walk, index).map(|pmf| pmf * density.end);
        let weight = self.weights.hit(&z.sums, direct, end, density.ray);
        sink.add(Found { s: 0, t, value: z.beta * radiance, weight, survival: z.survival });
    }

    /// What arrives from outside the scene.
    fn background(&self, path: &Subpath, sums: &Sums, sink: &mut impl Sink) {
        let t = sums.index as usize + 1;
        let Some((index, environment)) = self.scene.lights().environment() else { return };
        if !self.wants(0, t) || self.transparent && t == 2 {
            return;
        }
        let w = path.walk.ray.direction;
        let (radiance, pdf) = environment.along(w);
        let ray = self.scene.lights().all()[index].ray_density(self.scene.ball(), -w);
        let [direct, end] = self.probabilities(&path.walk, index).map(|pmf| pmf * f64::from(pdf.value()));
        let weight = self.weights.hit(sums, direct, end, ray);
        sink.add(Found { s: 0, t, value: path.walk.beta * radiance, weight, survival: path.walk.survival });
    }

    /// Probabilities of light `index`: to be chosen where the edge of `walk` begins, and to emit.
    fn probabilities(&self, walk: &Walk, index: usize) -> [f64; 2] {
        let lights = self.scene.lights();
        let emitter = lights.emitter_pmf(index);
        let direct = if let Departure::Surface(receiver, _) = &walk.departure { lights.pmf(receiver, index) } else { emitter };
        [direct, emitter].map(|pmf| f64::from(pmf.value()))
    }
}

/// The weighted sum: what renders are made of.
struct Weighted<'a, F> {
    color: Spectrum,
    splats: &'a mut F,
}

impl<F: FnMut([f32; 2], Spectrum)> Sink for Weighted<'_, F> {
    #[inline]
    fn add(&mut self, found: Found) {
        self.color += found.value * found.weight as f32;
    }

    #[inline]
    fn splat(&mut self, film: [f32; 2], found: Found) {
        if !found.value.is_black() {
            (self.splats)(film, found.value * found.weight as f32);
        }
    }
}

impl Radiance for Bidirectional<'_> {
    fn radiance<S: Sampler>(
        &self,
        ray: Ray,
        sampler: &mut S,
        light: impl FnOnce() -> S,
        splats: &mut impl FnMut([f32; 2], Spectrum),
        tally: &mut Tally,
    ) -> Spectrum {
        let mut sink = Weighted { color: Spectrum::ZERO, splats };
        self.sample(ray, sampler, light, &mut sink, tally);
        sink.color
    }
}
