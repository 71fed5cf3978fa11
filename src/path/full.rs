//! The explicit evaluator. It takes a complete path and returns the integrand f(x̄) and the density of every technique,
//! computed from their definitions in f64. It is the reference for the recursive MIS weights, and the basis of methods
//! that mutate paths.
//!
//! Visibility and transmittance of edges are left out; [`super::Content`] adds them. The path names its Dirac
//! components. Their directions are taken from the path, and values and probabilities are those of the component (see
//! [`FullPath::steps`]).

use super::mis::MisStrategy;
use super::{Emitter, MediumPoint, SubpathVertex, SurfaceVertex, Vertex};
use crate::bsdf::shading::folds;
use crate::bsdf::sides::{Sided, Sources};
use crate::bsdf::{Bsdf, Lobes, Surface};
use crate::camera::{Camera, CameraPoint, WiSample};
use crate::geometry::{Frame, Local, SurfacePoint};
use crate::light::{EmitterPoint, Light};
use crate::scene::{Edge, EdgeEnd, Scene};
use crate::spectrum::Spectrum;
use crate::transport::TransportMode;
use glam::{DVec3, Vec3};
use std::borrow::Cow;

/// Interior vertex of a path.
#[derive(Clone)]
pub struct PathVertex {
    /// On a surface or in a medium.
    pub vertex: Vertex<'static>,
    /// Scattering component: one Dirac lobe, or [`Lobes::SMOOTH`].
    pub lobe: Lobes,
}

/// A path x₀ x₁ … x_k from a light to the camera with k ≥ 2 edges.
pub struct FullPath<'a> {
    scene: &'a Scene,
    /// x_k, with the last edge.
    eye: WiSample,
    /// Density per area of x_k in camera subpaths and in connections to the camera.
    lens_pdf: f64,
    emitter: Emitter,
    /// x₁ to x_{k−1}.
    nodes: Vec<PathVertex>,
    /// Unit vectors along the k edges, in the direction of light flow.
    directions: Vec<DVec3>,
    /// Squared lengths of the edges; 1 for an edge from infinity.
    lengths2: Vec<f64>,
}

/// Densities of the techniques that can sample a path.
#[derive(Debug, Clone)]
pub struct Densities {
    /// log p_{s,t} for s = 0 … k, multiplied by the number of subpaths of the technique. `None` for a technique that
    /// cannot sample the path or is disabled.
    pub log: Vec<Option<f64>>,
}

/// Conditional density of each vertex in subpaths from either end, per area.
#[derive(Debug, Clone, Default)]
pub struct VertexPdfs {
    /// Of x₀ … x_{k−1} in a light subpath; for x₀, the density of emission sampling.
    pub light: Vec<f64>,
    /// Of x₀ … x_k in a camera subpath; for x_k, the density of the point of the lens.
    pub camera: Vec<f64>,
    /// Density of x₀ under next-event estimation from x₁.
    pub direct: f64,
    /// Like `light` and `camera`, but of x₀ … x_{k−1}, with the point of the lens and the component of each Dirac
    /// vertex given and every other directional density set to 1.
    pub perturbation: [Vec<f64>; 2],
    /// Whether the edge to xₛ can be sampled by connecting its ends, for s = 0 (where a camera subpath hits the
    /// light) … k.
    pub connects: Vec<bool>,
}

impl Densities {
    /// Returns the MIS weight of technique `s`, p^β over the sum for all techniques; 0 if `s` cannot sample the path.
    pub fn weight(&self, weights: &MisStrategy, s: usize) -> f64 {
        let Some(own) = self.log[s] else { return 0.0 };
        let sum: f64 = self.log.iter().flatten().map(|log| weights.power((log - own).exp())).sum();
        sum.recip()
    }
}

impl VertexPdfs {
    /// Returns the logarithm of the density of x_a … x_{b−1}. Vertices before `s` belong to the light subpath, the
    /// others to the camera subpath.
    pub fn log_split(&self, a: usize, b: usize, s: usize) -> f64 {
        let light: f64 = (a..s).map(|i| if (i, s) == (0, 1) { self.direct.ln() } else { self.light[i].ln() }).sum();
        let camera: f64 = (s..b).map(|i| self.camera[i].ln()).sum();
        light + camera
    }
}

impl PathVertex {
    /// Creates the vertex of a walk that scatters through `lobe`; `None` if it is an endpoint.
    pub fn new(vertex: &SubpathVertex, lobe: Lobes) -> Option<Self> {
        let lobe = if lobe.intersects(Lobes::DIRAC) { lobe } else { Lobes::SMOOTH };
        let vertex = match &vertex.vertex {
            Vertex::Surface(SurfaceVertex { point, surface, state }) => {
                Vertex::Surface(SurfaceVertex { point: *point, surface: Cow::Owned(**surface), state: *state })
            }
            Vertex::Medium(point) => Vertex::Medium(*point),
            Vertex::Camera(_) | Vertex::Light(_) => return None,
        };
        Some(PathVertex { vertex, lobe })
    }

    /// Returns its position.
    pub fn p(&self) -> Vec3 {
        self.vertex.p().expect("an interior vertex is at a place")
    }

    /// Bound on the distance of its position from where it is exactly.
    fn error(&self) -> f64 {
        match &self.vertex {
            Vertex::Surface(at) => f64::from(at.point.error),
            _ => f64::from(2.0 * f32::EPSILON * self.p().abs().max_element()),
        }
    }

    /// Whether the scattering component is a Dirac lobe.
    pub fn is_dirac(&self) -> bool {
        self.lobe.intersects(Lobes::DIRAC)
    }
}

/// F of a vertex, and densities of its directions per solid angle: of wo in a light subpath, of wi in a camera subpath.
/// `perturbation` holds the remaining factors if the component is given and smooth densities are 1.
struct Factors {
    f: Spectrum<f64>,
    to_camera: f64,
    to_light: f64,
    perturbation: [f64; 2],
}

/// Directions of a vertex as passed to its BSDF: see [`crate::bsdf::shading`].
struct Seen {
    wi: Sources<f64>,
    wo: Local<f64>,
    /// Probability that a light subpath takes this wo among all directions that map to `wo`.
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

fn medium_factors(point: &MediumPoint, wi: DVec3, wo: DVec3) -> Factors {
    let value = f64::from(point.phase.eval(wi.as_vec3(), wo.as_vec3()));
    Factors { f: point.scattering.cast::<f64>() * value, to_camera: value, to_light: value, perturbation: [1.0; 2] }
}

fn smooth_factors(surface: &Surface, seen: &Seen) -> Factors {
    let mut all = Factors { f: Spectrum::ZERO, to_camera: 0.0, to_light: 0.0, perturbation: [1.0; 2] };
    for (wi, chosen) in seen.wi.choices() {
        all.f += surface.eval(wi, seen.wo, Lobes::SMOOTH) * (wi.z.abs() / seen.cos_i);
        all.to_camera += surface.pdf(wi, seen.wo, TransportMode::Importance, Lobes::SMOOTH) * chosen * seen.share;
        all.to_light += surface.pdf(seen.wo, wi, TransportMode::Radiance, Lobes::SMOOTH);
    }
    all
}

fn single(w: Local<f64>) -> Local {
    Local::new(w.x as f32, w.y as f32, w.z as f32)
}

fn cosine(w: DVec3, ng: Vec3) -> f64 {
    w.dot(ng.as_dvec3()).abs()
}

/// Returns edge `i` of a path, starting at the end nearer to the camera except for the last edge.
pub fn edge(
    scene: &Scene,
    emitter: &Emitter,
    nodes: &[PathVertex],
    eye: &CameraPoint,
    directions: &[DVec3],
    i: usize,
) -> Edge {
    let (node, w, end) = if i + 1 == directions.len() {
        (&nodes[i - 1], directions[i], EdgeEnd::Camera(*eye))
    } else if i == 0 {
        (&nodes[0], -directions[0], EdgeEnd::Light(emitter.end))
    } else {
        (&nodes[i], -directions[i], nodes[i - 1].vertex.as_end())
    };
    node.vertex.edge_to(scene, w.as_vec3(), end).expect("an interior vertex has edges")
}

impl<'a> FullPath<'a> {
    /// Creates the path from `emitter` through `nodes` to `camera`, whose connection with the last of them is `eye`.
    /// `directions` are unit vectors along its edges in the direction of light flow: those of sampled walks, or
    /// [`FullPath::straight`].
    ///
    /// # Panics
    /// If there is no interior vertex, or if the number of directions is not the number of edges.
    pub fn new(
        scene: &'a Scene,
        camera: &Camera,
        eye: WiSample,
        emitter: Emitter,
        nodes: Vec<PathVertex>,
        directions: Vec<DVec3>,
    ) -> FullPath<'a> {
        assert!(!nodes.is_empty() && directions.len() == nodes.len() + 1, "{} directions", directions.len());
        let points: Vec<DVec3> = nodes.iter().map(|n| n.p().as_dvec3()).collect();
        let first = match emitter.end {
            EmitterPoint::Surface { p, .. } | EmitterPoint::Point(p) => p.as_dvec3().distance_squared(points[0]),
            EmitterPoint::Distant => 1.0,
        };
        let between = points.windows(2).map(|pair| pair[0].distance_squared(pair[1]));
        let last = points[points.len() - 1].distance_squared(eye.eye.p.as_dvec3());
        let lengths2 = std::iter::once(first).chain(between).chain(std::iter::once(last)).collect();
        FullPath { scene, eye, lens_pdf: camera.lens_pdf(), emitter, nodes, directions, lengths2 }
    }

    /// Returns the unit directions of the edges between the vertices and the camera's point `eye`, in f64. `first` is
    /// the direction of light from infinity.
    pub fn straight(emitter: &Emitter, nodes: &[PathVertex], eye: &CameraPoint, first: DVec3) -> Vec<DVec3> {
        let mut points: Vec<DVec3> = nodes.iter().map(|n| n.p().as_dvec3()).collect();
        points.push(eye.p.as_dvec3());
        let begin = match emitter.end {
            EmitterPoint::Surface { p, .. } | EmitterPoint::Point(p) => (points[0] - p.as_dvec3()).normalize(),
            EmitterPoint::Distant => first,
        };
        let between = points.windows(2).map(|pair| (pair[1] - pair[0]).normalize());
        std::iter::once(begin).chain(between).collect()
    }

    /// Returns edge `i`, starting at the end nearer to the camera except for the last edge.
    pub fn edge(&self, i: usize) -> Edge {
        edge(self.scene, &self.emitter, &self.nodes, &self.eye.eye, &self.directions, i)
    }

    /// Emitter endpoint.
    pub fn emitter(&self) -> &Emitter {
        &self.emitter
    }
    /// x₁ to x_{k−1}.
    pub fn nodes(&self) -> &[PathVertex] {
        &self.nodes
    }
    /// Returns the length of edge `i`; 1 for an edge from infinity.
    pub fn length(&self, i: usize) -> f64 {
        self.lengths2[i].sqrt()
    }
    /// Camera endpoint, with the last edge.
    pub fn eye(&self) -> &WiSample {
        &self.eye
    }

    /// Unit vectors along the edges, in the direction of light flow.
    pub fn directions(&self) -> &[DVec3] {
        &self.directions
    }

    /// Number of edges.
    pub fn k(&self) -> usize {
        self.directions.len()
    }

    /// Returns f(x̄) and the conditional densities of the vertices; [`super::Content`] adds what lies on the edges.
    ///
    /// Dirac vertices are measured in projected solid angle. Their factor of f is the value for radiance transport
    /// times |wi·ns| / |wi·ng|. The density of a direction is the probability of the component times |w·ns|, and times
    /// η² toward the camera. Chains of Dirac vertices change the measure by the same factor in f and in all densities;
    /// this factor is left out.
    pub fn steps(&self) -> (Spectrum<f64>, VertexPdfs) {
        let k = self.k();
        let factors: Vec<Factors> = (1..k).map(|i| self.factors(i)).collect();
        let seen = f64::from(self.eye.importance);
        let radiance = if self.is_dark() { Spectrum::ZERO } else { self.emitter.radiance };
        // We G of the last edge: the film covers |cos| importance per area of the scene, and area of the lens.
        let mut f = radiance.cast::<f64>() * (seen * self.cosines(k - 1)[1] * self.lens_pdf);
        for (i, factors) in (1..k).zip(&factors) {
            f = f * factors.f * self.geometry(i - 1);
        }
        (f, self.steps_of(&factors, seen))
    }

    /// Whether the emitter is visible only to the camera and does not illuminate, while a vertex scatters smoothly.
    fn is_dark(&self) -> bool {
        let light = &self.scene.lights().all()[self.emitter.index];
        light.is_only_seen() && !self.nodes.iter().all(PathVertex::is_dirac)
    }

    /// G of edge `i` < k − 1, from xᵢ to xᵢ₊₁.
    fn geometry(&self, i: usize) -> f64 {
        let begins = if i == 0 { self.cosine_at_light() } else { self.cosines(i)[1] };
        begins * self.cosines(i + 1)[0] / self.lengths2[i]
    }

    /// C of x₀; 1 for a point light, and at infinity, where radiance is per solid angle.
    fn cosine_at_light(&self) -> f64 {
        match self.emitter.end {
            EmitterPoint::Surface { ng, .. } => cosine(self.directions[0], ng),
            EmitterPoint::Point(_) | EmitterPoint::Distant => 1.0,
        }
    }

    /// C(x) of xᵢ for wi and wo.
    fn cosines(&self, i: usize) -> [f64; 2] {
        match &self.nodes[i - 1].vertex {
            Vertex::Surface(at) => [self.directions[i - 1], self.directions[i]].map(|w| cosine(w, at.point.ng)),
            _ => [1.0; 2],
        }
    }

    /// Returns the surface of xᵢ; `None` in a medium.
    fn surface(&self, i: usize) -> Option<&SurfaceVertex<'_>> {
        self.nodes[i - 1].vertex.surface()
    }

    /// Returns wi and wo of xᵢ as passed to its BSDF; `None` where F is zero.
    fn seen(&self, i: usize) -> Option<Seen> {
        let point = &self.surface(i)?.point;
        let [wi, wo] = [-self.directions[i - 1], self.directions[i]].map(|w| sided(point, w));
        let ng = local(&point.frame, point.ng.as_dvec3());
        Some(Seen { wi: wi.sources(ng.z, || ng)?, wo: wo.seen()?, share: wo.share(ng.z), cos_i: wi.cos.abs() })
    }

    fn factors(&self, i: usize) -> Factors {
        let node = &self.nodes[i - 1];
        if let Vertex::Medium(point) = &node.vertex {
            return medium_factors(point, -self.directions[i - 1], self.directions[i]);
        }
        let factors = self.seen(i).and_then(|seen| match self.surface(i) {
            Some(at) if !node.is_dirac() => Some(smooth_factors(&at.surface, &seen)),
            _ => self.dirac_factors(i, &seen),
        });
        factors.unwrap_or(Factors { f: Spectrum::ZERO, to_camera: 0.0, to_light: 0.0, perturbation: [0.0; 2] })
    }

    fn dirac_factors(&self, i: usize, seen: &Seen) -> Option<Factors> {
        let (surface, lobe, wo) = (&self.surface(i)?.surface, self.nodes[i - 1].lobe, seen.wo);
        let dirac = |known, mode| surface.dirac(single(known), mode, lobe);
        let (wi, chosen) = self.component(i, seen)?;
        let (camera, light) = (dirac(wi, TransportMode::Importance)?, dirac(wo, TransportMode::Radiance)?);
        let perturbation = [wo.z.abs() * f64::from(camera.eta).powi(2), wi.z.abs()];
        Some(Factors {
            f: light.value.cast::<f64>() * (wi.z.abs() / seen.cos_i),
            to_camera: f64::from(camera.density.value()) * perturbation[0] * chosen * seen.share,
            to_light: f64::from(light.density.value()) * perturbation[1],
            perturbation,
        })
    }

    /// Returns wi of the Dirac component at xᵢ as passed to the BSDF, and the probability that a light subpath selects
    /// it.
    fn component(&self, i: usize, seen: &Seen) -> Option<(Local<f64>, f64)> {
        let at = self.surface(i)?;
        let folds = folds(&at.point, &at.surface, self.directions[i].as_vec3(), self.nodes[i - 1].lobe)?;
        seen.wi.choice(folds.source)
    }

    /// Computes the [`VertexPdfs`].
    fn steps_of(&self, factors: &[Factors], seen: f64) -> VertexPdfs {
        let k = self.k();
        let lights = self.scene.lights();
        let light = &lights.all()[self.emitter.index];
        let (index, end, wi) = (self.emitter.index, &self.emitter.end, -self.directions[0].as_vec3());
        let emission = light.pdf_le(self.scene.ball(), end, -wi);
        let receiver = self.nodes[0].vertex.context().expect("an interior vertex receives light");
        let direct = lights.end_pdf_li(&receiver, index, end, wi, emission.position);
        let made = f64::from(lights.emitter_pmf(index).value()) * emission.position;
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
        let mut camera = from_camera(&|f| f.to_light);
        camera.push(self.lens_pdf);
        VertexPdfs {
            light: from_light([made, emission.direction * area_at_1], &|f| f.to_camera),
            camera,
            direct,
            perturbation: [from_light([made, area_at_1], &|f| f.perturbation[0]), from_camera(&|f| f.perturbation[1])],
            connects: (0..=k).map(|s| self.connects(s, light)).collect(),
        }
    }

    /// Combines the densities of the vertices into those of the techniques.
    pub fn densities(&self, weights: &MisStrategy, steps: &VertexPdfs) -> Densities {
        let k = self.k();
        let log = |s: usize| {
            let walks = if s == k { weights.light_walks.ln() } else { 0.0 };
            walks + steps.log_split(0, k + 1, s)
        };
        let can = |s: usize| steps.connects[s] && weights.techniques.has(s, k + 1 - s);
        Densities { log: (0..=k).map(|s| can(s).then(|| log(s)).filter(|log| log.is_finite())).collect() }
    }

    /// Whether the edge to x_s connects two smooth vertices, or, for s = 0, a camera subpath can hit the light.
    fn connects(&self, s: usize, light: &Light) -> bool {
        let smooth = |i: usize| i == 0 || i == self.k() || !self.nodes[i - 1].is_dirac();
        if s == 0 { !light.is_dirac() } else { smooth(s - 1) && smooth(s) }
    }

    /// Checks the stored directions against the vertex positions. Directions must agree with straight lines, within the
    /// position errors and the rounding of a direction. Dirac components must agree with the directions at their
    /// vertices.
    ///
    /// # Errors
    /// A sentence that describes the first mismatch.
    pub fn verify(&self) -> Result<(), String> {
        let straight = FullPath::straight(&self.emitter, &self.nodes, &self.eye.eye, self.directions[0]);
        for (i, (kept, line)) in self.directions.iter().zip(&straight).enumerate() {
            let (off, slack) = ((*kept - *line).length(), self.direction_slack(i));
            if off > slack {
                return Err(format!("edge {i} is off its line by {off:e}, more than {slack:e}"));
            }
        }
        (1..self.k()).filter(|&i| self.nodes[i - 1].is_dirac()).try_for_each(|i| self.verify_dirac(i))
    }

    /// Tolerance for the direction of edge `i`. Both points have position errors, the near one was offset by its own,
    /// and a unit vector in f32 is rounded several times.
    fn direction_slack(&self, i: usize) -> f64 {
        const ROUNDINGS: f64 = 16.0 * f32::EPSILON as f64;
        let error = |i: usize| match (i, self.emitter.end) {
            (0, EmitterPoint::Surface { error, .. }) => f64::from(error),
            _ if (1..self.k()).contains(&i) => self.nodes[i - 1].error(),
            _ => 0.0,
        };
        ROUNDINGS + 4.0 * (error(i) + error(i + 1)) / self.lengths2[i].sqrt()
    }

    fn verify_dirac(&self, i: usize) -> Result<(), String> {
        let (lobe, surface) = (self.nodes[i - 1].lobe, self.surface(i).map(|at| &at.surface));
        let surface = surface.ok_or_else(|| format!("vertex {i} is not on a surface"))?;
        let seen = self.seen(i).ok_or_else(|| format!("vertex {i} scatters nothing"))?;
        let component = self.component(i, &seen);
        let ((wi, _), wo) = (component.ok_or_else(|| format!("vertex {i} has no such component"))?, seen.wo);
        let made = surface.dirac(single(wi), TransportMode::Importance, lobe);
        let made = made.ok_or_else(|| format!("vertex {i} has no such component"))?;
        let off = made.direction.cast::<f64>().plus(wo.reversed());
        let off = off.dot(off).sqrt();
        // Refraction scales an error of the known direction by 1 / (η cos).
        let stretch = (1.0 + f64::from(made.eta).recip()) / wo.z.abs().min(wi.z.abs());
        let slack = 2.0 * stretch * (self.direction_slack(i - 1) + self.direction_slack(i));
        if off > slack {
            Err(format!("vertex {i} turns {off:e} from its component, more than {slack:e}"))
        } else {
            Ok(())
        }
    }
}
