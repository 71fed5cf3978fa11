//! Bidirectional path tracing: a camera subpath, a light subpath, all connections between their vertices and to the two
//! endpoints, combined by MIS [Veach97 §10.3]. With connections to the camera alone it is light tracing.
//!
//! It suits indirect light and light through mirrors and glass: lamps behind shades, caustics, doors ajar. Where
//! next-event estimation is effective everywhere the path tracer is faster, since it traces no light subpaths. No
//! technique samples paths whose smooth vertices all lie between Dirac vertices, such as a caustic from a point light
//! seen in a mirror.

use super::camera_pass::Radiance;
use super::{BdptConfig, IntegratorConfig, PilotEstimate};
use crate::camera::{Camera, CameraSample};
use crate::light::{EmitterPoint, Light};
use crate::path::{
    Arrival, Connection, MisStrategy, PartialMis, PreviousVertex, RandomWalk, Scatterer, Subpath, SubpathVertex,
    Techniques, TraceStats, Vertex,
};
use crate::path::{SurfaceVertex, connect, next_event, splat};
use crate::sampling::{Sampler, Slot};
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use std::ops::RangeInclusive;

/// Contribution of the technique with `s` light vertices and `t` camera vertices.
#[derive(Debug, Clone, Copy)]
pub(super) struct TechniqueSample {
    pub(super) s: usize,
    pub(super) t: usize,
    /// f(x̄) divided by the density of the technique and by `survival`.
    pub(super) value: Spectrum,
    /// MIS weight of the technique.
    pub(super) weight: f64,
    /// Probability that roulette kept the sample.
    pub(super) survival: f32,
}

/// Receives the contributions of techniques.
pub(super) trait Sink {
    /// Adds a contribution to the current sample.
    fn add(&mut self, found: TechniqueSample);
    /// Adds a contribution at a raster position.
    fn splat(&mut self, film: [f32; 2], found: TechniqueSample);
}

/// Contributions below this share of a typical pixel undergo connection roulette. relMSE × CPU seconds at 0, .03, .1,
/// .3, 1: .047, .045, .045, .046, .069 on the modified Cornell box, .30, .28, .27, .26, .27 on the glass caustic, .91,
/// .92, .91, .90, .87 on the ajar door.
const WORTHWHILE: f32 = 0.3;

/// Least survival probability of connection roulette. Random numbers have 24 bits. A smaller probability would be
/// passed too often, by the random number 0, and the division by it would overflow.
const LEAST_SHARE: f32 = 1.0 / 4096.0;

/// First address of the random numbers of connections, beyond those of all bounces.
const CONNECTIONS: u32 = 1 << 30;

/// Returns the address of the random numbers of the connection between the s-th and the t-th vertex.
fn connection(s: usize, t: usize) -> u32 {
    CONNECTIONS + ((s as u32) << 16) + t as u32
}

/// The bidirectional estimator.
#[derive(Clone)]
pub(super) struct Bidirectional<'a> {
    scene: &'a Scene,
    camera: Camera,
    weights: MisStrategy,
    /// Numbers of scattering events of the sampled paths.
    events: RangeInclusive<usize>,
    /// Contribution from which a connection is always traced. Smaller ones survive with probability
    /// contribution / `worthwhile`.
    worthwhile: f32,
    /// Whether the directly visible environment is left out.
    transparent: bool,
}

impl<'a> Bidirectional<'a> {
    pub(super) fn new(scene: &'a Scene, camera: &Camera, options: &IntegratorConfig, pilot: &PilotEstimate) -> Self {
        let BdptConfig { techniques, heuristic } = options.method.bdpt();
        let weights = MisStrategy { techniques, heuristic, light_walks: options.pixels() as f64 };
        let events = 0..=options.max_depth.map_or(usize::MAX, |d| d as usize);
        let worthwhile = WORTHWHILE * pilot.typical;
        let (camera, transparent) = (camera.clone(), options.transparent);
        Bidirectional { scene, camera, weights, events, worthwhile, transparent }
    }

    /// Restricts the estimator to paths of at least `fewest` scattering events.
    pub(super) fn with_fewest_events(self, fewest: usize) -> Self {
        Bidirectional { events: fewest..=*self.events.end(), ..self }
    }

    /// Returns the shared MIS parameters.
    pub(super) fn weights(&self) -> &MisStrategy {
        &self.weights
    }

    /// Whether the technique with `s` light vertices and `t` camera vertices is enabled and its paths are within the
    /// length limits.
    #[inline]
    pub(super) fn is_enabled(&self, s: usize, t: usize) -> bool {
        let events = (s + t).saturating_sub(2);
        self.weights.techniques.has(s, t) && self.events.contains(&events)
    }

    /// Evaluates all techniques for a sample of the camera.
    pub(super) fn sample<S: Sampler>(
        &self,
        camera: &CameraSample,
        sampler: &mut S,
        light: impl FnOnce() -> S,
        sink: &mut impl Sink,
        tally: &mut TraceStats,
    ) {
        let Techniques { connect, splat, .. } = self.weights.techniques;
        let mut from_light = Vec::new();
        if connect || splat {
            let mut light = light();
            from_light = self.light_walk(&mut light, tally);
            self.splats(&from_light, &mut light, sink, tally);
        }
        self.camera_walk(camera, &from_light, sampler, sink, tally);
    }

    /// Evaluates the technique of `s` and `t` vertices alone, without roulette. Uses the same random numbers as
    /// [`Bidirectional::sample`].
    pub(super) fn technique(
        &self,
        [s, t]: [usize; 2],
        sample: &CameraSample,
        camera: &mut impl Sampler,
        light: &mut impl Sampler,
        sink: &mut impl Sink,
        tally: &mut TraceStats,
    ) {
        let y = if s < 2 {
            None
        } else {
            let Some((path, _)) = Subpath::from_light(self.scene, &self.weights, light) else { return };
            let Some(Arrival::Vertex(y)) = self.subpath_end(path, s - 1, light, tally).map(|(_, arrival)| arrival)
            else {
                return;
            };
            Some(y).filter(|y| y.vertex.is_connectible())
        };
        if t == 1 {
            return self.splats(y.as_slice(), light, sink, tally);
        }
        if s >= 2 && y.is_none() {
            return;
        }
        let path = Subpath::from_camera(self.scene, &self.weights, sample);
        match self.subpath_end(path, t - 1, camera, tally) {
            Some((path, Arrival::Infinity(sums))) if s == 0 => {
                self.emitted_in_media(&path, &sums, sink);
                self.background(&path, &sums, sink);
            }
            Some((path, Arrival::Vertex(z))) if s == 0 => {
                self.emitted_in_media(&path, &z.sums, sink);
                self.emitted(&path, &z, sink);
            }
            Some((_, Arrival::Vertex(z))) if z.vertex.is_connectible() => {
                let Some(scatterer) = z.scatterer() else { return };
                let found = match &y {
                    Some(y) => connect(&self.weights, y, &z, &scatterer),
                    None => next_event(self.scene, &self.weights, &z, &scatterer, camera),
                };
                self.trace_connection([s, t], found, sink, tally);
            }
            _ => {}
        }
    }

    /// Extends `path` to the end of its edge number `edge`, at a surface or at infinity; `None` if the walk ends
    /// earlier.
    fn subpath_end<'s>(
        &self,
        mut path: Subpath<'s>,
        edge: usize,
        sampler: &mut impl Sampler,
        tally: &mut TraceStats,
    ) -> Option<(Subpath<'s>, Arrival<'s>)> {
        for _ in 1..edge {
            let Arrival::Vertex(vertex) = path.arrive(&self.camera, sampler, tally) else { return None };
            path.depart(&vertex, &vertex.scatterer()?, sampler)?;
        }
        let arrival = path.arrive(&self.camera, sampler, tally);
        Some((path, arrival))
    }

    /// Tests the visibility of the connection `found` and passes its contribution to `sink`.
    fn trace_connection(
        &self,
        [s, t]: [usize; 2],
        found: Option<Connection>,
        sink: &mut impl Sink,
        tally: &mut TraceStats,
    ) {
        let Some(found) = found else { return };
        if let Some(sample) = self.traced([s, t], &found, tally) {
            sink.add(sample);
        }
    }

    /// Returns the contribution of the connection `found` as far as it is visible.
    #[inline(always)]
    fn traced(&self, [s, t]: [usize; 2], found: &Connection, tally: &mut TraceStats) -> Option<TechniqueSample> {
        let &Connection { value, survival, .. } = found;
        let edge = found.edge(self.scene)?;
        let clear = self.scene.clearance(&edge, &mut tally.shadows);
        let (value, weight) = (value * clear.through, found.weight(&self.weights, clear.flight));
        Some(TechniqueSample { s, t, value, weight, survival })
    }

    /// Traces a light subpath and returns its connectible vertices.
    fn light_walk(&self, sampler: &mut impl Sampler, tally: &mut TraceStats) -> Vec<SubpathVertex<'a>> {
        let mut vertices = Vec::new();
        let Some((mut path, _)) = Subpath::from_light(self.scene, &self.weights, sampler) else { return vertices };
        loop {
            // Borrowed, since a vertex is large.
            let arrival = path.arrive(&self.camera, sampler, tally);
            let Arrival::Vertex(vertex) = &arrival else { break };
            let longest = vertex.sums.index as usize >= *self.events.end();
            let goes_on = !longest
                && vertex
                    .scatterer()
                    .as_ref()
                    .is_some_and(|scatterer| path.go_on(vertex, scatterer, sampler, tally).is_some());
            if vertex.vertex.is_connectible() {
                vertices.extend(arrival.vertex());
            }
            if !goes_on {
                break;
            }
        }
        vertices
    }

    /// Connects the vertices of a light subpath to the camera.
    fn splats(
        &self,
        from_light: &[SubpathVertex],
        sampler: &mut impl Sampler,
        sink: &mut impl Sink,
        tally: &mut TraceStats,
    ) {
        for y in from_light {
            let s = y.sums.index as usize + 1;
            if !self.is_enabled(s, 1) {
                continue;
            }
            let lens = self.camera.sample_lens(|| sampler.u2(y.sums.index, Slot::Lens));
            let Some(found) = splat(self.scene, &self.weights, &self.camera, lens, y) else { continue };
            if let Some(sample) = self.traced([s, 1], &found.connection, tally) {
                sink.splat(found.film, sample);
            }
        }
    }

    /// Traces a camera subpath and connects each vertex to those of `from_light`.
    fn camera_walk(
        &self,
        camera: &CameraSample,
        from_light: &[SubpathVertex],
        sampler: &mut impl Sampler,
        sink: &mut impl Sink,
        tally: &mut TraceStats,
    ) {
        let mut path = Subpath::from_camera(self.scene, &self.weights, camera);
        let Techniques { hit, next_event, connect, .. } = self.weights.techniques;
        loop {
            let arrival = path.arrive(&self.camera, sampler, tally);
            let z = match &arrival {
                Arrival::Vertex(vertex) => vertex,
                Arrival::Infinity(sums) => {
                    self.emitted_in_media(&path, sums, sink);
                    return self.background(&path, sums, sink);
                }
            };
            self.emitted_in_media(&path, &z.sums, sink);
            self.emitted(&path, z, sink);
            if !(hit || next_event || connect) || z.sums.index as usize > *self.events.end() {
                return;
            }
            let Some(scatterer) = &z.scatterer() else { return };
            if z.vertex.is_connectible() {
                self.connections(z, scatterer, from_light, sampler, sink, tally);
            }
            if path.go_on(z, scatterer, sampler, tally).is_none() {
                return;
            }
        }
    }

    /// Connects `z` to a light sample and to each vertex of `from_light`.
    fn connections(
        &self,
        z: &SubpathVertex,
        scatterer: &Scatterer,
        from_light: &[SubpathVertex],
        sampler: &mut impl Sampler,
        sink: &mut impl Sink,
        tally: &mut TraceStats,
    ) {
        let t = z.sums.index as usize + 1;
        if self.is_enabled(1, t) {
            let found = next_event(self.scene, &self.weights, z, scatterer, sampler);
            self.trace_connection([1, t], found, sink, tally);
        }
        for y in from_light {
            let s = y.sums.index as usize + 1;
            if self.is_enabled(s, t) {
                let found = connect(&self.weights, y, z, scatterer);
                let found = found.and_then(|found| self.connection_roulette(found, sampler, s, t));
                self.trace_connection([s, t], found, sink, tally);
            }
        }
    }

    /// Russian roulette by weighted contribution, before the shadow ray is traced.
    #[inline]
    fn connection_roulette<'v>(
        &self,
        found: Connection<'v>,
        sampler: &mut impl Sampler,
        s: usize,
        t: usize,
    ) -> Option<Connection<'v>> {
        // As if the edge were clear.
        let worth = found.value.max_lane() * found.clear_weight as f32;
        if worth >= self.worthwhile || worth.is_nan() {
            return Some(found);
        }
        let share = (worth / self.worthwhile).max(LEAST_SHARE);
        let u = sampler.u1(connection(s, t), Slot::Roulette);
        (u < share).then(|| found.survived(share))
    }

    /// Adds the radiance emitted at `z` toward the walk.
    fn emitted(&self, path: &Subpath, z: &SubpathVertex, sink: &mut impl Sink) {
        let t = z.sums.index as usize + 1;
        let Vertex::Surface(SurfaceVertex { point, .. }) = &z.vertex else { return };
        let Some((index, light)) = self.scene.light_at(point) else { return };
        let Light::Area(area) = light else { return };
        let radiance = area.radiance(point.barycentric, z.known);
        if radiance.is_black() || !self.is_enabled(0, t) || !path.walk.sees(area) {
            return;
        }
        let end = EmitterPoint::from(point);
        let density = light.pdf_le(self.scene.ball(), &end, z.known);
        let ends = self.end_pdfs(&path.walk, index, &end, density.position);
        let weight = self.weights.hit(&z.sums, ends, density.direction);
        sink.add(TechniqueSample { s: 0, t, value: z.beta * radiance, weight, survival: z.survival });
    }

    /// Adds what media emit on the last edge of `path`, which no other technique samples.
    fn emitted_in_media(&self, path: &Subpath, sums: &PartialMis, sink: &mut impl Sink) {
        let t = sums.index as usize + 1;
        if !path.emitted.is_black() && self.is_enabled(0, t) {
            sink.add(TechniqueSample { s: 0, t, value: path.emitted, weight: 1.0, survival: path.walk.survival });
        }
    }

    /// Adds the radiance of the environment.
    fn background(&self, path: &Subpath, sums: &PartialMis, sink: &mut impl Sink) {
        let t = sums.index as usize + 1;
        let Some((index, environment)) = self.scene.lights().environment() else { return };
        if !self.is_enabled(0, t) || self.transparent && t == 2 {
            return;
        }
        let w = path.walk.ray.direction;
        let (radiance, pdf) = environment.along(w);
        let ray = self.scene.lights().all()[index].ray_density(self.scene.ball(), -w);
        let ends = self.end_pdfs(&path.walk, index, &EmitterPoint::Distant, f64::from(pdf.value()));
        let weight = self.weights.hit(sums, ends, ray);
        sink.add(TechniqueSample { s: 0, t, value: path.walk.beta * radiance, weight, survival: path.walk.survival });
    }

    /// Returns the densities of the point `end` of light `index`, where the current edge of `walk` ends: under
    /// next-event estimation at the edge's start, 0 at the camera, where there is none, and under emission sampling,
    /// where its [`LePdf::position`](crate::light::LePdf::position) is `position`.
    fn end_pdfs(&self, walk: &RandomWalk, index: usize, end: &EmitterPoint, position: f64) -> [f64; 2] {
        let lights = self.scene.lights();
        let direct = match &walk.departure {
            PreviousVertex::Scattered(at, _) => lights.end_pdf_li(at, index, end, walk.ray.direction, position),
            PreviousVertex::Camera | PreviousVertex::Light => 0.0,
        };
        [direct, f64::from(lights.emitter_pmf(index).value()) * position]
    }
}

/// Accumulates the MIS-weighted sum for renders.
struct Weighted<'a, F> {
    color: Spectrum,
    splats: &'a mut F,
}

impl<F: FnMut([f32; 2], Spectrum)> Sink for Weighted<'_, F> {
    #[inline]
    fn add(&mut self, found: TechniqueSample) {
        self.color += found.value * found.weight as f32;
    }

    #[inline]
    fn splat(&mut self, film: [f32; 2], found: TechniqueSample) {
        if !found.value.is_black() {
            (self.splats)(film, found.value * found.weight as f32);
        }
    }
}

impl Radiance for Bidirectional<'_> {
    fn radiance<S: Sampler>(
        &self,
        camera: &CameraSample,
        sampler: &mut S,
        light: impl FnOnce() -> S,
        splats: &mut impl FnMut([f32; 2], Spectrum),
        tally: &mut TraceStats,
    ) -> Spectrum {
        let mut sink = Weighted { color: Spectrum::ZERO, splats };
        self.sample(camera, sampler, light, &mut sink, tally);
        sink.color
    }
}
