//! Recorded rays in batches, whose rays a structure traces together.

use crate::accel::{Coherence, Intersector};
use crate::geometry::{Hit, Hits, Opaque, PADDING, Rays};
use crate::lab::bench_rays::{Query, RayQuery};
use std::mem::replace;

/// Number of rays in a full batch, that of a batch of paths in a render.
const SIZE: usize = 1024;

/// Queries of one type. Their rays begin at their origins ([`Rays`]), as all rays of renders do.
pub(super) struct Batch {
    query: Query,
    rays: Rays,
}

/// Room for the answers to a batch.
pub(super) struct Answers {
    hits: Hits,
    occluded: Vec<bool>,
}

impl Answers {
    pub(super) fn new() -> Answers {
        Answers { hits: Hits::new(SIZE), occluded: vec![false; SIZE + PADDING] }
    }
}

impl Batch {
    fn new(query: Query) -> Batch {
        Batch { query, rays: Rays::new(SIZE) }
    }

    /// Cuts `questions` into batches. The queries of each type keep their order.
    pub(super) fn of(questions: &[RayQuery]) -> Vec<Batch> {
        let (mut batches, mut open) = (Vec::new(), [Query::Closest, Query::Occluded].map(Batch::new));
        for question in questions {
            let batch = &mut open[usize::from(question.query == Query::Occluded)];
            batch.rays.push(&question.ray);
            if batch.rays.len() == SIZE {
                batches.push(replace(batch, Batch::new(question.query)));
            }
        }
        batches.extend(open.into_iter().filter(|batch| !batch.rays.is_empty()));
        batches
    }

    /// Traces the rays on `accel` without filters; returns how many hit anything.
    pub(super) fn ask(&self, accel: &impl Intersector, coherence: Coherence, answers: &mut Answers) -> usize {
        let (rays, len) = (&self.rays, self.rays.len());
        match self.query {
            Query::Closest => {
                accel.closest_all(rays, coherence, &Opaque, &mut answers.hits);
                answers.hits.objects[..len].iter().filter(|&&object| object != Hit::NONE.object).count()
            }
            Query::Occluded => {
                accel.occluded_all(rays, coherence, &Opaque, &mut answers.occluded);
                answers.occluded[..len].iter().filter(|&&occluded| occluded).count()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::RayClass;
    use crate::geometry::Ray;
    use glam::Vec3;

    #[test]
    fn batches_have_all_queries_of_a_type_in_order() {
        let question = |i: usize| {
            let query = if i % 3 == 0 { Query::Occluded } else { Query::Closest };
            RayQuery { ray: Ray::new(Vec3::X * i as f32, Vec3::Z), query, class: RayClass::Camera }
        };
        let questions: Vec<RayQuery> = (0..4 * SIZE).map(question).collect();
        let batches = Batch::of(&questions);
        assert!(batches.iter().all(|batch| (1..=SIZE).contains(&batch.rays.len())) && batches.len() == 5);
        for query in [Query::Closest, Query::Occluded] {
            let of_type = batches.iter().filter(|batch| batch.query == query);
            let found = of_type.flat_map(|batch| (0..batch.rays.len()).map(|at| batch.rays.ray(at).origin.x as usize));
            let expected = (0..questions.len()).filter(|&i| questions[i].query == query);
            assert!(found.eq(expected), "{query:?}");
        }
        assert!(Batch::of(&[]).is_empty());
    }
}
