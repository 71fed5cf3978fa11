//! The explicit evaluator: a complete path in, the integrand f(x̄) and the density of every technique out, by their definitions and in
//! f64. It referees the recursive weights, and is what methods stand on that change paths.
//!
//! Visibility and transmittance of edges are left out, as they are of all densities. Dirac components are named by the path: their
//! directions are taken as they are, and values and probabilities are those of the component (see [`FullPath::evaluate`]).

use super::mis::Weights;
use super::{Emitter, Vertex};
use crate::bsdf::shading::folds;
use crate::bsdf::sides::{Sided, Sources};
use crate::bsdf::{Bsdf, Lobes, Surface};
use crate::camera::Camera;
use crate::defects::{Defect, planted};
use crate::geometry::{Bodies, Frame, Local, SurfacePoint};
use crate::light::{End, Light, Receiver};
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use crate::transport::Transport;
use glam::{DVec3, Vec3};

/// A vertex between the ends of a path.
#[derive(Clone)]
pub struct Node {
    /// Where.
    pub point: SurfacePoint,
    /// The bodies that a walk came through; see [`Scene::bodies_toward`].
    pub bodies: Bodies,
    /// How it scatters.
    pub surface: Surface,
    /// The component that scatters: one Dirac lobe, or [`Lobes::SMOOTH`].
    pub lobe: Lobes,
}

/// A path x₀ x₁ … x_k from a light to the camera with k ≥ 2 edges.
pub struct FullPath<'a> {
    scene: &'a Scene,
    camera: Camera,
    emitter: Emitter,
    /// x₁ to x_{k−1}.
    nodes: Vec<Node>,
    /// Unit vectors along the edges as light flows, k of them.
    directions: Vec<DVec3>,
    /// Squared lengths of the edges; 1 for one from infinity.
    lengths2: Vec<f64>,
}

/// What a path is worth and how likely it is.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// f(x̄): see notation.md. Per pixel of film area.
    pub f: Spectrum<f64>,
    /// Of all techniques.
    pub densities: Densities,
}

/// The densities of the techniques that may make a path.
#[derive(Debug, Clone)]
pub struct Densities {
    /// log p_{s,t} for s = 0 … k, multiplied by the number of walks of the technique; `None` for one that cannot make the path or does
    /// not take part.
    pub log: Vec<Option<f64>>,
}

/// The density with which walks would make each vertex of a path, given those before it: of x₀ … x_{k−1}, per area.
#[derive(Debug, Clone, Default)]
pub struct Steps {
    /// In a walk from the light; of x₀ as emission chooses it.
    pub light: Vec<f64>,
    /// In a walk from the camera.
    pub camera: Vec<f64>,
    /// Of x₀, as x₁ would choose it.
    pub direct: f64,
    /// As `light` and `camera`, if the component of each Dirac vertex were given, and the density of every other direction were 1.
    pub copied: [Vec<f64>; 2],
    /// Whether the edge to xₛ can be made by connecting its ends, for s = 0 (where a walk finds the light) … k.
    pub connects: Vec<bool>,
}

impl Densities {
    /// The weight of technique `s`, p^β over the sum of all; 0 if it does not make the path.
    pub fn weight(&self, weights: &Weights, s: usize) -> f64 {
        let Some(own) = self.log[s] else { return 0.0 };
        let sum: f64 = self.log.iter().flatten().map(|log| weights.power((log - own).exp())).sum();
        sum.recip()
    }
}

impl Steps {
    /// Logarithm of the density with which x_a … x_{b−1} are made, those before `s` by a walk from the light and the others by one from
    /// the camera.
    pub fn log_split(&self, a: usize, b: usize, s: usize) -> f64 {
        let light: f64 = (a..s).map(|i| if (i, s) == (0, 1) { self.direct.ln() } else { self.light[i].ln() }).sum();
        let camera: f64 = (s..b).map(|i| self.camera[i].ln()).sum();
        light + camera
    }
}

impl Node {
    /// A vertex of a walk that scatters through `lobe`.
    pub fn new(vertex: &Vertex, lobe: Lobes) -> Self {
        let lobe = if lobe.intersects(Lobes::DIRAC) { lobe } else { Lobes::SMOOTH };
        Node { point: vertex.point, bodies: vertex.bodies, surface: *vertex.surface, lobe }
    }

    /// Whether its component is a Dirac lobe.
    pub fn is_dirac(&self) -> bool {
        self.lobe.intersects(Lobes::DIRAC)
    }
}

/// F of a vertex and the densities per solid angle of its directions: of wo in a walk from the light, of wi in one from the camera; and
/// what is left of them if the component is given and a smooth density 1.
struct Factors {
    f: Spectrum<f64>,
    to_camera: f64,
    to_light: f64,
    copied: [f64; 2],
}

/// Directions of a vertex as its model is told them: see [`crate::bsdf::shading`].
struct Seen {
    wi: Sources<f64>,
    wo: Local<f64>,
    /// Probability with which a walk from the light takes this wo of those that are seen as `wo`.
    share: f64,
    /// |wi·ng|.
    cos_i: f64,
}

fn local(frame: &Frame, w: DVec3) -> Local<f64> {
    let [s, t, n] = [frame.s, frame.t, frame.n].map(|axis| w.dot(axis.as_dvec3()));
    Local::new(s, t, n)
}

fn sided(point: &SurfacePoint, w: DVec3) -> Sided<f64> {
    Sided { local: local(&point.frame, w), cos: w.dot(point.ng.as_dvec3()) }
}

fn smooth_factors(surface: &Surface, seen: &Seen) -> Factors {
    let mut all = Factors { f: Spectrum::ZERO, to_camera: 0.0, to_light: 0.0, copied: [1.0; 2] };
    for (wi, chosen) in seen.wi.choices() {
        all.f += surface.eval(wi, seen.wo, Lobes::SMOOTH) * (wi.z.abs() / seen.cos_i);
        all.to_camera += surface.pdf(wi, seen.wo, Transport::Camera, Lobes::SMOOTH) * chosen * seen.share;
        all.to_light += surface.pdf(seen.wo, wi, Transport::Light, Lobes::SMOOTH);
    }
    all
}

fn single(w: Local<f64>) -> Local {
    Local::new(w.x as f32, w.y as f32, w.z as f32)
}

fn cosine(w: DVec3, ng: Vec3) -> f64 {
    w.dot(ng.as_dvec3()).abs()
}

impl<'a> FullPath<'a> {
    /// The path from `emitter` by `nodes` to the camera, with unit `directions` of its edges as light flows: those that walks had, or
    /// [`FullPath::straight`]. `None` where the camera does not see its last vertex.
    ///
    /// # Panics
    /// If there is no vertex between the ends, or not a direction for each edge.
    pub fn new(
        scene: &'a Scene,
        camera: &Camera,
        emitter: Emitter,
        nodes: Vec<Node>,
        directions: Vec<DVec3>,
    ) -> Option<FullPath<'a>> {
        assert!(!nodes.is_empty() && directions.len() == nodes.len() + 1, "{} directions", directions.len());
        let points: Vec<DVec3> = nodes.iter().map(|n| n.point.p.as_dvec3()).collect();
        let eye = camera.seen(nodes[nodes.len() - 1].point.p)?.eye.as_dvec3();
        let first = match emitter.end {
            End::Surface { p, .. } | End::Point(p) => p.as_dvec3().distance_squared(points[0]),
            End::Infinity => 1.0,
        };
        let between = points.windows(2).map(|pair| pair[0].distance_squared(pair[1]));
        let last = points[points.len() - 1].distance_squared(eye);
        let lengths2 = std::iter::once(first).chain(between).chain(std::iter::once(last)).collect();
        Some(FullPath { scene, camera: camera.clone(), emitter, nodes, directions, lengths2 })
    }

    /// Unit directions of the edges between the points of a path, in f64; `first` is that of light from infinity.
    pub fn straight(emitter: &Emitter, nodes: &[Node], camera: &Camera, first: DVec3) -> Option<Vec<DVec3>> {
        let mut points: Vec<DVec3> = nodes.iter().map(|n| n.point.p.as_dvec3()).collect();
        points.push(camera.seen(nodes.last()?.point.p)?.eye.as_dvec3());
        let begin = match emitter.end {
            End::Surface { p, .. } | End::Point(p) => (points[0] - p.as_dvec3()).normalize(),
            End::Infinity => first,
        };
        let between = points.windows(2).map(|pair| (pair[1] - pair[0]).normalize());
        Some(std::iter::once(begin).chain(between).collect())
    }

    /// The light that it begins at.
    pub fn emitter(&self) -> &Emitter {
        &self.emitter
    }
    /// x₁ to x_{k−1}.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }
    /// The length of edge `i`; 1 for one from infinity.
    pub fn length(&self, i: usize) -> f64 {
        self.lengths2[i].sqrt()
    }
    /// The camera that it ends at.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Unit vectors along its edges, as light flows.
    pub fn directions(&self) -> &[DVec3] {
        &self.directions
    }

    /// Number of edges.
    pub fn k(&self) -> usize {
        self.directions.len()
    }

    /// f(x̄) and every technique's density.
    ///
    /// A Dirac vertex counts in projected solid angle: f has its value in radiance's form times |wi·ns| / |wi·ng|, and the density
    /// of a direction is the component's probability times |w·ns|, and times η² toward the camera. What a chain of such vertices does to
    /// the measure is the same in f and in all densities, and left out.
    pub fn evaluate(&self, weights: &Weights) -> Evaluation {
        let (f, steps) = self.steps();
        Evaluation { f, densities: self.densities(weights, &steps) }
    }

    /// f(x̄), and how walks would make its vertices.
    pub fn steps(&self) -> (Spectrum<f64>, Steps) {
        let k = self.k();
        let factors: Vec<Factors> = (1..k).map(|i| self.factors(i)).collect();
        let seen = self.camera.seen(self.nodes[k - 2].point.p).map_or(0.0, |seen| f64::from(seen.magnification));
        let radiance = if self.is_dark() { Spectrum::ZERO } else { self.emitter.radiance };
        // We G of the last edge: the film covers |cos| magnification per area.
        let mut f = radiance.cast::<f64>() * (seen * self.cosines(k - 1)[1]);
        for (i, factors) in (1..k).zip(&factors) {
            f = f * factors.f * self.geometry(i - 1);
        }
        (f, self.steps_of(&factors, seen))
    }

    /// Whether it begins at what is seen and lights nothing, and scatters other than by Dirac components.
    fn is_dark(&self) -> bool {
        let light = &self.scene.lights().all()[self.emitter.index];
        light.is_only_seen() && !planted(Defect::UnlitIsLamp) && !self.nodes.iter().all(Node::is_dirac)
    }

    /// G of edge `i` < k − 1, from xᵢ to xᵢ₊₁.
    fn geometry(&self, i: usize) -> f64 {
        let begins = if i == 0 { self.cosine_at_light() } else { self.cosines(i)[1] };
        begins * self.cosines(i + 1)[0] / self.lengths2[i]
    }

    /// C of x₀; 1 for a point, and at infinity, where radiance is per solid angle.
    fn cosine_at_light(&self) -> f64 {
        match self.emitter.end {
            End::Surface { ng, .. } => cosine(self.directions[0], ng),
            End::Point(_) | End::Infinity => 1.0,
        }
    }

    /// |wi·ng| and |wo·ng| of xᵢ.
    fn cosines(&self, i: usize) -> [f64; 2] {
        let ng = self.nodes[i - 1].point.ng;
        [cosine(self.directions[i - 1], ng), cosine(self.directions[i], ng)]
    }

    /// What its model is told of wi and wo of xᵢ; `None` where F is zero.
    fn seen(&self, i: usize) -> Option<Seen> {
        let node = &self.nodes[i - 1];
        let [wi, wo] = [-self.directions[i - 1], self.directions[i]].map(|w| sided(&node.point, w));
        let ng = local(&node.point.frame, node.point.ng.as_dvec3());
        Some(Seen { wi: wi.sources(ng.z, || ng)?, wo: wo.seen()?, share: wo.share(ng.z), cos_i: wi.cos.abs() })
    }

    fn factors(&self, i: usize) -> Factors {
        let node = &self.nodes[i - 1];
        let factors = self.seen(i).and_then(|seen| {
            if node.is_dirac() { self.dirac_factors(i, &seen) } else { Some(smooth_factors(&node.surface, &seen)) }
        });
        factors.unwrap_or(Factors { f: Spectrum::ZERO, to_camera: 0.0, to_light: 0.0, copied: [0.0; 2] })
    }

    fn dirac_factors(&self, i: usize, seen: &Seen) -> Option<Factors> {
        let (node, wo) = (&self.nodes[i - 1], seen.wo);
        let dirac = |known, toward| node.surface.dirac(single(known), toward, node.lobe);
        let (wi, chosen) = self.component(i, seen)?;
        let (camera, light) = (dirac(wi, Transport::Camera)?, dirac(wo, Transport::Light)?);
        let copied = [wo.z.abs() * f64::from(camera.eta).powi(2), wi.z.abs()];
        Some(Factors {
            f: light.value.cast::<f64>() * (wi.z.abs() / seen.cos_i),
            to_camera: f64::from(camera.density.value()) * copied[0] * chosen * seen.share,
            to_light: f64::from(light.density.value()) * copied[1],
            copied,
        })
    }

    /// wi of the Dirac component at xᵢ as the model is told it, and the probability that a walk from the light tells it so.
    fn component(&self, i: usize, seen: &Seen) -> Option<(Local<f64>, f64)> {
        let node = &self.nodes[i - 1];
        let folds = folds(&node.point, &node.surface, self.directions[i].as_vec3(), node.lobe)?;
        seen.wi.choice(folds.source)
    }

    /// See [`Steps`].
    fn steps_of(&self, factors: &[Factors], seen: f64) -> Steps {
        let k = self.k();
        let lights = self.scene.lights();
        let light = &lights.all()[self.emitter.index];
        let emission = light.emission_density(self.scene.ball(), self.directions[0].as_vec3());
        let receiver = Receiver::from(&self.nodes[0].point);
        let direct = f64::from(lights.pmf(&receiver, self.emitter.index).value()) * emission.end;
        let end = f64::from(lights.emitter_pmf(self.emitter.index).value()) * emission.end;
        let area_at_1 = self.cosines(1)[0] / self.lengths2[0];
        let from_light = |first: [f64; 2], of: &dyn Fn(&Factors) -> f64| {
            let rest = (2..k).map(|i| of(&factors[i - 2]) * self.cosines(i)[0] / self.lengths2[i - 1]);
            first.into_iter().chain(rest).collect::<Vec<f64>>()
        };
        let from_camera = |of: &dyn Fn(&Factors) -> f64| {
            let first = of(&factors[0]) * self.cosine_at_light() / self.lengths2[0];
            let rest = (1..k - 1).map(|i| of(&factors[i]) * self.cosines(i)[1] / self.lengths2[i]);
            let last = seen * self.cosines(k - 1)[1];
            std::iter::once(first).chain(rest).chain(std::iter::once(last)).collect::<Vec<f64>>()
        };
        Steps {
            light: from_light([end, emission.ray * area_at_1], &|f| f.to_camera),
            camera: from_camera(&|f| f.to_light),
            direct,
            copied: [from_light([end, area_at_1], &|f| f.copied[0]), from_camera(&|f| f.copied[1])],
            connects: (0..=k).map(|s| self.connects(s, light)).collect(),
        }
    }

    /// Those of the techniques, from those of the vertices.
    pub fn densities(&self, weights: &Weights, steps: &Steps) -> Densities {
        let k = self.k();
        let log = |s: usize| {
            let walks = if s == k { weights.light_walks.ln() } else { 0.0 };
            walks + steps.log_split(0, k, s)
        };
        let can = |s: usize| steps.connects[s] && weights.techniques.has(s, k + 1 - s);
        Densities { log: (0..=k).map(|s| can(s).then(|| log(s)).filter(|log| log.is_finite())).collect() }
    }

    /// Whether the edge to x_s connects two vertices that scatter smoothly, or a walk finds the light.
    fn connects(&self, s: usize, light: &Light) -> bool {
        let smooth = |i: usize| i == 0 || i == self.k() || !self.nodes[i - 1].is_dirac();
        if s == 0 { !light.is_dirac() } else { smooth(s - 1) && smooth(s) }
    }

    /// Whether what the path keeps agrees with where its vertices are: its directions with straight lines, within the errors of
    /// points and the roundings of a direction, and Dirac components with the directions at their vertices.
    ///
    /// # Errors
    /// What does not agree, in a sentence.
    pub fn verify(&self) -> Result<(), String> {
        let straight = FullPath::straight(&self.emitter, &self.nodes, &self.camera, self.directions[0]);
        let straight = straight.ok_or("the camera does not see the last vertex")?;
        for (i, (kept, line)) in self.directions.iter().zip(&straight).enumerate() {
            let (off, slack) = ((*kept - *line).length(), self.direction_slack(i));
            if off > slack {
                return Err(format!("edge {i} is off its line by {off:e}, more than {slack:e}"));
            }
        }
        (1..self.k()).filter(|&i| self.nodes[i - 1].is_dirac()).try_for_each(|i| self.verify_dirac(i))
    }

    /// How far the direction of edge `i` may be off: both points are known within their errors, the near one was moved by its own,
    /// and a unit vector in f32 is rounded some times.
    fn direction_slack(&self, i: usize) -> f64 {
        const ROUNDINGS: f64 = 16.0 * f32::EPSILON as f64;
        let error = |i: usize| match (i, self.emitter.end) {
            (0, End::Surface { error, .. }) => f64::from(error),
            _ if (1..self.k()).contains(&i) => f64::from(self.nodes[i - 1].point.error),
            _ => 0.0,
        };
        ROUNDINGS + 4.0 * (error(i) + error(i + 1)) / self.lengths2[i].sqrt()
    }

    fn verify_dirac(&self, i: usize) -> Result<(), String> {
        let node = &self.nodes[i - 1];
        let seen = self.seen(i).ok_or_else(|| format!("vertex {i} scatters nothing"))?;
        let component = self.component(i, &seen);
        let ((wi, _), wo) = (component.ok_or_else(|| format!("vertex {i} has no such component"))?, seen.wo);
        let made = node.surface.dirac(single(wi), Transport::Camera, node.lobe);
        let made = made.ok_or_else(|| format!("vertex {i} has no such component"))?;
        let off = made.direction.cast::<f64>().plus(wo.reversed());
        let off = off.dot(off).sqrt();
        // Refraction stretches an error of the known direction by 1 / (η cos).
        let stretch = (1.0 + f64::from(made.eta).recip()) / wo.z.abs().min(wi.z.abs());
        let slack = 2.0 * stretch * (self.direction_slack(i - 1) + self.direction_slack(i));
        if off > slack { Err(format!("vertex {i} turns {off:e} from its component, more than {slack:e}")) } else { Ok(()) }
    }
}
