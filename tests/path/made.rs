//! Paths as bidirectional path tracing makes them: both walks, kept whole, and every technique that joins them.

use etendue::bsdf::Lobes;
use etendue::camera::{Camera, LensPoint};
use etendue::light::{ChosenLight, EmitterPoint, Light, LightSampleContext};
use etendue::medium::density;
use etendue::path::{
    Arrival, Connection, Content, Densities, Emitter, FullPath, MisStrategy, PartialMis, PathVertex, Subpath,
    SubpathVertex, TraceStats, Vertex, connect, next_event, splat,
};
use etendue::sampling::{Address, IndependentSampler, Sampler, Slot};
use etendue::scene::{EdgeEnd, EdgeThroughput, Scene};
use etendue::spectrum::Spectrum;
use etendue_testing::worlds::LAMP;
use glam::{DVec3, Vec3};

/// Edges that a walk has at most.
const LONGEST: usize = 7;

/// A vertex of a walk, the component that it left through, and factors that the evaluator leaves out: the probability
/// of roulette and of passing surfaces straight, over the transmittance of the edges, and the density of flights that
/// know the walk over that of flights that do not.
struct Step<'a> {
    vertex: SubpathVertex<'a>,
    lobe: Lobes,
    undo: Spectrum,
}

/// A path made by technique `s`, what the fast code says of it, and the same path for the evaluator.
pub(crate) struct Made<'a> {
    pub(crate) s: usize,
    pub(crate) t: usize,
    /// f(x̄) / p_{s,t}, without roulette.
    pub(crate) value: Spectrum,
    pub(crate) weight: f64,
    pub(crate) path: FullPath<'a>,
    pub(crate) emitter: Emitter,
    pub(crate) nodes: Vec<PathVertex>,
}

/// f(x̄) of `path` and the density of every technique, with free flights.
pub(crate) fn evaluate(scene: &Scene, path: &FullPath, weights: &MisStrategy) -> (Spectrum<f64>, Densities) {
    let (f, mut steps) = path.steps();
    if let Some(content) = Content::of(scene, path, &mut 0) {
        content.fly(&mut steps);
    }
    (f, path.densities(weights, &steps))
}

/// What both walks and their sampler have in common.
pub(crate) struct Studio<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) camera: &'a Camera,
    pub(crate) weights: MisStrategy,
    pub(crate) side: u32,
}

impl<'a> Step<'a> {
    /// Its place.
    fn p(&self) -> Vec3 {
        self.vertex.vertex.p().expect("a place")
    }

    /// It as a receiver of light.
    fn receiver(&self) -> LightSampleContext {
        self.vertex.vertex.context().expect("an interior vertex")
    }

    /// Where edges to it end.
    fn end(&self) -> EdgeEnd<'_> {
        self.vertex.vertex.as_end()
    }

    fn is_connectible(&self) -> bool {
        self.vertex.vertex.is_connectible()
    }
}

/// What a walk met, and what the sky is for it if it left.
struct SubpathEnd<'a> {
    steps: Vec<Step<'a>>,
    sky: Option<Sky>,
    lens: LensPoint,
}

/// A walk that left the scene.
struct Sky {
    sums: PartialMis,
    w: Vec3,
    beta: Spectrum,
    undo: Spectrum,
}

impl<'a> Studio<'a> {
    fn walk(&self, mut path: Subpath<'a>, from: EmitterPoint, sampler: &mut IndependentSampler) -> SubpathEnd<'a> {
        let (mut steps, mut tally) = (Vec::<Step>::new(), TraceStats::default());
        let mut undone: Spectrum = Spectrum::ONE;
        loop {
            let prior = path.walk.lanes;
            let vertex = match path.arrive(self.camera, sampler, &mut tally) {
                Arrival::Vertex(vertex) => vertex,
                Arrival::Infinity(sums) => {
                    let w = path.walk.ray.direction;
                    let end = EdgeEnd::Light(EmitterPoint::Distant);
                    let last = |step: &Step| self.carried(&step.vertex.vertex, end, w, prior, Spectrum::ONE);
                    let undo = (undone * steps.last().map_or(Spectrum::ONE, last)).map(|x: f32| path.walk.survival / x);
                    let sky = Sky { sums, w: path.walk.ray.direction, beta: path.walk.beta, undo };
                    return SubpathEnd { steps, sky: Some(sky), lens: LensPoint::CENTRE };
                }
            };
            let before = steps.last().map_or(EdgeEnd::Light(from), |step| step.end());
            undone *= self.carried(&vertex.vertex, before, vertex.known, prior, vertex.vertex.extinction());
            let undo = undone.map(|x: f32| path.walk.survival / x);
            let left = vertex.scatterer().and_then(|scatterer| path.go_on(&vertex, &scatterer, sampler, &mut tally));
            steps.push(Step { vertex, lobe: left.unwrap_or(Lobes::SMOOTH), undo });
            if left.is_none() || steps.len() == LONGEST {
                return SubpathEnd { steps, sky: None, lens: LensPoint::CENTRE };
            }
        }
    }

    /// What the edge between a vertex and the `end` in direction `w` carries, over the density of a flight of this prior to
    /// where the extinction is `reached`, relative to a prior of 1.
    fn carried(&self, vertex: &Vertex, end: EdgeEnd, w: Vec3, prior: Spectrum, reached: Spectrum) -> Spectrum {
        let edge = vertex.edge_to(self.scene, w, end).expect("not from an endpoint");
        let EdgeThroughput { through, flight, .. } = self.scene.throughput(&edge, &mut 0);
        through * (density(flight, reached) / density(prior * flight, reached))
    }

    /// Every path that the two walks of sample `index` make.
    pub(crate) fn sample(&self, index: u64) -> Vec<Made<'a>> {
        let [mut eye, mut lamp] = [0, 1].map(|stream| IndependentSampler::new(Address::new(index).with(stream)));
        let film = eye.u2(0, Slot::Film).map(|u| u * self.side as f32);
        let lens = self.camera.sample_lens(|| eye.u2(0, Slot::Lens));
        let camera = self.camera.sample_ray(film, lens, 0.0);
        let eye_point = EmitterPoint::Point(camera.ray.origin);
        let mut camera = self.walk(Subpath::from_camera(self.scene, &self.weights, &camera), eye_point, &mut eye);
        camera.lens = lens;
        let light = Subpath::from_light(self.scene, &self.weights, &mut lamp);
        if let Some((_, Emitter { end: EmitterPoint::Surface { .. }, radiance, .. })) = &light {
            // Emission's power over its densities: a dozen roundings.
            let off = (*radiance - LAMP).map(|x: f32| x.abs()).max_lane();
            assert!(off < 16.0 * f32::EPSILON * LAMP.max_lane(), "{radiance:?} leaves a lamp of {LAMP:?}");
        }
        let mut made = Vec::new();
        if let Some((path, emitter)) = light {
            let light = self.walk(path, emitter.end, &mut lamp);
            self.joined(&emitter, &light.steps, &camera, &mut lamp, &mut made);
        }
        self.ended(&camera, &mut eye, &mut made);
        made
    }

    /// t = 1, and s, t ≥ 2.
    fn joined(
        &self,
        emitter: &Emitter,
        light: &[Step<'a>],
        camera: &SubpathEnd<'a>,
        sampler: &mut IndependentSampler,
        made: &mut Vec<Made<'a>>,
    ) {
        for (i, y) in light.iter().enumerate().filter(|(_, y)| y.is_connectible()) {
            let lens = self.camera.sample_lens(|| sampler.u2(i as u32 + 1, Slot::Lens));
            if let Some(found) = splat(self.scene, &self.weights, self.camera, lens, &y.vertex) {
                let toward = self.camera.sample_wi(y.p(), lens).expect("seen").wi;
                let value = found.connection.value * y.undo;
                let weight = self.weight(&found.connection);
                made.extend(self.made(*emitter, &light[..=i], (&[], lens), toward, value, weight, 1));
            }
            for (j, z) in camera.steps.iter().enumerate().filter(|(_, z)| z.is_connectible()) {
                let Some(scatterer) = z.vertex.scatterer() else { continue };
                let Some(found) = connect(&self.weights, &y.vertex, &z.vertex, &scatterer) else { continue };
                let across = (z.p() - y.p()).normalize();
                let value = found.value * y.undo * z.undo;
                let (eye, weight) = ((&camera.steps[..=j], camera.lens), self.weight(&found));
                made.extend(self.made(*emitter, &light[..=i], eye, across, value, weight, j + 2));
            }
        }
    }

    /// s = 1 and s = 0.
    fn ended(&self, camera: &SubpathEnd<'a>, sampler: &mut IndependentSampler, made: &mut Vec<Made<'a>>) {
        for (j, z) in camera.steps.iter().enumerate() {
            let steps = &camera.steps[..=j];
            let scatterer = z.vertex.scatterer().filter(|_| z.is_connectible());
            if let Some(scatterer) = scatterer {
                if let Some(found) = next_event(self.scene, &self.weights, &z.vertex, &scatterer, sampler) {
                    let (emitter, wi) = self.sampled(&z.receiver(), sampler, j as u32);
                    let (eye, value) = ((steps, camera.lens), found.value * z.undo);
                    made.extend(self.made(emitter, &[], eye, -wi, value, self.weight(&found), j + 2));
                }
            }
            if j > 0 {
                made.extend(self.hit(steps, camera.lens));
            }
        }
        if let (Some(sky), false) = (&camera.sky, camera.steps.is_empty()) {
            made.extend(self.sky(&camera.steps, sky, camera.lens));
        }
    }

    /// The weight of a connection, as if nothing stood in its way.
    fn weight(&self, found: &Connection) -> f64 {
        let edge = found.edge(self.scene).expect("not from an endpoint");
        found.weight(&self.weights, self.scene.throughput(&edge, &mut 0).flight)
    }

    /// The light that next-event estimation samples from a receiver with the random numbers of `bounce`, and its
    /// direction.
    fn sampled(&self, receiver: &LightSampleContext, sampler: &mut IndependentSampler, bounce: u32) -> (Emitter, Vec3) {
        let lights = self.scene.lights();
        let u = sampler.u2(bounce, Slot::LightPoint);
        let chosen = lights.choose(receiver, u, || sampler.u1(bounce, Slot::LightPick));
        let ChosenLight { index, u, .. } = chosen.expect("a light");
        let sample = lights.all()[index].sample_li(receiver, u).expect("a sample");
        let falloff = if let EmitterPoint::Point(p) = sample.end { p.distance_squared(receiver.p) } else { 1.0 };
        (Emitter { index, end: sample.end, radiance: sample.radiance * falloff }, sample.wi)
    }

    /// The last vertex of a walk from the camera as a light.
    fn hit(&self, steps: &[Step<'a>], lens: LensPoint) -> Option<Made<'a>> {
        let z = &steps.last()?.vertex;
        let point = z.vertex.surface()?.point;
        let (index, light) = self.scene.light_at(&point)?;
        let Light::Area(area) = light else { return None };
        let radiance = area.radiance(point.barycentric, z.known);
        if radiance.is_black() {
            return None;
        }
        let lights = self.scene.lights();
        let density = light.pdf_le(self.scene.ball(), &EmitterPoint::from(&point), z.known);
        let (receiver, end) = (steps[steps.len() - 2].receiver(), EmitterPoint::from(&point));
        let direct = lights.end_pdf_li(&receiver, index, &end, -z.known, density.position);
        let ends = [direct, f64::from(lights.emitter_pmf(index).value()) * density.position];
        let weight = self.weights.hit(&z.sums, ends, density.direction);
        let emitter = Emitter { index, end, radiance };
        let value = z.beta * radiance * steps[steps.len() - 1].undo;
        let eye = (&steps[..steps.len() - 1], lens);
        self.made(emitter, &[], eye, z.known, value, weight, steps.len() + 1)
    }

    /// What lies behind the last vertex of a walk from the camera.
    fn sky(&self, steps: &[Step<'a>], sky: &Sky, lens: LensPoint) -> Option<Made<'a>> {
        let (index, environment) = self.scene.lights().environment()?;
        let (radiance, pdf) = environment.along(sky.w);
        let lights = self.scene.lights();
        let density = lights.all()[index].pdf_le(self.scene.ball(), &EmitterPoint::Distant, -sky.w);
        let pmfs = [lights.pmf(&steps.last()?.receiver(), index), lights.emitter_pmf(index)];
        let ends = pmfs.map(|pmf| f64::from(pmf.value() * pdf.value()));
        let weight = self.weights.hit(&sky.sums, ends, density.direction);
        let emitter = Emitter { index, end: EmitterPoint::Distant, radiance };
        let value = sky.beta * radiance * sky.undo;
        self.made(emitter, &[], (steps, lens), -sky.w, value, weight, steps.len() + 2)
    }

    /// The path of the light's steps, the edge in direction `across`, and the camera's steps.
    #[allow(clippy::too_many_arguments)]
    fn made(
        &self,
        emitter: Emitter,
        light: &[Step<'a>],
        (camera, lens): (&[Step<'a>], LensPoint),
        across: Vec3,
        value: Spectrum,
        weight: f64,
        t: usize,
    ) -> Option<Made<'a>> {
        let of = |steps: &[Step<'a>], i: usize, joins: bool| {
            let joined = joins && i + 1 == steps.len();
            PathVertex::new(&steps[i].vertex, if joined { Lobes::SMOOTH } else { steps[i].lobe })
                .expect("an interior vertex")
        };
        let s = light.len() + camera.len() + 2 - t;
        let mut nodes: Vec<PathVertex> = (0..light.len()).map(|i| of(light, i, true)).collect();
        // A walk that hit a light left its last vertex before through what it sampled; all other ends are connected.
        nodes.extend((0..camera.len()).rev().map(|i| of(camera, i, s > 0)));
        let mut directions: Vec<DVec3> = light.iter().map(|step| -step.vertex.known.as_dvec3()).collect();
        directions.push(across.as_dvec3());
        directions.extend(camera.iter().rev().map(|step| step.vertex.known.as_dvec3()));
        let eye = self.camera.sample_wi(nodes.last()?.p(), lens)?;
        let path = FullPath::new(self.scene, self.camera, eye, emitter, nodes.clone(), directions);
        (!value.is_black()).then_some(Made { s, t, value, weight, path, emitter, nodes })
    }
}
