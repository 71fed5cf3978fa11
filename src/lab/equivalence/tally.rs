//! Comparison of the answers of two backends over many rays.

use super::{Agreement, agreement};
use crate::accel::{Coherence, Intersector};
use crate::geometry::{Geometry, Hit, Hits, Opaque, PADDING, Ray, Rays};
use rayon::prelude::*;

/// Number of rays per task.
const CHUNK: usize = 4096;
/// Largest number of differences and leaks that are stored.
const MOST_KEPT: usize = 8;

/// Counts over a stream of rays.
#[derive(Debug, Clone, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct DifferenceCounts {
    /// Number of rays.
    pub rays: u64,
    /// Rays with a hit, as reported by the backend.
    pub hits: u64,
    /// Answers at distances equal to the other's within rounding.
    pub ties: u64,
    /// Answers that differ at an edge within rounding.
    pub grazes: u64,
    /// Pairs of answers of which one is wrong.
    pub true_differences: u64,
    /// Rays that left a closed surface, by either query; 0 if no surface is closed.
    pub leaks: u64,
    /// Indices in the stream of the first rays with a true difference or a leak.
    pub suspects: Vec<u64>,
}

/// A tally with its labels.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Category {
    /// Name of the ray stream.
    pub name: String,
    /// Backend and build under test, such as `obvhs-robust`.
    pub backend: String,
    /// Reference backend and build.
    pub reference: String,
    /// The counts.
    #[serde(flatten)]
    pub tally: DifferenceCounts,
}

/// Answers of a backend to both queries of a ray.
struct Answer {
    ray: Ray,
    closest: Option<Hit>,
    occluded: bool,
}

impl DifferenceCounts {
    /// Runs both queries of both backends for every ray. With `is_closed`, all rays start inside closed surfaces; a ray
    /// without a hit, or not occluded, is then a leak of `subject`. A ray for which the two queries of `subject`
    /// disagree is a true difference unless it grazes.
    ///
    /// # Panics
    /// If a backend reports a hit that is not in `geometry`.
    pub fn of(
        geometry: &Geometry,
        rays: &[Ray],
        subject: &impl Intersector,
        reference: &impl Intersector,
        is_closed: bool,
    ) -> DifferenceCounts {
        let answers = |rays: &[Ray]| {
            let answer = |&ray: &Ray| {
                let (closest, occluded) = (subject.closest(&ray, &Opaque), subject.occluded(&ray, &Opaque));
                Answer { ray, closest, occluded }
            };
            rays.iter().map(answer).collect()
        };
        DifferenceCounts::count(geometry, rays, answers, reference, is_closed)
    }

    /// As [`Self::of`], with the rays in batches for `subject` and one by one for `reference`. All rays begin at their
    /// origins ([`Rays`]).
    ///
    /// # Panics
    /// If a backend reports a hit that is not in `geometry`.
    pub fn of_batches(
        geometry: &Geometry,
        rays: &[Ray],
        (subject, coherence): (&impl Intersector, Coherence),
        reference: &impl Intersector,
        is_closed: bool,
    ) -> DifferenceCounts {
        let answers = |rays: &[Ray]| {
            let (mut batch, mut hits) = (Rays::new(rays.len()), Hits::new(rays.len()));
            let mut occluded = vec![false; rays.len() + PADDING];
            rays.iter().for_each(|ray| batch.push(ray));
            subject.closest_all(&batch, coherence, &Opaque, &mut hits);
            subject.occluded_all(&batch, coherence, &Opaque, &mut occluded);
            let answer = |at| Answer { ray: batch.ray(at), closest: hits.get(at), occluded: occluded[at] };
            (0..rays.len()).map(answer).collect()
        };
        DifferenceCounts::count(geometry, rays, answers, reference, is_closed)
    }

    /// Counts the `answers` to `rays`, which are asked for chunk by chunk.
    fn count(
        geometry: &Geometry,
        rays: &[Ray],
        answers: impl Fn(&[Ray]) -> Vec<Answer> + Sync,
        reference: &impl Intersector,
        is_closed: bool,
    ) -> DifferenceCounts {
        let chunk = |(at, rays): (usize, &[Ray])| {
            let mut tally = DifferenceCounts::default();
            for (i, answer) in answers(rays).iter().enumerate() {
                let expected = reference.closest(&answer.ray, &Opaque);
                tally.add((at * CHUNK + i) as u64, geometry, answer, expected, is_closed);
            }
            tally
        };
        rays.par_chunks(CHUNK).enumerate().map(chunk).reduce(DifferenceCounts::default, DifferenceCounts::plus)
    }

    fn add(&mut self, index: u64, geometry: &Geometry, answer: &Answer, expected: Option<Hit>, is_closed: bool) {
        let &Answer { ref ray, closest, occluded } = answer;
        let found = if occluded == closest.is_some() {
            agreement(geometry, ray, closest, expected)
        } else {
            // Where only the other query hit, its triangle is unknown; that of the reference is the best guess.
            closest.or(expected).map_or(Agreement::Different, |met| agreement(geometry, ray, Some(met), None))
        };
        let is_leak = is_closed && (closest.is_none() || !occluded);
        self.rays += 1;
        self.hits += u64::from(closest.is_some());
        self.ties += u64::from(found == Agreement::Tie);
        self.grazes += u64::from(found == Agreement::Graze);
        self.true_differences += u64::from(found == Agreement::Different);
        self.leaks += u64::from(is_leak);
        if (is_leak || found == Agreement::Different) && self.suspects.len() < MOST_KEPT {
            self.suspects.push(index);
        }
    }

    /// Offsets the indices of a stream that begins at `start` instead of 0.
    pub(crate) fn moved(mut self, start: u64) -> DifferenceCounts {
        self.suspects.iter_mut().for_each(|index| *index += start);
        self
    }

    /// Adds two tallies.
    pub(crate) fn plus(mut self, other: DifferenceCounts) -> DifferenceCounts {
        self.rays += other.rays;
        self.hits += other.hits;
        self.ties += other.ties;
        self.grazes += other.grazes;
        self.true_differences += other.true_differences;
        self.leaks += other.leaks;
        self.suspects.extend(other.suspects);
        self.suspects.sort_unstable();
        self.suspects.truncate(MOST_KEPT);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::AnyHit;
    use glam::Vec3;

    /// Hits object 0 always, or never.
    struct Always(bool);

    impl Intersector for Always {
        fn closest(&self, _: &Ray, _: &impl AnyHit) -> Option<Hit> {
            self.0.then_some(Hit { object: 0, primitive: 0 })
        }

        fn occluded(&self, _: &Ray, _: &impl AnyHit) -> bool {
            self.0
        }
    }

    #[test]
    fn leaks_and_differences_are_counted_and_kept_in_order() {
        let rays = vec![Ray::new(Vec3::NAN, Vec3::X); 3 * CHUNK];
        let blind = DifferenceCounts::of(&Geometry::default(), &rays, &Always(false), &Always(true), true);
        let n = rays.len() as u64;
        assert_eq!((blind.rays, blind.hits, blind.leaks, blind.true_differences), (n, 0, n, n));
        assert_eq!(blind.suspects, (0..MOST_KEPT as u64).collect::<Vec<_>>());
        let later = blind.clone().moved(n);
        assert_eq!(later.suspects[0], n, "a stream in pieces names its rays by their place in the whole");
        let both = later.plus(blind.clone());
        assert_eq!((both.rays, both.leaks, &both.suspects), (2 * n, 2 * n, &blind.suspects));
        let same = DifferenceCounts::of(&Geometry::default(), &rays, &Always(true), &Always(true), true);
        assert_eq!(same, DifferenceCounts { rays: n, hits: n, ..DifferenceCounts::default() });
    }
}
