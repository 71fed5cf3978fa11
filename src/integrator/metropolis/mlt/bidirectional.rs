//! The bidirectional mutation: vertices of a path are deleted and others put in their place, by walks from both sides and an edge that
//! joins them [Veach97 §11.4.2]. It alone reaches every path.

use super::super::Common;
use super::extend::{Part, Walker};
use super::state::{Draft, PathState};
use crate::defects::{Defect, planted};
use crate::mcmc::{Kernel, Numbers};
use std::ops::RangeInclusive;

/// Most vertices that a mutation adds beyond those that it deletes.
const MOST_MORE: usize = 6;

/// The mutation.
pub(super) struct Bidirectional<'c, 'a> {
    common: &'c Common<'a>,
    weight: f64,
    /// Edges that paths may have.
    edges: RangeInclusive<usize>,
}

/// Vertices a … a + count − 1 of a path of k edges; those before a begin with the light, those after end with the camera. With a = 0 the
/// light itself is among them; it is never kept without the vertex that it shines on.
#[derive(Debug, Clone, Copy)]
struct Range {
    a: usize,
    count: usize,
    k: usize,
}

/// How gladly `count` vertices are deleted.
fn gladness(count: usize) -> f64 {
    match count {
        0 => 0.25,
        1 => 0.5,
        _ => 0.5_f64.powi(count as i32 + 1),
    }
}

/// The same for putting `new` in the place of `old`.
fn likeness(old: usize, new: usize) -> f64 {
    match old.abs_diff(new) {
        0 => 0.5,
        1 => 0.15,
        more => 0.2 * 0.5_f64.powi(more as i32),
    }
}

/// How many ranges of `count` vertices a path of `k` edges has.
fn places(k: usize, count: usize) -> usize {
    usize::from((1..=k).contains(&count)) + (k - 1).saturating_sub(count)
}

impl Range {
    /// One of them.
    fn choose(k: usize, numbers: &mut Numbers) -> Option<Self> {
        let count = numbers.choose((0..=k).map(|count| gladness(count) * places(k, count) as f64))?;
        let place = numbers.below(places(k, count));
        let a = match (count > 0, place) {
            (true, 0) => 0,
            (true, place) => place + 1,
            (false, place) => place + 2,
        };
        Some(Range { a, count, k })
    }

    /// Past its last vertex.
    fn b(&self) -> usize {
        self.a + self.count
    }

    /// Logarithm of the probability of being chosen.
    fn log_pmf(&self) -> f64 {
        let sum: f64 = (0..=self.k).map(|count| gladness(count) * places(self.k, count) as f64).sum();
        (gladness(self.count) / sum).ln()
    }

    /// How gladly it is replaced by so many vertices: not at all where paths would be too short or too long, or the same.
    fn replacement(&self, new: usize, edges: &RangeInclusive<usize>) -> f64 {
        let k = self.k - self.count + new;
        let needed = usize::from(self.a == 0);
        let is_change = self.count > 0 || new > 0;
        if edges.contains(&k) && new >= needed && is_change { likeness(self.count, new) } else { 0.0 }
    }

    /// Numbers of vertices that may replace it, and beyond.
    fn replacements<'r>(&'r self, edges: &'r RangeInclusive<usize>) -> impl Iterator<Item = f64> + Clone + 'r {
        (0..=self.count + MOST_MORE).map(|new| self.replacement(new, edges))
    }

    /// Logarithm of the probability of `new`, and of one of the ways to make them.
    fn log_pmf_of(&self, new: usize, edges: &RangeInclusive<usize>) -> f64 {
        if new > self.count + MOST_MORE {
            return f64::NEG_INFINITY;
        }
        let sum: f64 = self.replacements(edges).sum();
        (self.replacement(new, edges) / (sum * (new + 1) as f64)).ln()
    }
}

impl<'c, 'a> Bidirectional<'c, 'a> {
    pub(super) fn new(common: &'c Common<'a>, weight: f64) -> Self {
        Bidirectional { common, weight, edges: common.edges() }
    }

    /// A path with `from_light` + `from_camera` vertices in the place of `range`.
    fn mutate(
        &self,
        x: &PathState<'a>,
        range: Range,
        [from_light, from_camera]: [usize; 2],
        walker: &mut Walker,
    ) -> Option<Draft> {
        let mut camera = Part::from_camera(x, range.b());
        let finds_light = range.a == 0 && from_light == 0;
        for i in 0..from_camera {
            let is_surface = walker.lengthen(&mut camera)?;
            if finds_light && i + 1 == from_camera {
                let (emitter, w) = camera.found_light(self.common.scene, is_surface)?;
                return Some(Part::join(emitter, Part::default(), w, camera));
            }
            is_surface.then_some(())?;
        }
        let (emitter, light, across) = match (range.a, from_light) {
            (0, 1) => {
                let (emitter, w) = walker.sample_light(camera.nodes.last()?)?;
                (emitter, Part::default(), w)
            }
            (0, _) => {
                let (emitter, mut part) = walker.emit()?;
                for _ in 2..from_light {
                    walker.lengthen_light(&mut part)?;
                }
                let last = *part.directions.last()?;
                (emitter, part, last)
            }
            (a, _) => {
                let mut part = Part::from_light(x, a);
                for _ in 0..from_light {
                    walker.lengthen_light(&mut part)?;
                }
                let last = *part.directions.last()?;
                (*x.path().emitter(), part, last)
            }
        };
        let joint = light.nodes.len();
        let mut draft = Part::join(emitter, light, across, camera);
        if joint > 0 {
            draft.smoothed(joint)?;
        }
        if joint < draft.nodes.len() {
            draft.smoothed(joint + 1)?;
        }
        draft.connect(self.common, joint, walker.tally)?;
        Some(draft)
    }

    /// Logarithm of the density with which the vertices a … b − 1 of a path are made between those around them, by all splits together.
    fn log_made(&self, y: &PathState, a: usize, b: usize) -> f64 {
        // A walk from the camera begins anywhere on the film; densities are per pixel.
        let film = if b == y.k() { f64::from(self.common.region.area()).ln() } else { 0.0 };
        let of = |s: usize| y.steps.log_split(a, b, s) - if s < b { film } else { 0.0 };
        let logs = (a..=b).filter(|&s| y.steps.connects[s]).map(of);
        let most = logs.clone().fold(f64::NEG_INFINITY, f64::max);
        if most == f64::NEG_INFINITY { most } else { most + logs.map(|log| (log - most).exp()).sum::<f64>().ln() }
    }
}

impl<'a> Kernel<PathState<'a>> for Bidirectional<'_, 'a> {
    fn suitability(&self, _: &PathState<'a>) -> f64 {
        self.weight
    }

    fn propose(&self, x: &PathState<'a>, y: &mut PathState<'a>, numbers: &mut Numbers) -> Option<f64> {
        let range = Range::choose(x.k(), numbers)?;
        let new = numbers.choose(range.replacements(&self.edges))?;
        let from_light = numbers.below(new + 1);
        let common = self.common;
        let draft =
            self.mutate(x, range, [from_light, new - from_light], &mut Walker { common, numbers, tally: &mut y.tally })?;
        y.set(self.common, draft)?;
        let back = Range { count: new, k: y.k(), ..range };
        let there = range.log_pmf() + range.log_pmf_of(new, &self.edges) + self.log_made(y, range.a, back.b());
        let deletion = if planted(Defect::DeletionNotReevaluated) { range.log_pmf() } else { back.log_pmf() };
        let again = deletion + back.log_pmf_of(range.count, &self.edges) + self.log_made(x, range.a, range.b());
        Some(again - there)
    }
}
