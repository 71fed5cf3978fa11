//! What rays meet where surfaces touch. Triangles that touch others are judged by [`Contacts`], exactly; all else by the backend.

use super::Scene;
use super::contact::Contacts;
use super::query::Mask;
use crate::accel::Intersector;
use crate::defects::{Defect, planted};
use crate::geometry::{AnyHit, Crossing, Hit, Line, Opaque, Ray, SurfacePoint};

/// What the backend is asked about, where [`Contacts`] answers for the rest.
struct Apart<'a>(&'a Scene, &'a Contacts);

impl AnyHit for Apart<'_> {
    fn accepts(&self, ray: &Ray, hit: Hit) -> bool {
        !self.1.flags(hit) && self.0.counts(ray, hit)
    }
}

impl Scene {
    /// Whether a candidate is there, where masks have holes.
    fn counts(&self, ray: &Ray, hit: Hit) -> bool {
        !self.features.masks || Mask(self).accepts(ray, hit)
    }

    /// [`Scene::intersect`] of a scene in which surfaces touch.
    #[inline(never)] // other scenes need not carry it
    pub(super) fn intersect_touching(&self, contacts: &Contacts, ray: &Ray) -> Option<SurfacePoint> {
        if ray.touches() {
            return self.next_beyond(contacts, ray);
        }
        let hit = if self.features.masks { self.accel.closest(ray, &Mask(self)) } else { self.accel.closest(ray, &Opaque) }?;
        if !contacts.flags(hit) || planted(Defect::ContactUnsorted) {
            return self.point(contacts, hit, ray);
        }
        let line = Line::new(&self.geometry, ray);
        let reported = line.meet(&self.geometry, hit, &self.geometry.triangle(hit));
        let first = contacts.first(&self.geometry, &line, |hit| self.counts(ray, hit));
        // The backend's own word counts where no exact hit is near it: at an edge, which the exact line may miss.
        let doubt = |crossing: &Crossing| crossing.t + contacts.doubt() / crossing.slope;
        match (first, reported) {
            (Some(first), Some(reported)) if first.t <= doubt(&reported) => self.judged(contacts, first.hit, ray),
            _ => self.point(contacts, hit, ray),
        }
    }

    /// What a ray meets that leaves a touching surface, or ends on one.
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

    /// Whether anything lies on a segment that leaves a touching surface, or ends on one.
    #[cold]
    pub(super) fn is_occluded_touching(&self, contacts: &Contacts, ray: &Ray) -> bool {
        let line = Line::new(&self.geometry, ray);
        contacts.first(&self.geometry, &line, |hit| self.counts(ray, hit)).is_some()
            || self.accel.occluded(&contacts.cleared(&self.geometry, ray), &Apart(self, contacts))
    }

    /// The point on `hit`, as the backend says.
    fn point(&self, contacts: &Contacts, hit: Hit, ray: &Ray) -> Option<SurfacePoint> {
        let mut point = SurfacePoint::new(&self.geometry, hit, ray)?;
        point.touching = contacts.touches(hit, point.p, &self.geometry);
        // Between surfaces that touch the distance is less than the rounding of the origin.
        point.t = point.t.max(ray.t_min);
        Some(point)
    }

    /// The point on `hit`, as the exact test says.
    fn judged(&self, contacts: &Contacts, hit: Hit, ray: &Ray) -> Option<SurfacePoint> {
        Some(SurfacePoint { consistent: true, ..self.point(contacts, hit, ray)? })
    }
}
