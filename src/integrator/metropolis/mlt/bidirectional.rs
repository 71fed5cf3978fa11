//! Bidirectional mutation: deletes vertices of a path and inserts new ones, by subpaths from both sides and a
//! connecting edge [Veach97 §11.4.2]. The point of the lens is new if the vertex next to it is. It is the only mutation
//! that can reach every path.

use super::super::ChainContext;
use super::extend::{SubpathBuffer, SubpathSampler};
use super::state::{PathState, Proposal};
use crate::mcmc::{Kernel, Numbers};
use std::ops::RangeInclusive;

/// Maximum number of vertices that a mutation adds beyond those that it deletes.
const MOST_MORE: usize = 6;

/// The mutation.
pub(super) struct Bidirectional<'c, 'a> {
    common: &'c ChainContext<'a>,
    weight: f64,
    /// Numbers of edges of valid paths.
    edges: RangeInclusive<usize>,
}

/// Vertices a … a + count − 1 of a path of k edges. Those before a belong to the light side, those after to the camera
/// side. With a = 0 the range contains x₀. x₀ is never kept without x₁.
#[derive(Debug, Clone, Copy)]
struct Range {
    a: usize,
    count: usize,
    k: usize,
}

/// Deletion probability p_d,1 [Veach97 §11.4.2.1], unnormalised.
fn deletion_weight(count: usize) -> f64 {
    match count {
        0 => 0.25,
        1 => 0.5,
        _ => 0.5_f64.powi(count as i32 + 1),
    }
}

/// Unnormalised probability of replacing `old` vertices by `new`.
fn insertion_weight(old: usize, new: usize) -> f64 {
    match old.abs_diff(new) {
        0 => 0.5,
        1 => 0.15,
        more => 0.2 * 0.5_f64.powi(more as i32),
    }
}

/// Returns the number of ranges of `count` vertices in a path of `k` edges.
fn range_count(k: usize, count: usize) -> usize {
    usize::from((1..=k).contains(&count)) + (k - 1).saturating_sub(count)
}

impl Range {
    /// Samples a range.
    fn choose(k: usize, numbers: &mut Numbers) -> Option<Self> {
        let count = numbers.choose((0..=k).map(|count| deletion_weight(count) * range_count(k, count) as f64))?;
        let place = numbers.below(range_count(k, count));
        let a = match (count > 0, place) {
            (true, 0) => 0,
            (true, place) => place + 1,
            (false, place) => place + 2,
        };
        Some(Range { a, count, k })
    }

    /// One past the last vertex.
    fn b(&self) -> usize {
        self.a + self.count
    }

    /// Returns the logarithm of the probability of this range.
    fn log_pmf(&self) -> f64 {
        let sum: f64 = (0..=self.k).map(|count| deletion_weight(count) * range_count(self.k, count) as f64).sum();
        (deletion_weight(self.count) / sum).ln()
    }

    /// Unnormalised probability of `new` replacement vertices; 0 if the path would be too short, too long or unchanged.
    fn replacement(&self, new: usize, edges: &RangeInclusive<usize>) -> f64 {
        let k = self.k - self.count + new;
        let needed = usize::from(self.a == 0);
        let is_change = self.count > 0 || new > 0;
        if edges.contains(&k) && new >= needed && is_change { insertion_weight(self.count, new) } else { 0.0 }
    }

    /// Enumerates [`Range::replacement`] for 0 vertices up to the maximum.
    fn replacements<'r>(&'r self, edges: &'r RangeInclusive<usize>) -> impl Iterator<Item = f64> + Clone + 'r {
        (0..=self.count + MOST_MORE).map(|new| self.replacement(new, edges))
    }

    /// Returns the logarithm of the probability of `new` vertices, times that of one split between the two sides.
    fn log_pmf_of(&self, new: usize, edges: &RangeInclusive<usize>) -> f64 {
        if new > self.count + MOST_MORE {
            return f64::NEG_INFINITY;
        }
        let sum: f64 = self.replacements(edges).sum();
        (self.replacement(new, edges) / (sum * (new + 1) as f64)).ln()
    }
}

impl<'c, 'a> Bidirectional<'c, 'a> {
    pub(super) fn new(common: &'c ChainContext<'a>, weight: f64) -> Self {
        Bidirectional { common, weight, edges: common.edges() }
    }

    /// Builds the path with `from_light` + `from_camera` vertices in place of `range`.
    fn mutate(
        &self,
        x: &PathState<'a>,
        range: Range,
        [from_light, from_camera]: [usize; 2],
        walker: &mut SubpathSampler,
    ) -> Option<Proposal> {
        let mut camera = SubpathBuffer::from_camera(x, range.b());
        if range.b() == x.k() {
            camera.lens = walker.lens();
        }
        let finds_light = range.a == 0 && from_light == 0;
        for i in 0..from_camera {
            let is_surface = walker.lengthen(&mut camera)?;
            if finds_light && i + 1 == from_camera {
                let (emitter, w) = camera.found_light(self.common.scene, is_surface)?;
                return Proposal::join(self.common, emitter, SubpathBuffer::default(), w, camera);
            }
            is_surface.then_some(())?;
        }
        let (emitter, light, across) = match (range.a, from_light) {
            (0, 1) => {
                let (emitter, w) = walker.sample_light(camera.nodes.last()?)?;
                (emitter, SubpathBuffer::default(), w)
            }
            (0, _) => {
                let (emitter, mut part) = walker.sample_le()?;
                for _ in 2..from_light {
                    walker.lengthen_light(&mut part)?;
                }
                let last = *part.directions.last()?;
                (emitter, part, last)
            }
            (a, _) => {
                let mut part = SubpathBuffer::from_light(x, a);
                for _ in 0..from_light {
                    walker.lengthen_light(&mut part)?;
                }
                let last = *part.directions.last()?;
                (*x.path().emitter(), part, last)
            }
        };
        let joint = light.nodes.len();
        let mut draft = Proposal::join(self.common, emitter, light, across, camera)?;
        if joint > 0 {
            draft.smoothed(joint)?;
        }
        if joint < draft.nodes.len() {
            draft.smoothed(joint + 1)?;
        }
        draft.connect(self.common, joint, walker.tally)?;
        Some(draft)
    }

    /// Returns the logarithm of the density of the vertices a … b − 1 given the others, summed over all splits. Where
    /// the last of them is next to the camera, the point of the lens is new as well.
    fn log_made(&self, y: &PathState, a: usize, b: usize) -> f64 {
        let to_camera = b == y.k();
        // Camera subpaths start uniformly on the film; densities are per pixel.
        let film = if to_camera { f64::from(self.common.region.area()).ln() } else { 0.0 };
        let last = if to_camera { b + 1 } else { b };
        let of = |s: usize| y.steps.log_split(a, last, s) - if s < b { film } else { 0.0 };
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
        let draft = self.mutate(
            x,
            range,
            [from_light, new - from_light],
            &mut SubpathSampler { common, numbers, tally: &mut y.tally },
        )?;
        y.set(self.common, draft)?;
        let back = Range { count: new, k: y.k(), ..range };
        let there = range.log_pmf() + range.log_pmf_of(new, &self.edges) + self.log_made(y, range.a, back.b());
        let again = back.log_pmf() + back.log_pmf_of(range.count, &self.edges) + self.log_made(x, range.a, range.b());
        Some(again - there)
    }
}
