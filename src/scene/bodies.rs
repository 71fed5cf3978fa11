//! Bodies: solids that light passes through, what is inside them, and which of those that share a place has its medium there.
//!
//! A body is an instance, or that part of it whose inside is the same, with a material that transmits light and has a volume. Parts that
//! are open belong together if their insides are the same: the faces of one body may be nodes of their own. Where
//! bodies overlap one has the place: the one of the highest `priority` (`extras.etendue.priority` of its material), then the one with the
//! smaller bounding box, since what lies inside another is smaller, then the later one in the file. The boundary of one that does not
//! have the place is not there. Indices of bodies are their ranks in that order.
//!
//! Limits: bodies are taken to be closed and to have their fronts outward; an open one bends light where it is crossed, and its inside
//! has no other end than a surface with the same. Surfaces that alpha masks cut away do not count as crossed.

use super::material::Material;
use super::{ObjectInfo, Scene};
use crate::defects::{Defect, planted};
use crate::geometry::{Bodies, Bounds, Geometry, Ray, SurfacePoint, TriangleMesh};
use crate::light::End;
use crate::sampling::mix64;
use crate::spectrum::Spectrum;
use glam::Vec3;
use std::cmp::Ordering;
use std::collections::HashMap;

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
}

impl Body {
    /// By precedence; of equal ones the later.
    fn precedes(&self, other: &Body) -> Ordering {
        let priority = other.interior.priority.cmp(&self.interior.priority);
        let priority = if planted(Defect::PriorityReversed) { priority.reverse() } else { priority };
        priority.then(self.bounds.volume().total_cmp(&other.bounds.volume()))
    }
}

/// All bodies, by rank, and the box around them.
#[derive(Debug, Default)]
pub(super) struct AllBodies {
    list: Vec<Body>,
    bounds: Option<Bounds>,
}

/// Beyond so many bodies whether two overlap is not looked at, but taken for granted.
const MANY: usize = 4096;

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
                found.push(Body { interior, bounds });
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
        let list: Vec<Body> = order.into_iter().map(|id| found[id]).collect();
        let bounds = list.iter().map(|b| b.bounds).reduce(Bounds::union);
        AllBodies { list, bounds }
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
        let pairs = || (1..self.list.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        self.list.len() > MANY || pairs().any(|(i, j)| self.list[i].bounds.meets(&self.list[j].bounds))
    }

    /// Those whose boxes hold `p`.
    fn around(&self, p: Vec3) -> Vec<u32> {
        if !self.bounds.is_some_and(|all| all.contains(p)) {
            return Vec::new();
        }
        let near = self.list.iter().enumerate().filter(|(_, body)| body.bounds.contains(p));
        near.map(|(rank, _)| rank as u32).collect()
    }
}

impl Scene {
    /// The bodies that contain the point `p`: those whose surface is left more often than entered on the way out.
    pub fn bodies_at(&self, p: Vec3) -> Bodies {
        let mut near: Vec<(u32, i32)> = self.bodies.around(p).into_iter().map(|body| (body, 0)).collect();
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
        near.into_iter().filter(|&(_, left)| left > 0).fold(Bodies::NONE, |inside, (body, _)| inside.with(body))
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
            body if w.dot(point.ng) < 0.0 => bodies.with(body),
            _ if planted(Defect::LeavingIsVacuum) => Bodies::NONE,
            body => bodies.without(body),
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
        bodies.without(object.body).first().map_or(1.0, |outside| self.bodies.interior(outside).ior)
    }

    /// Whether the boundary of `object`, met in `bodies`, is not there, since another body has the place.
    #[inline]
    pub(super) fn is_null(&self, object: &ObjectInfo, bodies: Bodies) -> bool {
        self.features.nested
            && object.body != Bodies::NOBODY
            && bodies.without(object.body).first().is_some_and(|outside| outside < object.body)
    }
}
