//! What the edges of a path carry between its vertices: transmittance, null events, and free flights.

use super::{FullPath, PathVertex, Vertex, VertexPdfs};
use crate::scene::{EdgeThroughput, Scene};
use crate::spectrum::{LANES, Spectrum};
use glam::DVec3;

/// Transmittance, null events and free flights on the edges of an unoccluded path: see [`crate::scene::Passage`] and
/// [`crate::medium::density`].
pub struct Content {
    /// Transmittance of all edges together.
    pub through: Spectrum,
    /// Probability of passing all null events, for each edge.
    passed: Vec<f64>,
    /// Densities of free flights by each lane along each edge, of its end toward the camera and of its end toward the
    /// light.
    flown: Vec<[Spectrum<f64>; 2]>,
    /// Probability of scattering rather than passing at each vertex, for light and camera subpaths.
    met: [Vec<f64>; 2],
}

impl Content {
    /// Evaluates the edges of `path` and adds the number of traced rays to `rays`; `None` if the scene has neither null
    /// events nor media.
    pub fn of(scene: &Scene, path: &FullPath, rays: &mut u64) -> Option<Self> {
        if !(scene.features().content() || scene.features().media) {
            return None;
        }
        let mut found =
            Content { through: Spectrum::ONE, passed: Vec::new(), flown: Vec::new(), met: [Vec::new(), Vec::new()] };
        let nodes = path.nodes();
        // At the endpoints, as on surfaces.
        let extinction = |i: usize| match i {
            0 => Spectrum::ONE,
            i => nodes.get(i - 1).map_or(Spectrum::ONE, |node| node.vertex.extinction()),
        };
        for i in 0..path.k() {
            let EdgeThroughput { through, flight, chance } = scene.throughput(&path.edge(i), rays);
            found.through *= through;
            found.passed.push(f64::from(chance));
            found.flown.push([i + 1, i].map(|end| (flight * extinction(end)).cast()));
        }
        for (i, node) in nodes.iter().enumerate() {
            let directions = [path.directions()[i], path.directions()[i + 1]];
            for (met, w) in found.met.iter_mut().zip(directions) {
                met.push(chance_of_meeting(scene, node, w));
            }
        }
        Some(found)
    }

    /// Multiplies `steps` by the densities of free flights.
    pub fn fly(&self, steps: &mut VertexPdfs) {
        self.weigh(steps, |edge, end| self.flown[edge][end].mean(), |_, _| 1.0);
    }

    /// Returns the logarithm of the density of the technique with `s` light vertices, whose flights know the lanes of their
    /// walk so far, over the product of the densities of [`Content::fly`]: see [`crate::medium::Flight`].
    pub fn log_of_lanes(&self, s: usize) -> f64 {
        let light = log_of_lanes(self.flown[..s.saturating_sub(1)].iter().map(|ends| ends[0]));
        light + log_of_lanes(self.flown[s..].iter().rev().map(|ends| ends[1]))
    }

    /// Multiplies `steps` by the probabilities of null events.
    pub fn pass(&self, steps: &mut VertexPdfs) {
        self.weigh(steps, |edge, _| self.passed[edge], |i, end| self.met[end][i - 1]);
    }

    /// Multiplies `steps` by factors of the edge on which a walk reaches a vertex, and of the interior vertex; both also
    /// depend on whether it comes from the light, 0, or from the camera, 1.
    fn weigh(&self, steps: &mut VertexPdfs, edge: impl Fn(usize, usize) -> f64, at: impl Fn(usize, usize) -> f64) {
        let (k, VertexPdfs { light, camera, perturbation, .. }) = (self.passed.len(), steps);
        let [from_light, from_camera] = perturbation;
        for made in [light, from_light] {
            (1..k).for_each(|i| made[i] *= edge(i - 1, 0) * at(i, 0));
        }
        for made in [camera, from_camera] {
            (0..k).for_each(|i| made[i] *= edge(i, 1) * if i > 0 { at(i, 1) } else { 1.0 });
        }
    }
}

/// Returns the logarithm of the mean over lanes of the product of `flights` over the product of their means.
fn log_of_lanes(flights: impl Iterator<Item = Spectrum<f64>>) -> f64 {
    let step = |(prior, log): (Spectrum<f64>, f64), lanes: Spectrum<f64>| {
        let joint = prior * lanes;
        (joint / joint.mean(), log + (joint.mean() / lanes.mean()).ln())
    };
    flights.fold((Spectrum([1.0; LANES]), 0.0), step).1
}

/// Returns the probability with which a walk along `w` scatters at `node` rather than to pass it.
fn chance_of_meeting(scene: &Scene, node: &PathVertex, w: DVec3) -> f64 {
    match &node.vertex {
        Vertex::Surface(at) if scene.features().content() && scene.may_pass(&at.point, at.state.bodies) => {
            f64::from(scene.passage(&at.point, w.as_vec3(), at.state.bodies).met)
        }
        _ => 1.0,
    }
}
