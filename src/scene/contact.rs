//! Touching surfaces: pairs of triangles closer than a ray offset or a backend's distance error, of which one transmits
//! light. A ray offset from such a surface would jump over the touching surface. These triangles are therefore
//! intersected by an exact test ([`Line`]). A scene without such pairs has no overhead. Pairs of opaque surfaces need
//! no test, since no ray continues between them.

mod close;
mod find;

use crate::geometry::{BoxTree, Crossing, Geometry, Hit, Leaf, Line, Ray, Triangle, clear_of};
use glam::Vec3;
use std::ops::ControlFlow::{Break, Continue};

/// Triangles of a scene that touch others.
#[derive(Debug)]
pub(super) struct Contacts {
    /// By object, if any of its triangles touches another: one bit per triangle.
    flags: Vec<Option<Box<[u64]>>>,
    tree: BoxTree<Leaf>,
    /// Error bound of a backend's heights over a plane, in scene units.
    doubt: f32,
    /// Maximum of [`Contacts::reach`].
    most_reach: f32,
}

impl Contacts {
    /// Returns whether the triangle touches another.
    #[inline]
    pub(super) fn flags(&self, hit: Hit) -> bool {
        let bits = self.flags[hit.object as usize].as_deref();
        bits.is_some_and(|bits| bits[hit.primitive as usize / 64] >> (hit.primitive % 64) & 1 != 0)
    }

    /// Returns whether any triangle of `object` touches another.
    pub(super) fn has(&self, object: u32) -> bool {
        self.flags[object as usize].is_some()
    }

    /// Returns the error bound of a backend's heights over a plane.
    pub(super) fn doubt(&self) -> f64 {
        f64::from(self.doubt)
    }

    /// Returns whether `hit` touches another triangle at its point `p`.
    pub(super) fn touches(&self, hit: Hit, p: Vec3, geometry: &Geometry) -> bool {
        if !self.flags(hit) {
            return false;
        }
        let own = geometry.triangle(hit);
        let reach = |other: &Triangle| self.reach(&own) + self.reach(other);
        let most = self.reach(&own) + self.most_reach;
        let inside = |min: Vec3, max: Vec3| (p.cmpge(min - most) & p.cmple(max + most)).all();
        let walked = self.tree.visit(
            |bounds| inside(bounds.min, bounds.max),
            |leaf| {
                let near = leaf.hit != hit && close::to_point(&leaf.triangle, p, reach(&leaf.triangle));
                let apart = || {
                    leaf.hit.object != hit.object
                        || !leaf.triangle.shares_vertex(&own)
                        || close::over(&leaf.triangle, p)
                };
                if near && apart() { Break(()) } else { Continue(()) }
            },
        );
        walked.is_break()
    }

    /// Returns the first intersection of `line` with a touching triangle accepted by `counts`.
    pub(super) fn first(&self, geometry: &Geometry, line: &Line, counts: impl Fn(Hit) -> bool) -> Option<Crossing> {
        let first = std::cell::Cell::new(None::<Crossing>);
        let _ = self.tree.visit(
            |bounds| line.enters(bounds, first.get().map_or(f64::INFINITY, |first| first.t)),
            |leaf| {
                let crossing = line.cross(geometry, leaf.hit, &leaf.triangle);
                let nearer =
                    |crossing: &Crossing| first.get().is_none_or(|first| crossing.precedes(&first)) && counts(leaf.hit);
                if let Some(crossing) = crossing.filter(nearer) {
                    first.set(Some(crossing));
                }
                Continue(())
            },
        );
        first.get()
    }

    /// Returns `ray` with offsets at its touching ends, as a backend needs it.
    pub(super) fn cleared(&self, geometry: &Geometry, ray: &Ray) -> Ray {
        let triangle = |hit: Hit| (hit != Hit::NONE).then(|| geometry.triangle(hit));
        clear_of(ray, triangle(ray.left).as_ref(), triangle(ray.end).as_ref())
    }
}
