//! Bodies: solids that transmit light, their interior media, and the precedence of overlapping bodies.
//!
//! A body is an instance, or a part of it with one interior, whose material transmits light and has a volume. Open
//! parts with equal interiors form one body, since the faces of one body may be separate nodes. Where bodies overlap,
//! the one of highest precedence determines the medium. Precedence is by highest `priority` (`extras.etendue.priority`
//! of the material), then by smaller bounding box, since a body inside another is smaller, then by later position in
//! the file. The boundary of a body without precedence has no effect there. Body indices are ranks in this order.
//!
//! An open body, such as a water surface, has no inside that a box could bound. It ranks like a cube of its longest
//! side, and may overlap every other body. Entering a body that cannot overlap another one implies that the other was
//! left, whatever surfaces were crossed.
//!
//! Limits: bodies are assumed to have outward fronts. An open body refracts where it is crossed, and its interior ends
//! only at a surface with the same interior. Surfaces cut away by alpha masks do not count as crossed. A set
//! distinguishes at most [`Bodies::MOST_OTHERS`] overlapping bodies of lower precedence.

use super::interior::Interior;
use super::material::Material;
use super::{ObjectInfo, Scene};
use crate::geometry::{Bodies, Bounded, Bounds, BoxTree, Geometry, Ray, RayState, SurfacePoint, TriangleMesh};
use crate::light::Light;
use crate::medium::{Colors, Grid, Homogeneous, Medium};
use crate::sampling::mix64;
use crate::spectrum::Spectrum;
use glam::Vec3;
use smallvec::SmallVec;
use std::cmp::Ordering;
use std::collections::HashMap;
use std::ops::ControlFlow::{Break, Continue};
use std::sync::Arc;

/// A solid that transmits light.
#[derive(Debug, Clone, Copy)]
pub(super) struct Body {
    pub(super) interior: Interior,
    /// The instance that it belongs to, which its density moves with.
    instance: u32,
    bounds: Bounds,
    is_open: bool,
}

impl Body {
    /// Compares precedence. The caller's stable sort breaks ties: the later body in the file comes first.
    fn precedes(&self, other: &Body) -> Ordering {
        let priority = other.interior.priority.cmp(&self.interior.priority);
        priority.then(self.size().total_cmp(&other.size()))
    }

    fn size(&self) -> f32 {
        if self.is_open { (self.bounds.max - self.bounds.min).max_element().powi(3) } else { self.bounds.volume() }
    }
}

/// Bounding box of a body.
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

/// Bodies at a point, by rank.
type Members = SmallVec<[u32; 8]>;

/// All bodies, by rank.
#[derive(Debug, Default)]
pub(super) struct AllBodies {
    list: Vec<Body>,
    /// The media of the bodies.
    media: Vec<Medium>,
    /// For each body, those of lower precedence that it may overlap, by rank; empty if no two may overlap.
    behind: Vec<Members>,
    places: BoxTree<Place>,
}

/// Largest number of body pairs tested for overlap; further overlaps are ignored.
const MOST_PAIRS: usize = 1 << 24;

/// Largest number of surfaces crossed on the way out of a point.
const MOST_CROSSED: u32 = 1 << 14;

/// Direction of the ray out of a point. It is mostly upward, so that points below an open water surface are inside it.
/// It is unlikely to be parallel to a plane or edge of a model.
const OUT: Vec3 = Vec3::new(0.230_84, 0.936_27, 0.265_31);

/// Hash sum over the edges of a mesh without a second triangle: 0 if the mesh is closed, and for an open mesh with
/// probability 2⁻⁶⁴.
fn open_edges(mesh: &TriangleMesh) -> u64 {
    // −0 and 0 are equal.
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
    /// Finds the bodies of all objects and stores each object's index.
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
            let (Some(interior), Some(part)) = (materials[object.material as usize].interior, part(object)) else {
                continue;
            };
            let bounds = geometry.bounds(index);
            let is_closed = parts[&part] == 0;
            let id = *known.entry((is_closed.then_some(part.0), part.1)).or_insert_with(|| {
                found.push(Body { interior, instance: object.instance, bounds, is_open: !is_closed });
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

    /// Returns the bodies in `list`, which is sorted by rank.
    fn ranked(list: Vec<Body>) -> Self {
        let places = list.iter().zip(0..).map(|(body, rank)| Place { rank, bounds: body.bounds }).collect();
        let media = list.iter().map(|body| body.interior.medium.into()).collect();
        let mut bodies = AllBodies { list, media, behind: Vec::new(), places: BoxTree::new(places) };
        let behind = bodies.overlaps();
        if behind.iter().any(|list| !list.is_empty()) {
            bodies.behind = behind;
        }
        bodies
    }

    /// Gives the media that vary their densities, albedos and emission: those of an index, in the place of an instance.
    pub(super) fn place_grids(
        &mut self,
        density: impl Fn(usize, u32) -> Grid,
        [albedo, emission]: [impl Fn(usize, u32) -> Colors; 2],
    ) {
        for (body, medium) in self.list.iter().zip(&mut self.media) {
            medium.grid = body.interior.density.map(|index| density(index, body.instance));
            medium.albedo = body.interior.albedo.map(|index| albedo(index, body.instance));
            medium.emission = body.interior.emission_grid.map(|index| emission(index, body.instance));
        }
    }

    /// Returns the memory held by densities, in bytes.
    pub(super) fn density_bytes(&self) -> usize {
        let mut blocks: Vec<_> = self.media.iter().filter_map(|medium| Some(medium.grid.as_ref()?.blocks())).collect();
        blocks.sort_by_key(|blocks| Arc::as_ptr(blocks));
        blocks.dedup_by_key(|blocks| Arc::as_ptr(blocks));
        blocks.into_iter().map(|blocks| blocks.bytes()).sum()
    }

    /// Computes [`AllBodies::behind`].
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
                    if place.rank > rank && place.bounds.meets(&body.bounds) && !self.list[place.rank as usize].is_open
                    {
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

    /// Returns the interior of the body of rank `body`.
    #[inline]
    pub(super) fn interior(&self, body: u32) -> &Interior {
        &self.list[body as usize].interior
    }

    /// Returns whether any body weakens light.
    pub(super) fn attenuate(&self) -> bool {
        self.list.iter().any(|b| !b.interior.medium.is_clear())
    }

    /// Returns whether any body scatters light.
    pub(super) fn scatter(&self) -> bool {
        self.list.iter().any(|b| b.interior.medium.scatters())
    }

    /// Returns whether the medium of any body emits light.
    pub(super) fn emit(&self) -> bool {
        self.list.iter().any(|b| b.interior.medium.emits())
    }

    /// Returns whether any two bodies may overlap.
    pub(super) fn overlap(&self) -> bool {
        !self.behind.is_empty()
    }

    /// Returns the bodies whose boxes contain `p`.
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

    /// Returns the set on the inner side of the boundary of `body`.
    #[inline]
    fn with(&self, set: Bodies, body: u32) -> Bodies {
        if self.behind.is_empty() || set.is_empty() { Bodies::new(body, 0) } else { self.joined(set, body) }
    }

    /// Returns the set on the outer side of the boundary of `body`. Leaving a body that is not in the set (an open
    /// mesh) has no effect.
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

    /// Returns the first body in `set` other than `body`.
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

    /// Returns whether two bodies may overlap; unreliable for a full list.
    fn may_share(&self, a: u32, b: u32) -> bool {
        let behind = &self.behind[a.min(b) as usize];
        behind.len() == Bodies::MOST_OTHERS || behind.contains(&a.max(b))
    }

    /// Returns the bodies of a set, by rank.
    fn members(&self, set: Bodies) -> Members {
        let Some(first) = set.first() else { return Members::new() };
        let behind = self.behind.get(first as usize).into_iter().flatten().enumerate();
        std::iter::once(first)
            .chain(behind.filter(|(bit, _)| set.others() >> bit & 1 != 0).map(|(_, &rank)| rank))
            .collect()
    }

    /// Returns the set of `members`, which are sorted by rank.
    fn set(&self, members: impl IntoIterator<Item = u32>) -> Bodies {
        let mut members = members.into_iter();
        let Some(first) = members.next() else { return Bodies::NONE };
        let behind = &self.behind[first as usize];
        let bits = members.filter_map(|member| behind.iter().position(|&other| other == member));
        Bodies::new(first, bits.fold(0, |others, bit| others | 1 << bit))
    }
}

/// A closed body full of one medium that scatters and does not emit, with another refractive index than its
/// surroundings.
#[derive(Debug, Clone, Copy)]
pub struct Solid {
    /// Its rank.
    pub body: u32,
    /// Its medium.
    pub medium: Homogeneous,
    /// Refractive index, above 1.
    pub ior: f32,
    /// Shortest edge of its bounding box.
    pub thickness: f32,
}

impl Scene {
    /// Returns all solids that scatter.
    pub fn solids(&self) -> impl Iterator<Item = Solid> {
        (0..).zip(&self.bodies.list).filter_map(|(rank, body)| {
            let &Interior { medium, density, albedo, ior, .. } = &body.interior;
            let is_even = density.is_none() && albedo.is_none();
            (is_even && !body.is_open && ior > 1.0 && medium.scatters() && !medium.emits()).then(|| {
                let thickness = (body.bounds.max - body.bounds.min).min_element();
                Solid { body: rank, medium, ior, thickness }
            })
        })
    }

    /// Returns the body that a path in `bodies` enters at `point` along `w`, from surroundings of index 1.
    #[inline]
    pub fn entered(&self, point: &SurfacePoint, bodies: Bodies, w: Vec3) -> Option<u32> {
        let object = &self.objects[point.hit.object as usize];
        let is_entered = object.body != Bodies::NOBODY && w.dot(point.ng) < 0.0 && bodies.first() != Some(object.body);
        (is_entered && self.outer_index(object, bodies) <= 1.0).then_some(object.body)
    }

    /// Returns whether two points are on the boundary of one body.
    #[inline]
    pub fn is_same_body(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool {
        let body = |point: &SurfacePoint| self.objects[point.hit.object as usize].body;
        body(a) == body(b)
    }

    /// Returns the bodies that contain the point `p`: those whose boundary is left more often than entered on the way
    /// out.
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
        near.into_iter()
            .filter(|&(_, left)| left > 0)
            .fold(Bodies::NONE, |inside, (body, _)| self.bodies.with(inside, body))
    }

    /// Returns the bodies that contain every point of the box `at`; `None` if they may differ from point to point.
    pub(super) fn bodies_within(&self, at: &Bounds) -> Option<Bodies> {
        if at.min == at.max {
            return Some(self.bodies_at(at.min));
        }
        let meets = self
            .bodies
            .places
            .visit(|bounds| bounds.meets(at), |place| if place.bounds.meets(at) { Break(()) } else { Continue(()) });
        meets.is_continue().then_some(Bodies::NONE)
    }

    /// Computes [`Scene::light_media`].
    pub(super) fn media_of_lights(&self) -> Vec<Option<Bodies>> {
        if self.bodies.is_empty() {
            return Vec::new();
        }
        let medium = |light: &Light| match light.bounds() {
            Some(bounds) => self.bodies_within(&bounds),
            // Light from infinity begins outside all bodies.
            None => Some(Bodies::NONE),
        };
        self.lights.all().iter().map(medium).collect()
    }

    /// Returns the bodies at the origin of the ray `ray` from light `index`.
    #[inline]
    pub fn bodies_of_light(&self, index: usize, ray: &Ray) -> Bodies {
        let Some(medium) = self.light_media.get(index) else { return Bodies::NONE };
        medium.unwrap_or_else(|| self.bodies_at(ray.origin))
    }

    /// Returns the bodies on the side of `point` toward `w`, for a path that arrives from `bodies` on either side.
    #[inline]
    pub fn bodies_toward(&self, point: &SurfacePoint, bodies: Bodies, w: Vec3) -> Bodies {
        if self.bodies.is_empty() {
            return bodies;
        }
        match self.objects[point.hit.object as usize].body {
            Bodies::NOBODY => bodies,
            body if w.dot(point.ng) < 0.0 => self.bodies.with(bodies, body),
            body => self.bodies.without(bodies, body),
        }
    }

    /// Returns the state on the side of `point` toward `w`, for a path that arrives in `state` on either side.
    #[inline]
    pub fn state_toward(&self, point: &SurfacePoint, state: RayState, w: Vec3) -> RayState {
        state.within(self.bodies_toward(point, state.bodies, w))
    }

    /// Returns the medium in `bodies`; `None` in empty space.
    #[inline]
    pub fn medium(&self, bodies: Bodies) -> Option<&Medium> {
        bodies.first().map(|body| &self.bodies.media[body as usize])
    }

    /// Returns the transmittance of `length` scene units along `ray`, whose direction is a unit vector, in the medium
    /// of `bodies`.
    #[inline]
    pub fn absorption(&self, bodies: Bodies, ray: &Ray, length: f32) -> Spectrum {
        let through = |medium: &Medium| medium.transmittance(ray.origin, ray.direction, length);
        self.medium(bodies).map_or(Spectrum::ONE, through)
    }

    /// Returns the refractive index outside the boundary of `object`, reached in `bodies`; 1 for objects that bound no
    /// body.
    #[inline]
    pub(super) fn outer_index(&self, object: &ObjectInfo, bodies: Bodies) -> f32 {
        if !self.features.nested || object.body == Bodies::NOBODY {
            return 1.0;
        }
        self.bodies.first_without(bodies, object.body).map_or(1.0, |outside| self.bodies.interior(outside).ior)
    }

    /// Returns whether the boundary of `object`, reached in `bodies`, has no effect because another body has
    /// precedence.
    #[inline]
    pub(super) fn is_null(&self, object: &ObjectInfo, bodies: Bodies) -> bool {
        self.features.nested && object.body != Bodies::NOBODY && bodies.first().is_some_and(|first| first < object.body)
    }
}

#[cfg(test)]
#[path = "bodies_tests.rs"]
mod tests;
