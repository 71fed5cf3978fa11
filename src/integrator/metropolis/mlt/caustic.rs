//! Caustic perturbation: perturbs the direction of light at the last smooth vertex before mirrors and glass, traces it
//! through the same components to the smooth vertex that the camera sees, and connects this to the same point of the
//! camera's lens [Veach97 §11.4.3.2].

use super::super::ChainContext;
use super::extend::{RayEnd, SubpathBuffer, SubpathSampler};
use super::perturb_camera::{log_uniform, turned};
use super::state::{PathState, Proposal};
use crate::geometry::{Ray, leave};
use crate::light::EmitterPoint;
use crate::mcmc::{Kernel, Numbers};

/// Minimum raster displacement in pixels, and maximum as a share of the longer film side, approximately.
const PIXELS: f64 = 0.1;
const SHARE_OF_SIDE: f64 = 0.1;
/// Maximum angle in radians.
const MOST: f64 = 1.0;

/// The perturbation.
pub(super) struct Caustic<'c, 'a> {
    pub(super) common: &'c ChainContext<'a>,
    pub(super) weight: f64,
}

impl<'a> Caustic<'_, 'a> {
    /// Returns the vertex whose direction is perturbed; `None` if no Dirac chain leads from it to a smooth vertex seen
    /// by the camera.
    fn begin(x: &PathState) -> Option<usize> {
        let seen = x.k() - 1;
        let begin = (0..seen).rev().find(|&i| x.is_smooth(i))?;
        let turns = begin > 0 || !matches!(x.path().emitter().end, EmitterPoint::Distant);
        (x.is_smooth(seen) && begin + 1 < seen && turns).then_some(begin)
    }

    /// Returns the range of angles. They displace the visible vertex by the raster range, if all mirrors were flat.
    fn angles(&self, x: &PathState, begin: usize) -> [f64; 2] {
        let seen = x.k() - 1;
        let way: f64 = (begin..seen).map(|i| x.path().length(i)).sum();
        let pixels = f64::from(x.path().eye().importance).sqrt();
        let most = (SHARE_OF_SIDE * f64::from(self.common.region.side())).max(2.0 * PIXELS);
        let angles = [PIXELS, most].map(|r| (r / (pixels * way)).min(MOST));
        [angles[0].min(0.5 * angles[1]), angles[1]]
    }

    /// Returns the logarithm of the density per solid angle of a perturbation by `angle`, which is within the range.
    fn log_turn([least, most]: [f64; 2], angle: f64) -> f64 {
        -(angle * (most / least).ln() * std::f64::consts::TAU * angle.sin()).ln()
    }

    fn perturb(&self, x: &PathState<'a>, begin: usize, angle: f64, walker: &mut SubpathSampler) -> Option<Proposal> {
        let (path, seen) = (x.path(), x.k() - 1);
        let mut w = turned(path.directions()[begin].as_vec3(), angle, walker.numbers.uniform());
        let (mut emitter, mut part) = (*path.emitter(), SubpathBuffer::default());
        let mut met = if begin > 0 {
            part = SubpathBuffer::from_light(x, begin + 1);
            walker.leave(part.nodes.last()?, w)?
        } else {
            let (ray, at) = match emitter.end {
                EmitterPoint::Surface { p, error, ng, touched } => (leave(p, error, ng, touched, w), p + w),
                EmitterPoint::Point(p) => (Ray::new(p, w), p + w),
                EmitterPoint::Distant => return None,
            };
            emitter = emitter.turned(self.common.scene, path.directions()[0], w.as_dvec3(), at)?;
            let bodies = self.common.scene.bodies_of_light(emitter.index, &ray);
            walker.along(ray.carrying(ray.state.within(bodies)))?
        };
        for i in begin + 1..=seen {
            let RayEnd::Vertex(mut node) = met else { return None };
            part.directions.push(w.as_dvec3());
            if i == seen {
                part.nodes.push(node);
                break;
            }
            let (next, beyond) = walker.through_like(&mut node, -w, x.node(i), path.directions()[i].as_vec3())?;
            part.nodes.push(node);
            (w, met) = (next, beyond);
        }
        let camera = SubpathBuffer::at_camera(x.lens());
        let mut draft = Proposal::join(self.common, emitter, part, path.directions()[seen], camera)?;
        draft.smoothed(seen)?;
        draft.connect(self.common, seen, walker.tally)?;
        Some(draft)
    }

    /// Returns the logarithm of the density of the vertices after `begin`, without that of the perturbed direction.
    fn log_made(x: &PathState, begin: usize) -> f64 {
        x.steps.perturbation[0][begin + 1..].iter().map(|density| density.ln()).sum()
    }
}

impl<'a> Kernel<PathState<'a>> for Caustic<'_, 'a> {
    fn suitability(&self, x: &PathState<'a>) -> f64 {
        if Self::begin(x).is_some() { self.weight } else { 0.0 }
    }

    fn propose(&self, x: &PathState<'a>, y: &mut PathState<'a>, numbers: &mut Numbers) -> Option<f64> {
        let begin = Self::begin(x)?;
        let angle = log_uniform(self.angles(x, begin), numbers.uniform());
        let draft =
            self.perturb(x, begin, angle, &mut SubpathSampler { common: self.common, numbers, tally: &mut y.tally })?;
        y.set(self.common, draft)?;
        let [there, again] = [self.angles(x, begin), self.angles(y, begin)];
        // The reverse perturbation must be within the range of the new path.
        if !(again[0]..=again[1]).contains(&angle) {
            return None;
        }
        let turns = Self::log_turn(again, angle) - Self::log_turn(there, angle);
        Some(turns + Self::log_made(x, begin) - Self::log_made(y, begin))
    }
}
