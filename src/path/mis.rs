//! Weights of multiple importance sampling over all techniques that make a path: a partition of unity from density ratios.
//!
//! **Fast**, by [`Weights`] and [`Sums`]: each vertex of a walk carries two numbers, with which the densities of all techniques that
//! split the path before it are known up to what comes after, so that a connection costs two sums of two products
//! [Georgiev12]. The definition that referees them is [`super::full`]'s.
//!
//! For the vertices x₀ x₁ … of a walk, with pᵢ the density that made xᵢ and rᵢ the one that a walk the other way would have made it
//! with, both per area, the sum over the techniques that split the path at or before xᵢ, relative to one behind it, is
//! rᵢ/pᵢ (cᵢ + rᵢ₋₁/pᵢ₋₁ (cᵢ₋₁ + …)), where cᵢ says whether the edge between xᵢ₋₁ and xᵢ can be connected. Of rᵢ and rᵢ₋₁ only the parts
//! before xᵢ are known at xᵢ: rᵢ₋₁ = q g, with q the density per solid angle at xᵢ, known when the walk or the connection leaves xᵢ, and
//! g = C(xᵢ₋₁) / d². So the sum is rᵢ (a + q b). Every ratio is raised to the heuristic's power first.
//!
//! Roulette and the transmittance of edges are left out of all densities: weights remain functions of the path. Reference: [Veach97 §10.2].

use crate::defects::{Defect, planted};
use crate::sampling::Heuristic;
use glam::Vec3;

/// A kind of technique, as the command line, `render.toml` and reports name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Technique {
    /// Walks from the camera find light by chance (s = 0).
    Hit,
    /// Lights are sampled by what they fall on (s = 1).
    NextEvent,
    /// Vertices of both walks are connected (s, t ≥ 2).
    Connect,
    /// Vertices of walks from lights are connected with the camera (t = 1).
    Splat,
}

/// Which kinds of techniques take part; the others leave every weight.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Techniques {
    /// s = 0: walks from the camera find light.
    pub hit: bool,
    /// s = 1: a light is sampled by the vertex that it falls on.
    pub next_event: bool,
    /// s, t ≥ 2: a vertex of a walk from a light is connected with one of a walk from the camera.
    pub connect: bool,
    /// t = 1: a vertex of a walk from a light is connected with the camera.
    pub splat: bool,
}

impl Techniques {
    /// All there are.
    pub const ALL: Techniques = Techniques { hit: true, next_event: true, connect: true, splat: true };
    /// Light tracing. What the camera sees without scattering belongs to s = 0 in any case.
    pub const LIGHT: Techniques = Techniques { hit: false, next_event: false, connect: false, splat: true };

    /// All but some.
    pub fn without(left_out: &[Technique]) -> Self {
        let has = |technique| !left_out.contains(&technique);
        Techniques {
            hit: has(Technique::Hit),
            next_event: has(Technique::NextEvent),
            connect: has(Technique::Connect),
            splat: has(Technique::Splat),
        }
    }

    /// Whether the technique of `s` vertices from a light and `t` from the camera takes part. Paths of one edge belong to s = 0.
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

/// What the weights of a render have in common.
#[derive(Debug, Clone, Copy)]
pub struct Weights {
    /// What takes part.
    pub techniques: Techniques,
    /// How techniques share a path.
    pub heuristic: Heuristic,
    /// Walks from lights for each walk from the camera through a pixel's area of film: as many as a pass has.
    pub light_walks: f64,
}

/// What a vertex xᵢ of a walk knows of the techniques that split the path before it: see the module's head.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sums {
    /// Of the technique that splits at the edge to xᵢ, over rᵢ. It does not say yet whether connections take part, since at a light the
    /// same edge is next-event estimation's.
    pub a: f64,
    /// Of all that split before, over rᵢ q.
    pub b: f64,
    /// Number of the vertex in its walk, from 0.
    pub index: u32,
}

/// Where an edge of a walk begins.
#[derive(Debug, Clone, Copy)]
pub enum Start {
    /// At a point of a surface.
    Surface {
        /// The point.
        p: Vec3,
        /// Its geometric normal.
        ng: Vec3,
    },
    /// At a point in space.
    Point(Vec3),
    /// At the camera or at infinity: what is known is the density per area perpendicular to the edge where it ends.
    Far,
}

/// An edge of a walk whose end is not known yet.
#[derive(Debug, Clone, Copy)]
pub struct Link {
    /// Of the vertex where it begins.
    pub before: Sums,
    /// Density of its direction; of what else, see [`Start::Far`].
    pub forward: f64,
    /// Density of the direction that the walk came from, for a walk the other way: q of `before`.
    pub reverse: f64,
    /// Factor of the technique that splits at this edge: 0 if it cannot, 1 between surfaces.
    pub split: f64,
    /// Factor of the one that splits at the edge before.
    pub split_before: f64,
    /// Where it begins.
    pub start: Start,
}

/// |w·ng| in f64.
/// The squared distance of two vertices. Where surfaces coincide it may be 0; it is in densities of both ways along the edge, which it must
/// leave finite, and cancels.
#[inline]
fn squared_distance(a: Vec3, b: Vec3) -> f64 {
    f64::from(a.distance_squared(b).max(f32::MIN_POSITIVE))
}

#[inline]
fn cosine(w: Vec3, ng: Vec3) -> f64 {
    f64::from(w.dot(ng).abs())
}

impl Weights {
    /// A ratio of densities to the heuristic's power.
    #[inline]
    pub fn power(&self, ratio: f64) -> f64 {
        match self.heuristic {
            Heuristic::Balance => ratio,
            Heuristic::Power => ratio * ratio,
        }
    }

    /// Factor of a technique that takes part or not.
    #[inline]
    fn factor(on: bool) -> f64 {
        f64::from(u8::from(on))
    }

    /// The edge from the camera. Its density is the magnification where it ends, in pixels of film per perpendicular area.
    #[inline]
    pub fn from_camera(&self) -> Link {
        let walks = if planted(Defect::SplatsCountedOnce) { 1.0 } else { self.light_walks };
        let split = Self::factor(self.techniques.splat) * self.power(walks);
        let before = Sums::default();
        Link { before, forward: 0.0, reverse: 0.0, split, split_before: 0.0, start: Start::Far }
    }

    /// The edge from a light with emission densities `end` and `ray`, the light's probability in `end`; `direct` is that by which a
    /// receiver would choose the same end. A walk from the camera finds the light unless it `is_dirac`.
    #[inline]
    pub fn from_light(&self, end: f64, ray: f64, direct: f64, is_dirac: bool, start: Start) -> Link {
        let a = if is_dirac { 0.0 } else { Self::factor(self.techniques.hit) * self.power(end.recip()) };
        let split = Self::factor(self.techniques.next_event) * self.power(direct / end);
        Link { before: Sums { a, b: 0.0, index: 0 }, forward: ray, reverse: 0.0, split, split_before: 1.0, start }
    }

    /// The edge that leaves a vertex with `sums` at `p` with `densities` forward and in reverse, through a Dirac component or not.
    #[inline]
    pub fn from_vertex(&self, sums: Sums, [forward, reverse]: [f64; 2], is_dirac: bool, p: Vec3, ng: Vec3) -> Link {
        let split = Self::factor(!is_dirac || planted(Defect::DiracConnects));
        let reverse = if planted(Defect::ReversePdfForgotten) { forward } else { reverse };
        Link {
            before: sums,
            forward,
            reverse,
            split,
            split_before: split * self.inner(sums.index),
            start: Start::Surface { p, ng },
        }
    }

    /// Factor of the technique that splits before vertex `index`, where it is no end's: ends have theirs in `a` already.
    #[inline]
    fn inner(&self, index: u32) -> f64 {
        if index < 2 { 1.0 } else { Self::factor(self.techniques.connect) }
    }

    /// The sums at the point `p` of a surface that `link` has led to along the unit direction `w`.
    #[inline]
    pub fn arrive(&self, link: &Link, p: Vec3, ng: Vec3, w: Vec3) -> Sums {
        let cos = cosine(w, ng);
        let (made, back) = match link.start {
            Start::Far => (link.forward * cos, 1.0),
            Start::Point(from) => (link.forward * cos / squared_distance(from, p), 0.0),
            Start::Surface { p: from, ng } => {
                let d2 = squared_distance(from, p);
                (link.forward * cos / d2, cosine(w, ng) / d2)
            }
        };
        self.extend(link, made, back)
    }

    /// The sums at infinity in the unit direction `w`.
    #[inline]
    pub fn leave(&self, link: &Link, w: Vec3) -> Sums {
        let back = match link.start {
            Start::Surface { ng, .. } if !planted(Defect::InfinityHasDistance) => cosine(w, ng),
            _ => 1.0,
        };
        self.extend(link, link.forward, back)
    }

    /// With the density `made` of the new vertex, and the factor `back` that makes a density per area of one per solid angle at it.
    #[inline]
    fn extend(&self, link: &Link, made: f64, back: f64) -> Sums {
        let before = link.split_before * link.before.a + self.power(link.reverse) * link.before.b;
        Sums { a: link.split * self.power(made.recip()), b: self.power(back / made) * before, index: link.before.index + 1 }
    }

    /// The techniques that split before a vertex with `sums`, relative to one behind it: the other walk would make the vertex with
    /// density `made` per area, and its direction from there with `reverse` per solid angle.
    #[inline]
    pub fn earlier(&self, sums: &Sums, made: f64, reverse: f64) -> f64 {
        self.power(made) * (self.inner(sums.index) * sums.a + self.power(reverse) * sums.b)
    }

    /// The weight of light that a walk from the camera found at a vertex with `sums`: a receiver would have chosen its end with
    /// density `direct`, and emission would have made it with `end` and the direction with `ray`.
    #[inline]
    pub fn hit(&self, sums: &Sums, direct: f64, end: f64, ray: f64) -> f64 {
        if sums.index < 2 {
            return 1.0;
        }
        let ratio = if planted(Defect::DirectPdfIsEmissions) { end * ray } else { direct };
        let next_event = Self::factor(self.techniques.next_event) * self.power(ratio) * sums.a;
        1.0 / (1.0 + next_event + self.power(end) * self.power(ray) * sums.b)
    }

    /// The weight of a sampled light: `hit` is the density with which scattering would have found it over that of the sample, 0 for a
    /// light without extent, and `earlier` what [`Weights::earlier`] says of the camera's walk.
    #[inline]
    pub fn next_event(&self, hit: f64, earlier: f64) -> f64 {
        1.0 / (1.0 + Self::factor(self.techniques.hit) * self.power(hit) + earlier)
    }

    /// The weight of a connection of two vertices, from what [`Weights::earlier`] says of both walks.
    #[inline]
    pub fn connection(&self, light: f64, camera: f64) -> f64 {
        1.0 / (1.0 + light + camera)
    }

    /// The weight of a connection with the camera that sees the vertex with density `seen` per area, its direction to the light coming
    /// back with `reverse`.
    #[inline]
    pub fn splat(&self, sums: &Sums, seen: f64, reverse: f64) -> f64 {
        let walks = if planted(Defect::SplatsCountedOnce) { 1.0 } else { self.light_walks };
        1.0 / (1.0 + self.earlier(sums, seen / walks, reverse))
    }
}
