//! Multiple importance sampling weights over all techniques that can sample a path: a partition of unity computed from
//! density ratios.
//!
//! **Recursive evaluation**, by [`MisStrategy`] and [`PartialMis`]: each subpath vertex stores two partial sums. They
//! determine the density ratios of all techniques that split the path before it, up to factors of the edges that
//! follow. A connection then costs two sums of two products [Georgiev12]. The reference evaluation by definition is in
//! [`super::full`].
//!
//! Let x₀ x₁ … be the vertices of a subpath. Let pᵢ be the forward density of xᵢ and rᵢ its reverse density, both per
//! area. The sum of density ratios over the techniques that split the path at or before xᵢ, relative to a technique
//! that splits after it, is rᵢ/pᵢ (cᵢ + rᵢ₋₁/pᵢ₋₁ (cᵢ₋₁ + …)). Here cᵢ is 1 if the edge between xᵢ₋₁ and xᵢ can be
//! connected, and 0 otherwise. At xᵢ, the factors rᵢ and rᵢ₋₁ are only partly known: rᵢ₋₁ = q g, with q the density per
//! solid angle at xᵢ and g = C(xᵢ₋₁) / d². q is known when the walk or the connection leaves xᵢ. So the sum is
//! rᵢ (a + q b), with a in [`PartialMis::vc`] and b in [`PartialMis::vc_prev`]. Every ratio is raised to the power of
//! the heuristic first.
//!
//! Densities include neither roulette nor surfaces that a walk passes, so that weights are functions of the path. In
//! media that scatter, a walk reaches the end of an edge by a free flight, with the density [`crate::medium::density`]
//! of the end; where lanes differ, that of the walk's own prior would be a function of its technique. It is a factor of
//! pᵢ and, with the other end, of rᵢ₋₁; a connection of both ends has no such factor. So it includes the transmittance
//! of these media.
//!
//! Reference: [Veach97 §10.2].

use crate::medium::density;
use crate::sampling::Heuristic;
use crate::spectrum::Spectrum;
use glam::Vec3;

/// Kind of technique, as named on the command line, in `render.toml` and in reports.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    serde::Serialize,
    serde::Deserialize,
    strum::VariantArray,
    strum::IntoStaticStr,
    strum::EnumMessage,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Technique {
    /// Camera subpaths hit an emitter (s = 0).
    Hit,
    /// Next-event estimation (s = 1).
    NextEvent,
    /// Connections between vertices of both subpaths (s, t ≥ 2).
    Connect,
    /// Connections of light subpath vertices to the camera (t = 1).
    Splat,
}

/// The enabled kinds of techniques. Disabled ones are left out of all weights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Techniques {
    /// s = 0: camera subpaths hit emitters.
    pub hit: bool,
    /// s = 1: next-event estimation.
    pub next_event: bool,
    /// s, t ≥ 2: connections between a light subpath and a camera subpath.
    pub connect: bool,
    /// t = 1: connections of light subpath vertices to the camera.
    pub splat: bool,
}

impl Techniques {
    /// All techniques.
    pub const ALL: Techniques = Techniques { hit: true, next_event: true, connect: true, splat: true };
    /// Light tracing. Directly visible emission always belongs to s = 0.
    pub const LIGHT: Techniques = Techniques { hit: false, next_event: false, connect: false, splat: true };

    /// All techniques except those in `left_out`.
    pub fn without(left_out: &[Technique]) -> Self {
        let has = |technique| !left_out.contains(&technique);
        Techniques {
            hit: has(Technique::Hit),
            next_event: has(Technique::NextEvent),
            connect: has(Technique::Connect),
            splat: has(Technique::Splat),
        }
    }

    /// Returns the disabled kinds.
    pub fn disabled(&self) -> Vec<Technique> {
        use crate::named::Named;
        let Techniques { hit, next_event, connect, splat } = *self;
        let is_disabled = |technique: &Technique| match technique {
            Technique::Hit => !hit,
            Technique::NextEvent => !next_event,
            Technique::Connect => !connect,
            Technique::Splat => !splat,
        };
        Technique::all().iter().copied().filter(is_disabled).collect()
    }

    /// Whether the technique with `s` light vertices and `t` camera vertices is enabled. Paths of one edge belong to
    /// s = 0.
    pub fn has(&self, s: usize, t: usize) -> bool {
        match (s, t) {
            (0, 2) => true,
            (_, 0) | (0 | 1, 1) => false,
            (0, _) => self.hit,
            (_, 1) => self.splat,
            (1, _) => self.next_event,
            _ => self.connect,
        }
    }
}

/// MIS parameters shared by a whole render.
#[derive(Debug, Clone, Copy)]
pub struct MisStrategy {
    /// Enabled techniques.
    pub techniques: Techniques,
    /// Heuristic that combines the techniques.
    pub heuristic: Heuristic,
    /// Light subpaths per camera subpath through a pixel's area of film: the number of light subpaths in a pass.
    pub light_walks: f64,
}

/// Partial MIS sums at a vertex xᵢ of a subpath, over the techniques that split the path before it: see the module's
/// head.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PartialMis {
    /// dVC-like term of the technique that splits at the edge to xᵢ: the density ratio without the factor rᵢ, which is
    /// supplied when xᵢ is connected. The factor that enables [`Techniques::connect`] is also applied later, since at a
    /// light the same edge belongs to next-event estimation.
    pub vc: f64,
    /// Sum of the techniques that split earlier, without the factors rᵢ q.
    pub vc_prev: f64,
    /// dVM-like term of the techniques that merge at an earlier vertex; 0 without merging.
    pub vm: f64,
    /// Index of the vertex in its subpath, from 0.
    pub index: u32,
}

/// Densities of free flights along an edge: see [`crate::medium::density`].
#[derive(Debug, Clone, Copy)]
pub struct FlightPdfs {
    /// Of its end, from its start.
    pub forward: f64,
    /// Of its start, from its end.
    pub reverse: f64,
}

impl FlightPdfs {
    /// Without media that scatter.
    pub const CERTAIN: FlightPdfs = FlightPdfs { forward: 1.0, reverse: 1.0 };

    /// Returns those of an edge whose media have the transmittance `through`, with the extinction at its two ends: see
    /// [`super::Vertex::extinction`].
    #[inline]
    pub fn new(through: Spectrum, start: Spectrum, end: Spectrum) -> Self {
        let [forward, reverse] = [end, start].map(|extinction| f64::from(density(through, extinction)));
        FlightPdfs { forward, reverse }
    }
}

/// Origin of a subpath edge.
#[derive(Debug, Clone, Copy)]
pub enum EdgeOrigin {
    /// On a surface.
    Surface {
        /// The point.
        p: Vec3,
        /// Its geometric normal.
        ng: Vec3,
    },
    /// In a medium.
    Medium {
        /// The point.
        p: Vec3,
        /// σt there.
        extinction: Spectrum,
    },
    /// At a point light.
    Point(Vec3),
    /// At the camera or at infinity. The known density is per area perpendicular to the edge, at its end.
    Distant,
}

impl EdgeOrigin {
    /// Returns σt if it lies in a medium, else 1.
    #[inline]
    pub fn extinction(&self) -> Spectrum {
        if let EdgeOrigin::Medium { extinction, .. } = self { *extinction } else { Spectrum::ONE }
    }
}

/// Subpath edge with an end not yet found.
#[derive(Debug, Clone, Copy)]
pub struct MisEdge {
    /// Partial sums of the vertex at its origin.
    pub before: PartialMis,
    /// Forward density of its direction; for a different measure see [`EdgeOrigin::Distant`].
    pub forward: f64,
    /// Reverse density of the direction of arrival: q of `before`.
    pub reverse: f64,
    /// Factor of the technique that splits at this edge: 0 if it is impossible, 1 between surfaces.
    pub split: f64,
    /// Factor of the technique that splits at the previous edge.
    pub split_before: f64,
    /// Origin of the edge.
    pub start: EdgeOrigin,
}

/// Squared distance of two vertices, clamped above 0, since surfaces may coincide. It cancels between the forward and
/// reverse densities along the edge, both of which must stay finite.
#[inline]
fn squared_distance(a: Vec3, b: Vec3) -> f64 {
    f64::from(a.distance_squared(b).max(f32::MIN_POSITIVE))
}

/// |w·ng| in f64.
#[inline]
fn cosine(w: Vec3, ng: Vec3) -> f64 {
    f64::from(w.dot(ng).abs())
}

impl MisStrategy {
    /// Raises a density ratio to the power of the heuristic.
    #[inline]
    pub fn power(&self, ratio: f64) -> f64 {
        match self.heuristic {
            Heuristic::Balance => ratio,
            Heuristic::Power => ratio * ratio,
        }
    }

    /// Returns 1 for an enabled technique and 0 for a disabled one.
    #[inline]
    fn factor(on: bool) -> f64 {
        f64::from(u8::from(on))
    }

    /// Returns the edge from the camera. Its density is the magnification at its end, in pixels of film per
    /// perpendicular area.
    #[inline]
    pub fn from_camera(&self) -> MisEdge {
        let split = Self::factor(self.techniques.splat) * self.power(self.light_walks);
        let before = PartialMis::default();
        MisEdge { before, forward: 0.0, reverse: 0.0, split, split_before: 0.0, start: EdgeOrigin::Distant }
    }

    /// Returns the edge from a light with emission densities `end` (position, including the selection probability of
    /// the light) and `ray` (direction). Camera subpaths can hit the light unless it `is_dirac`. The factor of
    /// next-event estimation depends on the receiver: see [`MisStrategy::received`].
    #[inline]
    pub fn from_light(&self, end: f64, ray: f64, is_dirac: bool, start: EdgeOrigin) -> MisEdge {
        let a = if is_dirac { 0.0 } else { Self::factor(self.techniques.hit) * self.power(end.recip()) };
        MisEdge {
            before: PartialMis { vc: a, ..PartialMis::default() },
            forward: ray,
            reverse: 0.0,
            split: 0.0,
            split_before: 1.0,
            start,
        }
    }

    /// Completes the edge `link` from a light whose receiver is known. `direct` is the density with which next-event
    /// estimation samples the light's endpoint from there, `end` that of emission.
    #[inline]
    pub fn received(&self, link: &mut MisEdge, direct: f64, end: f64) {
        link.split = Self::factor(self.techniques.next_event) * self.power(direct / end);
    }

    /// Returns the edge that leaves a vertex with partial sums `sums` at `start`. `densities` are forward and reverse;
    /// `is_dirac` marks a Dirac component.
    #[inline]
    pub fn from_vertex(
        &self,
        sums: PartialMis,
        [forward, reverse]: [f64; 2],
        is_dirac: bool,
        start: EdgeOrigin,
    ) -> MisEdge {
        let split = Self::factor(!is_dirac);
        MisEdge { before: sums, forward, reverse, split, split_before: split * self.inner(sums.index), start }
    }

    /// Factor of the technique that splits before vertex `index`, for an interior vertex. Endpoints include theirs in
    /// `a`.
    #[inline]
    fn inner(&self, index: u32) -> f64 {
        if index < 2 { 1.0 } else { Self::factor(self.techniques.connect) }
    }

    /// Returns the partial sums at a vertex at `p`, reached by `link` along the unit direction `w` in a flight with the
    /// densities `flight`; `cos` is its C(x).
    #[inline(always)] // one call in a walk without media
    pub fn arrive(&self, link: &MisEdge, p: Vec3, cos: f32, w: Vec3, flight: FlightPdfs) -> PartialMis {
        let cos = f64::from(cos);
        let (made, back) = match link.start {
            EdgeOrigin::Distant => (link.forward * cos, 1.0),
            EdgeOrigin::Point(from) => (link.forward * cos / squared_distance(from, p), 0.0),
            EdgeOrigin::Surface { p: from, ng } => {
                let d2 = squared_distance(from, p);
                (link.forward * cos / d2, cosine(w, ng) / d2)
            }
            EdgeOrigin::Medium { p: from, .. } => {
                let d2 = squared_distance(from, p);
                (link.forward * cos / d2, d2.recip())
            }
        };
        self.push_vertex(link, made * flight.forward, back * flight.reverse)
    }

    /// Returns the partial sums at infinity in the unit direction `w`, reached in a flight with the densities `flight`.
    #[inline]
    pub fn escape(&self, link: &MisEdge, w: Vec3, flight: FlightPdfs) -> PartialMis {
        let back = match link.start {
            EdgeOrigin::Surface { ng, .. } => cosine(w, ng),
            _ => 1.0,
        };
        self.push_vertex(link, link.forward * flight.forward, back * flight.reverse)
    }

    /// Appends a vertex with forward density `made`. `back` converts a density per solid angle at the vertex to one per
    /// area at the previous vertex.
    #[inline]
    fn push_vertex(&self, link: &MisEdge, made: f64, back: f64) -> PartialMis {
        let before = link.split_before * link.before.vc + self.power(link.reverse) * link.before.vc_prev;
        PartialMis {
            vc: link.split * self.power(made.recip()),
            vc_prev: self.power(back / made) * before,
            vm: 0.0,
            index: link.before.index + 1,
        }
    }

    /// Returns the sum over the techniques that split before a vertex with `sums`, relative to one that splits after
    /// it. The opposite subpath samples the vertex with density `made` per area, and the direction onward with
    /// `reverse` per solid angle.
    #[inline]
    pub fn earlier(&self, sums: &PartialMis, made: f64, reverse: f64) -> f64 {
        self.power(made) * (self.inner(sums.index) * sums.vc + self.power(reverse) * sums.vc_prev)
    }

    /// Returns the MIS weight of emission hit by a camera subpath at a vertex with `sums`. `direct` and `end` are the
    /// densities of the endpoint, from the vertex before it under next-event estimation and under emission sampling;
    /// `ray` is the emission density of the direction.
    #[inline]
    pub fn hit(&self, sums: &PartialMis, [direct, end]: [f64; 2], ray: f64) -> f64 {
        if sums.index < 2 {
            return 1.0;
        }
        let next_event = Self::factor(self.techniques.next_event) * self.power(direct) * sums.vc;
        1.0 / (1.0 + next_event + self.power(end) * self.power(ray) * sums.vc_prev)
    }

    /// Returns the density ratio of hitting a light instead of sampling it. `hit` is the density of the direction at the
    /// receiver over that of the sample, 0 for a Dirac light.
    #[inline]
    pub fn instead_of_sample(&self, hit: f64) -> f64 {
        Self::factor(self.techniques.hit) * self.power(hit)
    }

    /// Returns the sum of the density ratios of the techniques that sample the vertex with `sums` from the camera,
    /// relative to a connection to the camera. `seen` is the density per area with which camera rays sample the vertex,
    /// `reverse` the density of the direction toward the light.
    #[inline]
    pub fn instead_of_splat(&self, sums: &PartialMis, seen: f64, reverse: f64) -> f64 {
        self.earlier(sums, seen / self.light_walks, reverse)
    }

    /// Returns the MIS weight of a connection. `others` are the density ratios of the techniques that walk along the edge
    /// instead, to its end and to its start, without the densities `flight` of free flights.
    #[inline]
    pub fn connection(&self, [to_end, to_start]: [f64; 2], flight: FlightPdfs) -> f64 {
        1.0 / (1.0 + to_end * self.power(flight.forward) + to_start * self.power(flight.reverse))
    }
}
