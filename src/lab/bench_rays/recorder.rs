//! Recording of the ray queries of a render, so that they can be replayed on any backend without the rest of the
//! renderer.
//!
//! For a single thread: queries are stored in order, each with the class announced last.

use crate::accel::{Accel, Backend, CustomIntersector, FilterFn, HitFilter, Intersector, RayClass};
use crate::geometry::{Hit, Opaque, Ray};
use std::sync::Arc;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Type of a ray query.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Query {
    /// First hit.
    Closest,
    /// Any hit.
    Occluded,
}

/// A recorded query, 72 bytes.
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

/// A backend whose queries are recorded.
pub(super) struct Recorder {
    inner: Accel,
    notes: Mutex<Notes>,
}

struct Notes {
    class: RayClass,
    questions: Vec<RayQuery>,
}

impl Recorder {
    /// Returns the backend that records the queries of `inner`, and its recorder.
    pub(super) fn of(inner: Accel) -> (Accel, Arc<Recorder>) {
        let notes = Mutex::new(Notes { class: RayClass::Camera, questions: Vec::new() });
        let recorder = Arc::new(Recorder { inner, notes });
        (Accel::Custom(Box::new(Arc::clone(&recorder))), recorder)
    }

    /// Returns the wrapped backend and the queries of `recording`, which came from [`Recorder::of`].
    ///
    /// # Panics
    /// If `recording` is another backend.
    pub(super) fn end(self: Arc<Recorder>, recording: Accel) -> (Accel, Vec<RayQuery>) {
        drop(recording);
        let recorder = Arc::into_inner(self).expect("the recording backend held the only other handle");
        (recorder.inner, recorder.notes.into_inner().unwrap_or_else(PoisonError::into_inner).questions)
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

impl CustomIntersector for Arc<Recorder> {
    fn closest(&self, ray: &Ray, filter: Option<&HitFilter<'_>>) -> Option<Hit> {
        self.note(ray, Query::Closest);
        match filter {
            Some(filter) => self.inner.closest(ray, &FilterFn(filter)),
            None => self.inner.closest(ray, &Opaque),
        }
    }

    fn occluded(&self, ray: &Ray, filter: Option<&HitFilter<'_>>) -> bool {
        self.note(ray, Query::Occluded);
        match filter {
            Some(filter) => self.inner.occluded(ray, &FilterFn(filter)),
            None => self.inner.occluded(ray, &Opaque),
        }
    }

    fn backend(&self) -> Backend {
        self.inner.backend()
    }

    fn bytes(&self) -> usize {
        self.inner.bytes()
    }

    fn announce(&self, class: RayClass) {
        self.notes().class = class;
    }
}
