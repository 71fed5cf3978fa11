//! Lens-subpath mutation: replaces the vertices seen from the camera, up to the first edge between smooth vertices, by
//! a new subpath from a uniform raster position and a new point of the lens [Veach97 §11.4.4].

use super::super::ChainContext;
use super::extend::{SubpathBuffer, SubpathSampler};
use super::state::{PathState, Proposal};
use crate::bsdf::Lobes;
use crate::mcmc::{Kernel, Numbers};
use crate::path::{PathVertex, Scatterer};
use crate::transport::TransportMode;
use glam::Vec3;

/// Components through which the subpath continues.
const PASSAGES: [Lobes; 2] = [Lobes::DIRAC_REFLECT, Lobes::DIRAC_TRANSMIT];

/// Continuation probability of each component at `node` for the direction `known`. Otherwise the subpath ends and is
/// connected.
fn passages(node: &PathVertex, known: Vec3) -> [f64; 2] {
    match node.vertex.scatterer(known, TransportMode::Radiance) {
        Some(Scatterer::Surface(shading)) => PASSAGES.map(|lobe| shading.probability(lobe)),
        Some(Scatterer::Medium(_)) | None => [0.0; 2],
    }
}

/// The mutation.
pub(super) struct LensSubpath<'c, 'a> {
    pub(super) common: &'c ChainContext<'a>,
    pub(super) weight: f64,
}

impl<'a> LensSubpath<'_, 'a> {
    /// Returns the first smooth vertex seen from the camera, if the vertex before it is smooth.
    fn last(x: &PathState) -> Option<usize> {
        let last = (1..x.k()).rev().find(|&i| x.is_smooth(i))?;
        x.is_smooth(last - 1).then_some(last)
    }

    /// Builds the path with a new subpath in place of its vertices from number `last` on.
    fn mutate(&self, x: &PathState<'a>, last: usize, walker: &mut SubpathSampler) -> Option<Proposal> {
        let longest = self.common.edges().end().saturating_sub(last);
        let mut part = SubpathBuffer::at_camera(walker.lens());
        walker.lengthen(&mut part)?.then_some(())?;
        while part.nodes.len() <= longest {
            let (known, node) = (part.directions.last()?.as_vec3(), part.nodes.last_mut()?);
            let chances = passages(node, known);
            let Some(lobe) = PASSAGES
                .get(walker.numbers.choose([chances[0], chances[1], 1.0 - chances[0] - chances[1]].into_iter())?)
            else {
                break;
            };
            let (w, met) = walker.back_through(node, known, *lobe)?;
            part.directions.push(-w.as_dvec3());
            part.add(met).then_some(())?;
        }
        let k = last + part.nodes.len();
        if !self.common.edges().contains(&k) {
            return None;
        }
        let across = x.path().directions()[last - 1];
        let light = SubpathBuffer::from_light(x, last);
        let mut draft = Proposal::join(self.common, *x.path().emitter(), light, across, part)?;
        draft.smoothed(last)?;
        draft.connect(self.common, last - 1, walker.tally)?;
        Some(draft)
    }

    /// Returns the logarithm of the density of the vertices from number `last` on, including the raster position,
    /// the point of the lens and the end of the subpath.
    fn log_made(x: &PathState, last: usize) -> f64 {
        let goes_on: f64 = passages(x.node(last), x.path().directions()[last].as_vec3()).iter().sum();
        (1.0 - goes_on).ln() + x.steps.camera[last..].iter().map(|density| density.ln()).sum::<f64>()
    }
}

impl<'a> Kernel<PathState<'a>> for LensSubpath<'_, 'a> {
    fn suitability(&self, x: &PathState<'a>) -> f64 {
        if Self::last(x).is_some() { self.weight } else { 0.0 }
    }

    fn propose(&self, x: &PathState<'a>, y: &mut PathState<'a>, numbers: &mut Numbers) -> Option<f64> {
        let last = Self::last(x)?;
        let draft = self.mutate(x, last, &mut SubpathSampler { common: self.common, numbers, tally: &mut y.tally })?;
        y.set(self.common, draft)?;
        Some(Self::log_made(x, last) - Self::log_made(y, last))
    }
}
