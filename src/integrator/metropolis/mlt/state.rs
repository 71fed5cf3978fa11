//! A path as the state of a chain.

use super::super::contribution::Contribution;
use super::super::limit::Limit;
use super::super::{Common, Lit};
use crate::bsdf::{Bsdf, Lobes};
use crate::geometry::{Hit, Ray, SurfacePoint};
use crate::light::End;
use crate::mcmc::State;
use crate::path::{Emitter, FullPath, Node, Steps, Tally, toward_end};
use crate::spectrum::Spectrum;
use glam::DVec3;

/// What a path is made of, before it is known what it is worth.
#[derive(Clone)]
pub(super) struct Draft {
    pub(super) emitter: Emitter,
    /// x₁ … x_{k−1}.
    pub(super) nodes: Vec<Node>,
    /// Of the k edges, as light flows.
    pub(super) directions: Vec<DVec3>,
}

/// A path and what is known of it; nothing before the first is set.
#[derive(Default)]
pub(in super::super) struct PathState<'a> {
    path: Option<FullPath<'a>>,
    pub(super) steps: Steps,
    /// Scaled to a largest lane of 1: f may be beyond f32.
    found: Contribution,
    log_target: f64,
    /// Where it is seen.
    pub(super) film: [f32; 2],
    pub(super) tally: Tally,
}

impl State for PathState<'_> {
    fn log_target(&self) -> f64 {
        self.log_target
    }
}

impl Lit for PathState<'_> {
    fn contribution(&self) -> &Contribution {
        &self.found
    }

    fn tally(&mut self) -> &mut Tally {
        &mut self.tally
    }
}

impl<'a> PathState<'a> {
    /// The path of a state that has one: all but fresh ones.
    pub(super) fn path(&self) -> &FullPath<'a> {
        self.path.as_ref().expect("a chain's state has a path")
    }

    /// x_i, 0 < i < k.
    pub(super) fn node(&self, i: usize) -> &Node {
        &self.path().nodes()[i - 1]
    }

    /// Number of edges.
    pub(in super::super) fn k(&self) -> usize {
        self.path().k()
    }

    /// Whether x_i is an end or scatters smoothly.
    pub(super) fn is_smooth(&self, i: usize) -> bool {
        i == 0 || i == self.k() || !self.node(i).is_dirac()
    }

    /// Becomes `draft`, whose edges are free; `None` if that carries no light to the image.
    pub(super) fn set(&mut self, common: &Common<'a>, draft: Draft) -> Option<()> {
        if !draft.is_consistent() {
            return None;
        }
        let last = draft.nodes.last()?;
        let film = common.camera.seen(last.point.p)?.film;
        if !common.region.contains(film) {
            return None;
        }
        let content = Content::of(common, &draft, &mut self.tally);
        let path = FullPath::new(common.scene, &common.camera, draft.emitter, draft.nodes, draft.directions)?;
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
        (self.path, self.steps, self.film) = (Some(path), steps, film);
        Some(())
    }
}

/// What chains have of a path: of each technique's part what is above the limit. See [`super::super::limit`].
fn share_of_chains(common: &Common, film: [f32; 2], path: &FullPath, steps: &Steps, f: &Spectrum<f64>) -> f64 {
    if common.limit.is_none() {
        return 1.0;
    }
    let weights = common.tracer.weights();
    let (limit, densities) = (common.limit.at(film), path.densities(weights, steps));
    let log_mean = f.mean().ln();
    let of = |s: usize| {
        let weight = densities.weight(weights, s);
        // Its sample is worth weight f / p.
        let log = densities.log[s].filter(|_| weight > 0.0)?;
        Some(weight * Limit::above(limit, weight * (log_mean - log).exp()))
    };
    (0..=path.k()).filter_map(of).sum()
}

/// What is on the edges of a path, which are known to be free: see [`crate::scene::Passage`].
struct Content {
    /// Share of light that they carry together.
    through: Spectrum,
    /// Probability with which a walk passes what is on each.
    passed: Vec<f64>,
    /// Probability with which walks from the light and from the camera scatter at each vertex and do not pass it.
    met: [Vec<f64>; 2],
}

impl Content {
    /// That of `draft`; `None` where there is nothing of the kind in the scene.
    fn of(common: &Common, draft: &Draft, tally: &mut Tally) -> Option<Self> {
        let scene = common.scene;
        if !(scene.features().content() || scene.features().media) {
            return None;
        }
        let mut found = Content { through: Spectrum::ONE, passed: Vec::new(), met: [Vec::new(), Vec::new()] };
        for i in 0..draft.directions.len() {
            let to_camera = i + 1 == draft.directions.len();
            let segment = draft.segment(common, i)?;
            let unseen = |point: &SurfacePoint| to_camera && scene.culled(point, -segment.direction);
            let edge = scene.edge(&segment, &mut tally.shadows, unseen);
            found.through *= edge.through;
            found.passed.push(f64::from(edge.chance));
        }
        for (i, node) in draft.nodes.iter().enumerate() {
            let met = |w: DVec3| match scene.features().content() && scene.may_pass(&node.point, node.bodies) {
                true => f64::from(scene.passage(&node.point, w.as_vec3(), node.bodies).met),
                false => 1.0,
            };
            found.met[0].push(met(draft.directions[i]));
            found.met[1].push(met(draft.directions[i + 1]));
        }
        Some(found)
    }

    /// `steps` of walks that pass what is on the edges by chance.
    fn weigh(&self, steps: &mut Steps) {
        let [light, camera] = &self.met;
        let (k, Steps { light: from_light, camera: from_camera, copied, .. }) = (self.passed.len(), steps);
        for made in [from_light, &mut copied[0]] {
            (1..k).for_each(|i| made[i] *= self.passed[i - 1] * light[i - 1]);
        }
        for made in [from_camera, &mut copied[1]] {
            (0..k).for_each(|i| made[i] *= self.passed[i] * if i > 0 { camera[i - 1] } else { 1.0 });
        }
    }
}

impl Draft {
    /// x_i as something that connections may end at; `None` if it scatters in no other way than a mirror.
    pub(super) fn smoothed(&mut self, i: usize) -> Option<()> {
        let node = &mut self.nodes[i - 1];
        node.lobe = Lobes::SMOOTH;
        node.surface.lobes().intersects(Lobes::SMOOTH).then_some(())
    }

    /// The segment of edge `i`, from the end that is nearer to the camera but for the last; `None` where the camera does not see it.
    fn segment(&self, common: &Common, i: usize) -> Option<Ray> {
        let to_camera = i + 1 == self.directions.len();
        let (node, w) = if to_camera { (&self.nodes[i - 1], self.directions[i]) } else { (&self.nodes[i], -self.directions[i]) };
        let bodies = common.scene.bodies_toward(&node.point, node.bodies, w.as_vec3());
        let segment = if to_camera {
            node.point.segment(common.camera.seen(node.point.p)?.eye, 0.0, node.point.ng, Hit::NONE)
        } else if i == 0 {
            toward_end(&node.point, &self.emitter.end, w.as_vec3())
        } else {
            node.point.segment_to(&self.nodes[i - 1].point)
        };
        Some(Ray { bodies, ..segment })
    }

    /// Connects x_i and x_{i+1}, both smooth, with a straight edge that is free, wherever it leads.
    pub(super) fn connect(&mut self, common: &Common, i: usize, tally: &mut Tally) -> Option<()> {
        let (scene, k) = (common.scene, self.directions.len());
        let shadows = &mut tally.shadows;
        if i + 1 == k {
            let y = &self.nodes[i - 1].point;
            let seen = common.camera.seen(y.p)?;
            if scene.culled(y, -seen.toward) || !common.region.contains(seen.film) {
                return None;
            }
            self.directions[i] = seen.toward.as_dvec3();
            self.scatters(i)?;
            return (!scene.transmittance_to_camera(&self.segment(common, i)?, shadows).is_black()).then_some(());
        }
        if i == 0 {
            let (z, before) = (&self.nodes[0].point, self.directions[0]);
            let w = match self.emitter.end {
                End::Surface { p, .. } | End::Point(p) => (z.p.as_dvec3() - p.as_dvec3()).try_normalize()?,
                End::Infinity => before,
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
        (!scene.transmittance(&self.segment(common, i)?, shadows).is_black()).then_some(())
    }

    /// Whether x_i may scatter light at all from where it comes: on one side of both normals. Asked before rays are traced.
    fn scatters(&self, i: usize) -> Option<()> {
        let (point, w) = (&self.nodes[i - 1].point, self.directions[i - 1]);
        (point.ng.as_dvec3().dot(w) * point.frame.n.as_dvec3().dot(w) > 0.0).then_some(())
    }

    /// See [`Draft::scatters`], for every vertex.
    fn is_consistent(&self) -> bool {
        (1..=self.nodes.len()).all(|i| self.scatters(i).is_some())
    }
}
