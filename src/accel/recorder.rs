//! Notes what rays a render asks about, so that the same can be asked again of any backend with nothing in between.
//!
//! Use it on one thread: rays are kept in the order they come in. A ray takes 48 bytes.

use super::Intersector;
use crate::geometry::{AnyHit, Bounds, Hit, Opaque, Ray};
use std::sync::{Mutex, PoisonError};

/// A query as it was made.
#[derive(Debug, Clone, Copy)]
pub enum Question {
    /// What is first?
    Closest(Ray),
    /// Is there anything?
    Occluded(Ray),
}

impl Question {
    /// Asks `accel` without filters: whether anything was hit.
    #[inline]
    pub fn ask(&self, accel: &impl Intersector) -> bool {
        match self {
            Question::Closest(ray) => accel.closest(ray, &Opaque).is_some(),
            Question::Occluded(ray) => accel.occluded(ray, &Opaque),
        }
    }
}

/// A backend whose questions are noted.
pub struct Recorder<A> {
    inner: A,
    questions: Mutex<Vec<Question>>,
}

impl<A: Intersector> Recorder<A> {
    /// Notes what `inner` is asked from now on.
    pub(super) fn new(inner: A) -> Self {
        Recorder { inner, questions: Mutex::default() }
    }

    /// The backend, and what it was asked.
    pub(super) fn finish(self) -> (A, Vec<Question>) {
        (self.inner, self.questions.into_inner().unwrap_or_else(PoisonError::into_inner))
    }

    /// What answers.
    pub(super) fn inner(&self) -> &A {
        &self.inner
    }

    fn note(&self, question: Question) {
        self.questions.lock().unwrap_or_else(PoisonError::into_inner).push(question);
    }
}

impl<A: Intersector> Intersector for Recorder<A> {
    fn closest(&self, ray: &Ray, any: &impl AnyHit) -> Option<Hit> {
        self.note(Question::Closest(*ray));
        self.inner.closest(ray, any)
    }

    fn occluded(&self, ray: &Ray, any: &impl AnyHit) -> bool {
        self.note(Question::Occluded(*ray));
        self.inner.occluded(ray, any)
    }

    fn bounds(&self) -> Bounds {
        self.inner.bounds()
    }
}
