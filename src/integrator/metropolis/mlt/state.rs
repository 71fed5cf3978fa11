//! A path as the state of a chain.

use super::super::contribution::Contribution;
use super::super::limit::SampleThreshold;
use super::super::{ChainContext, ImageState};
use super::extend::SubpathBuffer;
use crate::bsdf::Lobes;
use crate::camera::{LensPoint, WiSample};
use crate::light::EmitterPoint;
use crate::mcmc::State;
use crate::path::{Content, Emitter, FullPath, PathVertex, SurfaceVertex, TraceStats, VertexPdfs, edge};
use crate::scene::Edge;
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
        let Proposal { emitter, nodes, directions, eye } = draft;
        let path = FullPath::new(common.scene, &common.camera, eye, emitter, nodes, directions);
        let content = Content::of(common.scene, &path, &mut self.tally.shadows);
        let (f, mut steps) = path.steps();
        let f = content.as_ref().map_or(f, |content| f * content.through.cast::<f64>());
        if let Some(content) = &content {
            content.fly(&mut steps);
        }
        let f = f * share_of_chains(common, film, &path, &steps, content.as_ref(), &f);
        if let Some(content) = &content {
            content.pass(&mut steps);
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
    content: Option<&Content>,
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
        let log = densities.log[s].filter(|_| weight > 0.0)? + content.map_or(0.0, |content| content.log_of_lanes(s));
        Some(weight * SampleThreshold::above(limit, weight * (log_mean - log).exp()))
    };
    (0..=path.k()).filter_map(of).sum()
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
        let eye = common.camera.sample_wi(nodes.last()?.p(), camera.lens)?;
        directions.push(if to_camera { eye.wi.as_dvec3() } else { across });
        directions.extend(camera.directions.into_iter().rev());
        Some(Proposal { emitter, nodes, directions, eye })
    }

    /// Marks x_i as connectible; `None` if it has Dirac components alone.
    pub(super) fn smoothed(&mut self, i: usize) -> Option<()> {
        let node = &mut self.nodes[i - 1];
        node.lobe = Lobes::SMOOTH;
        node.vertex.is_connectible().then_some(())
    }

    /// Returns edge `i`: see [`edge`].
    fn edge(&self, common: &ChainContext, i: usize) -> Edge {
        edge(common.scene, &self.emitter, &self.nodes, &self.eye.eye, &self.directions, i)
    }

    /// Connects x_i and x_{i+1}, both smooth, by a straight edge; `None` if it is occluded.
    pub(super) fn connect(&mut self, common: &ChainContext, i: usize, tally: &mut TraceStats) -> Option<()> {
        let (scene, k) = (common.scene, self.directions.len());
        let shadows = &mut tally.shadows;
        if i + 1 == k {
            let is_culled = |at: &SurfaceVertex| scene.culled(&at.point, -self.eye.wi);
            if self.nodes[i - 1].vertex.surface().is_some_and(is_culled) || !common.region.contains(self.eye.film) {
                return None;
            }
            self.scatters(i)?;
            return (!scene.is_blocked(&self.edge(common, i), shadows)).then_some(());
        }
        if i == 0 {
            let (z, before) = (self.nodes[0].p(), self.directions[0]);
            let w = match self.emitter.end {
                EmitterPoint::Surface { p, .. } | EmitterPoint::Point(p) => {
                    (z.as_dvec3() - p.as_dvec3()).try_normalize()?
                }
                EmitterPoint::Distant => before,
            };
            self.emitter = self.emitter.turned(scene, before, w, z)?;
            self.directions[0] = w;
            self.scatters(1)?;
        } else {
            let [y, z] = [i, i + 1].map(|i| self.nodes[i - 1].p().as_dvec3());
            self.directions[i] = (z - y).try_normalize()?;
            self.scatters(i)?;
            self.scatters(i + 1)?;
        }
        (!scene.is_blocked(&self.edge(common, i), shadows)).then_some(())
    }

    /// Whether x_i can scatter incident light at all: its direction must lie on the same side of both normals of a surface. Tested
    /// before rays are traced.
    fn scatters(&self, i: usize) -> Option<()> {
        let w = self.directions[i - 1];
        let agree = |at: &SurfaceVertex| at.point.ng.as_dvec3().dot(w) * at.point.frame.n.as_dvec3().dot(w) > 0.0;
        self.nodes[i - 1].vertex.surface().is_none_or(agree).then_some(())
    }

    /// Applies [`Proposal::scatters`] to every vertex.
    fn is_consistent(&self) -> bool {
        (1..=self.nodes.len()).all(|i| self.scatters(i).is_some())
    }
}
