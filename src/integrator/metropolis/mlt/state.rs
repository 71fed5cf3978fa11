//! A path as the state of a chain.

use super::super::contribution::Contribution;
use super::super::limit::SampleThreshold;
use super::super::{ChainContext, ImageState};
use super::extend::SubpathBuffer;
use crate::bsdf::{Bsdf, Lobes};
use crate::camera::{LensPoint, WiSample};
use crate::light::EmitterPoint;
use crate::mcmc::State;
use crate::path::{Emitter, FullPath, PathVertex, TraceStats, VertexPdfs};
use crate::scene::{Edge, EdgeEnd};
use crate::spectrum::Spectrum;
use glam::DVec3;

/// A proposed path before evaluation.
#[derive(Clone)]
pub(super) struct Proposal {
    pub(super) emitter: Emitter,
    /// x₁ … x_{k−1}.
    pub(super) nodes: Vec<PathVertex>,
    /// Directions of the k edges, in the direction of light flow.
    pub(super) directions: Vec<DVec3>,
    /// x_k, with the last edge.
    eye: WiSample,
}

/// An evaluated path; empty until first set.
#[derive(Default)]
pub(in super::super) struct PathState<'a> {
    path: Option<FullPath<'a>>,
    pub(super) steps: VertexPdfs,
    /// Contribution scaled to a largest lane of 1, since f may exceed the range of f32.
    found: Contribution,
    log_target: f64,
    pub(super) tally: TraceStats,
}

impl State for PathState<'_> {
    fn log_target(&self) -> f64 {
        self.log_target
    }
}

impl ImageState for PathState<'_> {
    fn contribution(&self) -> &Contribution {
        &self.found
    }

    fn tally(&mut self) -> &mut TraceStats {
        &mut self.tally
    }
}

impl<'a> PathState<'a> {
    /// Path of the state. Every state except a new one has a path.
    pub(super) fn path(&self) -> &FullPath<'a> {
        self.path.as_ref().expect("a chain's state has a path")
    }

    /// x_i, 0 < i < k.
    pub(super) fn node(&self, i: usize) -> &PathVertex {
        &self.path().nodes()[i - 1]
    }

    /// Point of the lens at x_k.
    pub(super) fn lens(&self) -> LensPoint {
        self.path().eye().eye.lens
    }

    /// Number of edges.
    pub(in super::super) fn k(&self) -> usize {
        self.path().k()
    }

    /// Whether x_i is an endpoint or scatters smoothly.
    pub(super) fn is_smooth(&self, i: usize) -> bool {
        i == 0 || i == self.k() || !self.node(i).is_dirac()
    }

    /// Sets the state to `draft`, whose edges are unoccluded; `None` if it contributes nothing to the image.
    pub(super) fn set(&mut self, common: &ChainContext<'a>, draft: Proposal) -> Option<()> {
        if !draft.is_consistent() {
            return None;
        }
        let film = draft.eye.film;
        if !common.region.contains(film) {
            return None;
        }
        let content = Content::of(common, &draft, &mut self.tally);
        let Proposal { emitter, nodes, directions, eye } = draft;
        let path = FullPath::new(common.scene, &common.camera, eye, emitter, nodes, directions);
        let (f, mut steps) = path.steps();
        let f = content.as_ref().map_or(f, |content| f * content.through.cast::<f64>());
        let f = f * share_of_chains(common, film, &path, &steps, &f);
        if let Some(content) = &content {
            content.weigh(&mut steps);
        }
        let most = f.max_lane();
        if !(most > 0.0 && most.is_finite()) {
            return None;
        }
        self.found.clear();
        self.found.add(&common.importance, film, Spectrum(f.0.map(|x| (x / most) as f32)));
        self.log_target = most.ln() + self.found.log_scalar();
        (self.path, self.steps) = (Some(path), steps);
        Some(())
    }
}

/// Returns the chains' share of a path: the excess of each technique above the threshold. See [`super::super::limit`].
fn share_of_chains(
    common: &ChainContext,
    film: [f32; 2],
    path: &FullPath,
    steps: &VertexPdfs,
    f: &Spectrum<f64>,
) -> f64 {
    if common.limit.is_none() {
        return 1.0;
    }
    let weights = common.tracer.weights();
    let (limit, densities) = (common.limit.at(film), path.densities(weights, steps));
    let log_mean = f.mean().ln();
    let of = |s: usize| {
        let weight = densities.weight(weights, s);
        // A sample of this technique contributes weight f / p.
        let log = densities.log[s].filter(|_| weight > 0.0)?;
        Some(weight * SampleThreshold::above(limit, weight * (log_mean - log).exp()))
    };
    (0..=path.k()).filter_map(of).sum()
}

/// Transmittance and null events on the edges of an unoccluded path: see [`crate::scene::Passage`].
struct Content {
    /// Transmittance of all edges together.
    through: Spectrum,
    /// Probability of passing all null events, for each edge.
    passed: Vec<f64>,
    /// Probability of scattering rather than passing at each vertex, for light and camera subpaths.
    met: [Vec<f64>; 2],
}

impl Content {
    /// Evaluates the edges of `draft`; `None` if the scene has neither null events nor media.
    fn of(common: &ChainContext, draft: &Proposal, tally: &mut TraceStats) -> Option<Self> {
        let scene = common.scene;
        if !(scene.features().content() || scene.features().media) {
            return None;
        }
        let mut found = Content { through: Spectrum::ONE, passed: Vec::new(), met: [Vec::new(), Vec::new()] };
        for i in 0..draft.directions.len() {
            let edge = scene.throughput(&draft.edge(common, i), &mut tally.shadows);
            found.through *= edge.through;
            found.passed.push(f64::from(edge.chance));
        }
        for (i, node) in draft.nodes.iter().enumerate() {
            let met = |w: DVec3| match scene.features().content() && scene.may_pass(&node.point, node.state.bodies) {
                true => f64::from(scene.passage(&node.point, w.as_vec3(), node.state.bodies).met),
                false => 1.0,
            };
            found.met[0].push(met(draft.directions[i]));
            found.met[1].push(met(draft.directions[i + 1]));
        }
        Some(found)
    }

    /// Multiplies `steps` by the probabilities of null events.
    fn weigh(&self, steps: &mut VertexPdfs) {
        let [light, camera] = &self.met;
        let (k, VertexPdfs { light: from_light, camera: from_camera, perturbation, .. }) = (self.passed.len(), steps);
        for made in [from_light, &mut perturbation[0]] {
            (1..k).for_each(|i| made[i] *= self.passed[i - 1] * light[i - 1]);
        }
        for made in [from_camera, &mut perturbation[1]] {
            (0..k).for_each(|i| made[i] *= self.passed[i] * if i > 0 { camera[i - 1] } else { 1.0 });
        }
    }
}

impl SubpathBuffer {
    /// Copies x_k … x_b.
    pub(super) fn from_camera(x: &PathState, b: usize) -> Self {
        let (path, k) = (x.path(), x.k());
        let nodes = path.nodes()[b - 1..].iter().rev().cloned().collect();
        let directions = path.directions()[b..k].iter().rev().copied().collect();
        SubpathBuffer { lens: x.lens(), nodes, directions }
    }

    /// Copies x₁ … x_{a−1}.
    pub(super) fn from_light(x: &PathState, a: usize) -> Self {
        let path = x.path();
        let (nodes, directions) = (path.nodes()[..a - 1].to_vec(), path.directions()[..a - 1].to_vec());
        SubpathBuffer { nodes, directions, ..SubpathBuffer::default() }
    }
}

impl Proposal {
    /// Joins `light`, one edge in the direction `across`, and `camera` into a path; `None` if the camera does not see
    /// its last vertex. An edge between this vertex and the camera has its own direction.
    pub(super) fn join(
        common: &ChainContext,
        emitter: Emitter,
        light: SubpathBuffer,
        across: DVec3,
        camera: SubpathBuffer,
    ) -> Option<Proposal> {
        let (mut nodes, mut directions) = (light.nodes, light.directions);
        let to_camera = camera.nodes.is_empty();
        nodes.reserve_exact(camera.nodes.len());
        nodes.extend(camera.nodes.into_iter().rev());
        let eye = common.camera.sample_wi(nodes.last()?.point.p, camera.lens)?;
        directions.push(if to_camera { eye.wi.as_dvec3() } else { across });
        directions.extend(camera.directions.into_iter().rev());
        Some(Proposal { emitter, nodes, directions, eye })
    }

    /// Marks x_i as connectible; `None` if it has Dirac components alone.
    pub(super) fn smoothed(&mut self, i: usize) -> Option<()> {
        let node = &mut self.nodes[i - 1];
        node.lobe = Lobes::SMOOTH;
        node.surface.lobes().intersects(Lobes::SMOOTH).then_some(())
    }

    /// Returns edge `i`, starting at the end nearer to the camera except for the last edge.
    fn edge(&self, common: &ChainContext, i: usize) -> Edge {
        let (node, w, end) = if i + 1 == self.directions.len() {
            (&self.nodes[i - 1], self.directions[i], EdgeEnd::Camera(self.eye.eye))
        } else if i == 0 {
            (&self.nodes[0], -self.directions[0], EdgeEnd::Light(self.emitter.end))
        } else {
            (&self.nodes[i], -self.directions[i], EdgeEnd::Surface(&self.nodes[i - 1].point))
        };
        node.edge_to(common.scene, w.as_vec3(), end)
    }

    /// Connects x_i and x_{i+1}, both smooth, by a straight edge; `None` if it is occluded.
    pub(super) fn connect(&mut self, common: &ChainContext, i: usize, tally: &mut TraceStats) -> Option<()> {
        let (scene, k) = (common.scene, self.directions.len());
        let shadows = &mut tally.shadows;
        if i + 1 == k {
            if scene.culled(&self.nodes[i - 1].point, -self.eye.wi) || !common.region.contains(self.eye.film) {
                return None;
            }
            self.scatters(i)?;
            return (!scene.is_blocked(&self.edge(common, i), shadows)).then_some(());
        }
        if i == 0 {
            let (z, before) = (&self.nodes[0].point, self.directions[0]);
            let w = match self.emitter.end {
                EmitterPoint::Surface { p, .. } | EmitterPoint::Point(p) => {
                    (z.p.as_dvec3() - p.as_dvec3()).try_normalize()?
                }
                EmitterPoint::Distant => before,
            };
            self.emitter = self.emitter.turned(scene, before, w, z.p)?;
            self.directions[0] = w;
            self.scatters(1)?;
        } else {
            let [y, z] = [i, i + 1].map(|i| self.nodes[i - 1].point);
            self.directions[i] = (z.p.as_dvec3() - y.p.as_dvec3()).try_normalize()?;
            self.scatters(i)?;
            self.scatters(i + 1)?;
        }
        (!scene.is_blocked(&self.edge(common, i), shadows)).then_some(())
    }

    /// Whether x_i can scatter incident light at all: its direction must lie on the same side of both normals. Tested
    /// before rays are traced.
    fn scatters(&self, i: usize) -> Option<()> {
        let (point, w) = (&self.nodes[i - 1].point, self.directions[i - 1]);
        (point.ng.as_dvec3().dot(w) * point.frame.n.as_dvec3().dot(w) > 0.0).then_some(())
    }

    /// Applies [`Proposal::scatters`] to every vertex.
    fn is_consistent(&self) -> bool {
        (1..=self.nodes.len()).all(|i| self.scatters(i).is_some())
    }
}
