//! Recording of the ray queries of a render, so that they can be replayed on any backend without the rest of the
//! renderer.
//!
//! For a single thread: queries are stored in order, each with the class announced last.

use super::{Intersector, RayClass};
use crate::geometry::{AnyHit, Bounds, Hit, Opaque, Ray};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Type of a ray query.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Query {
    /// First hit.
    Closest,
    /// Any hit.
    Occluded,
}

/// A recorded query, 52 bytes.
#[derive(Debug, Clone, Copy)]
pub struct RayQuery {
    /// The ray.
    pub ray: Ray,
    /// Type of the query.
    pub query: Query,
    /// Purpose of the ray.
    pub class: RayClass,
}

impl RayQuery {
    /// Runs the query on `accel` without filters; returns whether anything was hit.
    #[inline]
    pub fn ask(&self, accel: &impl Intersector) -> bool {
        match self.query {
            Query::Closest => accel.closest(&self.ray, &Opaque).is_some(),
            Query::Occluded => accel.occluded(&self.ray, &Opaque),
        }
    }
}

/// A backend with recorded queries.
pub struct Recorder<A> {
    inner: A,
    notes: Mutex<Notes>,
}

struct Notes {
    class: RayClass,
    questions: Vec<RayQuery>,
}

impl<A: Intersector> Recorder<A> {
    /// Records the queries of `inner` from now on.
    pub(super) fn new(inner: A) -> Self {
        Recorder { inner, notes: Mutex::new(Notes { class: RayClass::Camera, questions: Vec::new() }) }
    }

    /// Returns the backend and its queries.
    pub(super) fn finish(self) -> (A, Vec<RayQuery>) {
        (self.inner, self.notes.into_inner().unwrap_or_else(PoisonError::into_inner).questions)
    }

    /// Returns the wrapped backend.
    pub(super) fn inner(&self) -> &A {
        &self.inner
    }

    /// Sets the class of the next rays.
    #[cold]
    pub(super) fn announce(&self, class: RayClass) {
        self.notes().class = class;
    }

    fn note(&self, ray: &Ray, query: Query) {
        let mut notes = self.notes();
        let class = notes.class;
        notes.questions.push(RayQuery { ray: *ray, query, class });
    }

    fn notes(&self) -> MutexGuard<'_, Notes> {
        self.notes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<A: Intersector> Intersector for Recorder<A> {
    fn closest(&self, ray: &Ray, any: &impl AnyHit) -> Option<Hit> {
        self.note(ray, Query::Closest);
        self.inner.closest(ray, any)
    }

    fn occluded(&self, ray: &Ray, any: &impl AnyHit) -> bool {
        self.note(ray, Query::Occluded);
        self.inner.occluded(ray, any)
    }

    fn bounds(&self) -> Bounds {
        self.inner.bounds()
    }
}
