//! Bodies: solids that light passes through, what is inside them, and which of those that share a place has its medium there.
//!
//! A body is an instance, or that part of it whose inside is the same, with a material that transmits light and has a volume. Parts that
//! are open belong together if their insides are the same: the faces of one body may be nodes of their own. Where
//! bodies overlap one has the place: the one of the highest `priority` (`extras.etendue.priority` of its material), then the one with the
//! smaller bounding box, since what lies inside another is smaller, then the later one in the file. The boundary of one that does not
//! have the place is not there. Indices of bodies are their ranks in that order.
//!
//! An open body, such as a surface of water, has no inside that a box could tell: it counts as large as a cube of its longest side, and
//! as one that may share places with every other. A body that shares no place with one that is entered has been left, whatever was crossed.
//!
//! Limits: bodies are taken to have their fronts outward; an open one bends light where it is crossed, and its inside
//! has no other end than a surface with the same. Surfaces that alpha masks cut away do not count as crossed. Of those behind a body in
//! precedence that share places with it, [`Bodies::MOST_OTHERS`] are told apart.

use super::material::Material;
use super::{ObjectInfo, Scene};
use crate::defects::{Defect, planted};
use crate::geometry::{Bodies, Bounded, Bounds, BoxTree, Geometry, Ray, SurfacePoint, TriangleMesh};
use crate::light::End;
use crate::sampling::mix64;
use crate::spectrum::Spectrum;
use glam::Vec3;
use smallvec::SmallVec;
use std::cmp::Ordering;
use std::collections::HashMap;
use std::ops::ControlFlow::{Break, Continue};

/// What is inside a material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Interior {
    /// Absorption coefficient per scene unit of length.
    pub(super) absorption: Spectrum,
    /// Refractive index.
    pub(super) ior: f32,
    /// See the module's head.
    pub(super) priority: i32,
}

impl Interior {
    /// What may be told apart.
    fn key(&self) -> ([u32; 4], i32) {
        let [r, g, b] = self.absorption.0;
        ([r, g, b, self.ior].map(f32::to_bits), self.priority)
    }
}

/// A solid that light passes through.
#[derive(Debug, Clone, Copy)]
pub(super) struct Body {
    pub(super) interior: Interior,
    bounds: Bounds,
    is_open: bool,
}

impl Body {
    /// By precedence; of equal ones the later.
    fn precedes(&self, other: &Body) -> Ordering {
        let priority = other.interior.priority.cmp(&self.interior.priority);
        let priority = if planted(Defect::PriorityReversed) { priority.reverse() } else { priority };
        priority.then(self.size().total_cmp(&other.size()))
    }

    fn size(&self) -> f32 {
        if self.is_open { (self.bounds.max - self.bounds.min).max_element().powi(3) } else { self.bounds.volume() }
    }
}

/// The box of a body.
#[derive(Debug)]
struct Place {
    rank: u32,
    bounds: Bounds,
}

impl Bounded for Place {
    fn bounds(&self) -> Bounds {
        self.bounds
    }
}

/// The bodies of a place, by rank.
type Members = SmallVec<[u32; 8]>;

/// All bodies, by rank.
#[derive(Debug, Default)]
pub(super) struct AllBodies {
    list: Vec<Body>,
    /// Of each body those of higher rank that it may share places with, by rank; empty if no two may.
    behind: Vec<Members>,
    places: BoxTree<Place>,
}

/// No more pairs of bodies are looked at to know which may share places: where boxes overlap so much, what is beyond is forgotten.
const MOST_PAIRS: usize = 1 << 24;

/// No more surfaces are passed on the way out of a place.
const MOST_CROSSED: u32 = 1 << 14;

/// The way out of a place: mostly upward, so that what lies below an open surface of water is inside it, and along no plane or edge
/// that models are likely to have.
const OUT: Vec3 = Vec3::new(0.230_84, 0.936_27, 0.265_31);

/// A sum over the edges of a mesh that have no second triangle on their other side: 0 if there are none, but for one mesh in 2⁶⁴.
fn open_edges(mesh: &TriangleMesh) -> u64 {
    // −0 and 0 are one coordinate.
    let vertex = |i: u32| (mesh.positions()[i as usize] + 0.0).to_array().map(|x: f32| u64::from(x.to_bits()));
    let point = |i: u32| vertex(i).into_iter().fold(0, |hash, bits| mix64(hash ^ bits).rotate_left(21));
    let edge = |from: u64, to: u64| mix64(from.wrapping_add(to.rotate_left(32)));
    let sum = |t: &[u32; 3]| {
        let [a, b, c] = t.map(point);
        let edges = [(a, b), (b, c), (c, a)];
        edges.into_iter().fold(0u64, |sum, (a, b)| sum.wrapping_add(edge(a, b)).wrapping_sub(edge(b, a)))
    };
    mesh.triangles().iter().fold(0, |total, t| total.wrapping_add(sum(t)))
}

impl AllBodies {
    /// Those of all objects, which are told theirs.
    pub(super) fn find(geometry: &Geometry, objects: &mut [ObjectInfo], materials: &[Material]) -> Self {
        let mut parts: HashMap<_, u64> = HashMap::new();
        let part = |object: &ObjectInfo| Some((object.instance, materials[object.material as usize].interior?.key()));
        for (index, object) in (0..).zip(&*objects) {
            let Some(part) = part(object) else { continue };
            let sum = parts.entry(part).or_default();
            *sum = sum.wrapping_add(open_edges(geometry.mesh_of(index)));
        }
        let mut found: Vec<Body> = Vec::new();
        let mut known = HashMap::new();
        for (index, object) in (0..).zip(objects.iter_mut()) {
            let (Some(interior), Some(part)) = (materials[object.material as usize].interior, part(object)) else { continue };
            let bounds = geometry.bounds(index);
            let is_closed = parts[&part] == 0;
            let id = *known.entry((is_closed.then_some(part.0), part.1)).or_insert_with(|| {
                found.push(Body { interior, bounds, is_open: !is_closed });
                found.len() - 1
            });
            found[id].bounds = found[id].bounds.union(bounds);
            object.body = id as u32;
        }
        let mut order: Vec<usize> = (0..found.len()).rev().collect();
        order.sort_by(|&a, &b| found[a].precedes(&found[b]));
        let mut ranks = vec![0; found.len()];
        order.iter().enumerate().for_each(|(rank, &id)| ranks[id] = rank as u32);
        for object in objects.iter_mut().filter(|o| o.body != Bodies::NOBODY) {
            object.body = ranks[object.body as usize];
        }
        AllBodies::ranked(order.into_iter().map(|id| found[id]).collect())
    }

    /// Those in `list`, which is by rank.
    fn ranked(list: Vec<Body>) -> Self {
        let places = list.iter().zip(0..).map(|(body, rank)| Place { rank, bounds: body.bounds }).collect();
        let mut bodies = AllBodies { list, behind: Vec::new(), places: BoxTree::new(places) };
        let behind = bodies.overlaps();
        if behind.iter().any(|list| !list.is_empty()) {
            bodies.behind = behind;
        }
        bodies
    }

    /// See [`AllBodies::behind`].
    fn overlaps(&self) -> Vec<Members> {
        let mut pairs = 0;
        let open: Members = (0..).zip(&self.list).filter(|(_, body)| body.is_open).map(|(rank, _)| rank).collect();
        let behind = |(rank, body): (u32, &Body)| {
            if body.is_open {
                return (rank + 1..self.list.len() as u32).take(Bodies::MOST_OTHERS).collect();
            }
            let mut found: Members = open.iter().copied().filter(|&other| other > rank).collect();
            let _ = self.places.visit(
                |bounds| bounds.meets(&body.bounds),
                |place| {
                    pairs += 1;
                    if place.rank > rank && place.bounds.meets(&body.bounds) && !self.list[place.rank as usize].is_open {
                        found.push(place.rank);
                    }
                    if pairs < MOST_PAIRS { Continue(()) } else { Break(()) }
                },
            );
            found.sort_unstable();
            found.truncate(Bodies::MOST_OTHERS);
            found
        };
        (0..).zip(&self.list).map(behind).collect()
    }

    #[inline]
    pub(super) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The body of rank `body`.
    #[inline]
    pub(super) fn interior(&self, body: u32) -> &Interior {
        &self.list[body as usize].interior
    }

    /// Whether some absorb.
    pub(super) fn absorb(&self) -> bool {
        self.list.iter().any(|b| !b.interior.absorption.is_black())
    }

    /// Whether two may share a place.
    pub(super) fn overlap(&self) -> bool {
        !self.behind.is_empty()
    }

    /// Those whose boxes hold `p`.
    fn around(&self, p: Vec3) -> Members {
        let mut near = Members::new();
        let _ = self.places.visit(
            |bounds| bounds.contains(p),
            |place| {
                if place.bounds.contains(p) {
                    near.push(place.rank);
                }
                Continue(())
            },
        );
        near
    }

    /// On the inner side of the boundary of `body`.
    #[inline]
    fn with(&self, set: Bodies, body: u32) -> Bodies {
        if self.behind.is_empty() || set.is_empty() { Bodies::new(body, 0) } else { self.joined(set, body) }
    }

    /// On the outer side of the boundary of `body`. Leaving a body that is not there (an open mesh) changes nothing.
    #[inline]
    fn without(&self, set: Bodies, body: u32) -> Bodies {
        match (set == Bodies::new(body, 0), set.others()) {
            (true, _) => Bodies::NONE,
            (false, 0) => set,
            (false, _) => self.removed(set, body),
        }
    }

    #[inline(never)]
    fn removed(&self, set: Bodies, body: u32) -> Bodies {
        self.set(self.members(set).into_iter().filter(|&member| member != body))
    }

    /// Of those in `set`, the first that is not `body`.
    #[inline]
    fn first_without(&self, set: Bodies, body: u32) -> Option<u32> {
        match set.first() {
            Some(first) if first == body => {
                (set.others() != 0).then(|| self.behind[body as usize][set.others().trailing_zeros() as usize])
            }
            first => first,
        }
    }

    #[inline(never)]
    fn joined(&self, set: Bodies, body: u32) -> Bodies {
        let mut members = self.members(set);
        members.retain(|&mut member| member != body && self.may_share(member, body));
        members.push(body);
        members.sort_unstable();
        self.set(members)
    }

    /// Whether two may be in one place; a list that is full does not tell.
    fn may_share(&self, a: u32, b: u32) -> bool {
        let behind = &self.behind[a.min(b) as usize];
        behind.len() == Bodies::MOST_OTHERS || behind.contains(&a.max(b))
    }

    /// By rank.
    fn members(&self, set: Bodies) -> Members {
        let Some(first) = set.first() else { return Members::new() };
        let behind = self.behind.get(first as usize).into_iter().flatten().enumerate();
        std::iter::once(first).chain(behind.filter(|(bit, _)| set.others() >> bit & 1 != 0).map(|(_, &rank)| rank)).collect()
    }

    /// The set of `members`, by rank.
    fn set(&self, members: impl IntoIterator<Item = u32>) -> Bodies {
        let mut members = members.into_iter();
        let Some(first) = members.next() else { return Bodies::NONE };
        let behind = &self.behind[first as usize];
        let bits = members.filter_map(|member| behind.iter().position(|&other| other == member));
        Bodies::new(first, bits.fold(0, |others, bit| others | 1 << bit))
    }
}

impl Scene {
    /// The bodies that contain the point `p`: those whose surface is left more often than entered on the way out.
    #[inline]
    pub fn bodies_at(&self, p: Vec3) -> Bodies {
        if self.bodies.places.bounds().contains(p) { self.bodies_around(p) } else { Bodies::NONE }
    }

    #[inline(never)]
    fn bodies_around(&self, p: Vec3) -> Bodies {
        let mut near: SmallVec<[(u32, i32); 8]> = self.bodies.around(p).into_iter().map(|body| (body, 0)).collect();
        if near.is_empty() {
            return Bodies::NONE;
        }
        let mut ray = Ray::new(p, OUT);
        for _ in 0..MOST_CROSSED {
            let Some(point) = self.intersect(&ray) else { break };
            let body = self.objects[point.hit.object as usize].body;
            if let Some((_, left)) = near.iter_mut().find(|(b, _)| *b == body) {
                *left += if OUT.dot(point.ng) > 0.0 { 1 } else { -1 };
            }
            ray = point.spawn(OUT);
        }
        near.into_iter().filter(|&(_, left)| left > 0).fold(Bodies::NONE, |inside, (body, _)| self.bodies.with(inside, body))
    }

    /// The bodies in which light starts that leaves its `end` along `ray`; what comes from infinity starts outside all.
    pub fn bodies_of_light(&self, end: &End, ray: &Ray) -> Bodies {
        match *end {
            End::Infinity => Bodies::NONE,
            End::Point(p) => self.bodies_at(p),
            End::Surface { .. } => self.bodies_at(ray.origin),
        }
    }

    /// The bodies on the side of `point` to which `w` leads, for what comes there in `bodies`, from whichever side.
    #[inline]
    pub fn bodies_toward(&self, point: &SurfacePoint, bodies: Bodies, w: Vec3) -> Bodies {
        if self.bodies.is_empty() {
            return bodies;
        }
        match self.objects[point.hit.object as usize].body {
            Bodies::NOBODY => bodies,
            body if w.dot(point.ng) < 0.0 => self.bodies.with(bodies, body),
            _ if planted(Defect::LeavingIsVacuum) => Bodies::NONE,
            body => self.bodies.without(bodies, body),
        }
    }

    /// What is left of light after `length` scene units in `bodies` (Beer and Lambert).
    #[inline]
    pub fn absorption(&self, bodies: Bodies, length: f32) -> Spectrum {
        let Some(body) = bodies.first() else { return Spectrum::ONE };
        // 0 · ∞ at a lane that does not absorb is no absorption.
        self.bodies.interior(body).absorption.map(|s: f32| if s > 0.0 { (-s * length).exp() } else { 1.0 })
    }

    /// The index outside the boundary of `object`, met in `bodies`: 1 for what is no body.
    #[inline]
    pub(super) fn outer_index(&self, object: &ObjectInfo, bodies: Bodies) -> f32 {
        if !self.features.nested || object.body == Bodies::NOBODY || planted(Defect::OuterIndexIsOne) {
            return 1.0;
        }
        self.bodies.first_without(bodies, object.body).map_or(1.0, |outside| self.bodies.interior(outside).ior)
    }

    /// Whether the boundary of `object`, met in `bodies`, is not there, since another body has the place.
    #[inline]
    pub(super) fn is_null(&self, object: &ObjectInfo, bodies: Bodies) -> bool {
        self.features.nested && object.body != Bodies::NOBODY && bodies.first().is_some_and(|first| first < object.body)
    }
}

#[cfg(test)]
#[path = "bodies_tests.rs"]
mod tests;
