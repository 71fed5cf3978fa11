//! Ray queries where surfaces touch. [`Contacts`] intersects touching triangles exactly; the backend intersects all
//! others.

use super::Scene;
use super::contact::Contacts;
use super::query::Mask;
use crate::accel::Intersector;
use crate::geometry::{AnyHit, Crossing, Hit, Line, Opaque, Ray, SurfacePoint};

/// Filter of backend queries: it excludes what [`Contacts`] answers.
struct Apart<'a>(&'a Scene, &'a Contacts);

impl AnyHit for Apart<'_> {
    fn accepts(&self, ray: &Ray, hit: Hit) -> bool {
        !self.1.flags(hit) && self.0.counts(ray, hit)
    }
}

impl Scene {
    /// Returns whether a candidate is a hit, considering alpha masks.
    fn counts(&self, ray: &Ray, hit: Hit) -> bool {
        !self.features.masks || Mask(self).accepts(ray, hit)
    }

    /// [`Scene::intersect`] for scenes with touching surfaces.
    #[inline(never)] // other scenes need not carry it
    pub(super) fn intersect_touching(&self, contacts: &Contacts, ray: &Ray) -> Option<SurfacePoint> {
        if ray.touches() {
            return self.next_beyond(contacts, ray);
        }
        let hit =
            if self.features.masks { self.accel.closest(ray, &Mask(self)) } else { self.accel.closest(ray, &Opaque) }?;
        if !contacts.flags(hit) {
            return self.point(contacts, hit, ray);
        }
        let line = Line::new(&self.geometry, ray);
        let reported = line.meet(&self.geometry, hit, &self.geometry.triangle(hit));
        let first = contacts.first(&self.geometry, &line, |hit| self.counts(ray, hit));
        // The backend's hit is used where no exact hit is near it: at an edge, which the exact line may miss.
        let doubt = |crossing: &Crossing| crossing.t + contacts.doubt() / crossing.slope;
        match (first, reported) {
            (Some(first), Some(reported)) if first.t <= doubt(&reported) => self.judged(contacts, first.hit, ray),
            _ => self.point(contacts, hit, ray),
        }
    }

    /// Returns the first hit of a ray that starts or ends on a touching surface.
    #[cold]
    fn next_beyond(&self, contacts: &Contacts, ray: &Ray) -> Option<SurfacePoint> {
        let line = Line::new(&self.geometry, ray);
        let first = contacts.first(&self.geometry, &line, |hit| self.counts(ray, hit));
        let other = self.accel.closest(&contacts.cleared(&self.geometry, ray), &Apart(self, contacts));
        let Some(other) = other else { return self.judged(contacts, first?.hit, ray) };
        let reported = line.meet(&self.geometry, other, &self.geometry.triangle(other));
        match (first, reported) {
            (Some(first), Some(reported)) if first.precedes(&reported) => self.judged(contacts, first.hit, ray),
            _ => self.point(contacts, other, ray),
        }
    }

    /// Returns whether a segment that starts or ends on a touching surface is occluded.
    #[cold]
    pub(super) fn is_occluded_touching(&self, contacts: &Contacts, ray: &Ray) -> bool {
        let line = Line::new(&self.geometry, ray);
        contacts.first(&self.geometry, &line, |hit| self.counts(ray, hit)).is_some()
            || self.accel.occluded(&contacts.cleared(&self.geometry, ray), &Apart(self, contacts))
    }

    /// Returns the point on `hit`, as reported by the backend.
    fn point(&self, contacts: &Contacts, hit: Hit, ray: &Ray) -> Option<SurfacePoint> {
        let mut point = SurfacePoint::new(&self.geometry, hit, ray)?;
        point.touching = contacts.touches(hit, point.p, &self.geometry);
        // Between touching surfaces the distance is less than the rounding of the origin.
        point.t = point.t.max(ray.t_min);
        Some(point)
    }

    /// Returns the point on `hit`, as found by the exact test.
    fn judged(&self, contacts: &Contacts, hit: Hit, ray: &Ray) -> Option<SurfacePoint> {
        Some(SurfacePoint { consistent: true, ..self.point(contacts, hit, ray)? })
    }
}
