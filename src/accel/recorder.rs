//! Notes what rays a render asks about, so that the same can be asked again of any backend with nothing in between.
//!
//! Use it on one thread: rays are kept in the order they come in, and each is of the class that was announced last.

use super::{Intersector, RayClass};
use crate::geometry::{AnyHit, Bounds, Hit, Opaque, Ray};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What is asked about a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Query {
    /// What is first?
    Closest,
    /// Is there anything?
    Occluded,
}

/// A query as it was made. It takes 52 bytes.
#[derive(Debug, Clone, Copy)]
pub struct Question {
    /// The ray.
    pub ray: Ray,
    /// What was asked about it.
    pub query: Query,
    /// What for.
    pub class: RayClass,
}

impl Question {
    /// Asks `accel` without filters: whether anything was hit.
    #[inline]
    pub fn ask(&self, accel: &impl Intersector) -> bool {
        match self.query {
            Query::Closest => accel.closest(&self.ray, &Opaque).is_some(),
            Query::Occluded => accel.occluded(&self.ray, &Opaque),
        }
    }
}

/// A backend whose questions are noted.
pub struct Recorder<A> {
    inner: A,
    notes: Mutex<Notes>,
}

struct Notes {
    class: RayClass,
    questions: Vec<Question>,
}

impl<A: Intersector> Recorder<A> {
    /// Notes what `inner` is asked from now on.
    pub(super) fn new(inner: A) -> Self {
        Recorder { inner, notes: Mutex::new(Notes { class: RayClass::Camera, questions: Vec::new() }) }
    }

    /// The backend, and what it was asked.
    pub(super) fn finish(self) -> (A, Vec<Question>) {
        (self.inner, self.notes.into_inner().unwrap_or_else(PoisonError::into_inner).questions)
    }

    /// What answers.
    pub(super) fn inner(&self) -> &A {
        &self.inner
    }

    /// Says what the next rays are for.
    #[cold]
    pub(super) fn announce(&self, class: RayClass) {
        self.notes().class = class;
    }

    fn note(&self, ray: &Ray, query: Query) {
        let mut notes = self.notes();
        let class = notes.class;
        notes.questions.push(Question { ray: *ray, query, class });
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
