//! Perturbations from the camera: a small change of the raster position replaces the vertices seen from the camera.
//! Dirac vertices keep their component, and the camera its point of the lens. The rest of the path is connected at the
//! first edge between smooth vertices [Veach97 §11.4.3]. Where a smooth vertex is followed by mirrors or glass, the
//! direction at it is perturbed as well. [`LensPerturbation`] has the paths without such a vertex,
//! [`MultiChainPerturbation`] those with one or more.

use super::super::ChainContext;
use super::extend::{RayEnd, SubpathBuffer, SubpathSampler};
use super::state::{PathState, Proposal};
use crate::geometry::Frame;
use crate::mcmc::{Kernel, Numbers};
use glam::{DVec3, Vec3};

/// Minimum raster displacement in pixels, and maximum as a share of the longer film side.
const PIXELS: f64 = 0.1;
const SHARE_OF_SIDE: f64 = 0.1;
/// Minimum and maximum angle by which a direction is perturbed, in radians.
const TURNS: [f64; 2] = [1e-4, 0.1];

/// Samples a log-uniform value between both bounds.
pub(super) fn log_uniform([least, most]: [f64; 2], u: f64) -> f64 {
    most * ((least / most).ln() * u).exp()
}

/// Rotates `w` by `angle`, with an azimuth from `u`.
pub(super) fn turned(w: Vec3, angle: f64, u: f64) -> Vec3 {
    let (frame, phi) = (Frame::around(w), std::f64::consts::TAU * u);
    let [s, t, n] = [frame.s, frame.t, frame.n].map(Vec3::as_dvec3);
    let w: DVec3 = (s * phi.cos() + t * phi.sin()) * angle.sin() + n * angle.cos();
    w.normalize().as_vec3()
}

/// Lens perturbation [Veach97 §11.4.3.1].
pub(super) struct LensPerturbation<'c, 'a> {
    pub(super) common: &'c ChainContext<'a>,
    pub(super) weight: f64,
}

/// Multi-chain perturbation [Veach97 §11.4.3.3].
pub(super) struct MultiChainPerturbation<'c, 'a> {
    pub(super) common: &'c ChainContext<'a>,
    pub(super) weight: f64,
}

/// Returns the index of the last vertex that moves, and the number of smooth vertices with a perturbed direction
/// before it.
fn reach(x: &PathState) -> (usize, usize) {
    let mut turned = 0;
    for i in (1..x.k()).rev() {
        if x.is_smooth(i) {
            if x.is_smooth(i - 1) {
                return (i, turned);
            }
            turned += 1;
        }
    }
    (0, turned)
}

/// Samples a raster position near `from`; `None` off the film.
fn moved(common: &ChainContext, from: [f32; 2], numbers: &mut Numbers) -> Option<[f32; 2]> {
    let most = (SHARE_OF_SIDE * f64::from(common.region.side())).max(2.0 * PIXELS);
    let r = log_uniform([PIXELS, most], numbers.uniform());
    let (sin, cos) = (std::f64::consts::TAU * numbers.uniform()).sin_cos();
    let film = [from[0] + (r * cos) as f32, from[1] + (r * sin) as f32];
    common.region.contains(film).then_some(film)
}

/// Builds the path with the vertices from the camera to number `last` moved.
fn perturb(x: &PathState, last: usize, walker: &mut SubpathSampler) -> Option<Proposal> {
    let common = walker.common;
    let film = moved(common, x.path().eye().film, walker.numbers)?;
    let mut part = SubpathBuffer::at_camera(x.lens());
    let (w, mut met) = walker.through_film(film, part.lens)?;
    part.directions.push(w);
    for i in (last.max(1)..x.k()).rev() {
        let RayEnd::Vertex(mut node) = met else { return None };
        let known = part.directions.last()?.as_vec3();
        if i == last {
            part.nodes.push(node);
            let (light, across) = (SubpathBuffer::from_light(x, i), x.path().directions()[i - 1]);
            let mut draft = Proposal::join(common, *x.path().emitter(), light, across, part)?;
            draft.smoothed(i)?;
            draft.connect(common, i - 1, walker.tally)?;
            return Some(draft);
        }
        let (w, next) = if x.is_smooth(i) {
            let w = turned(
                -x.path().directions()[i - 1].as_vec3(),
                log_uniform(TURNS, walker.numbers.uniform()),
                walker.numbers.uniform(),
            );
            (w, walker.leave(&node, w)?)
        } else {
            walker.back_through(&mut node, known, x.node(i).lobe)?
        };
        part.nodes.push(node);
        part.directions.push(-w.as_dvec3());
        met = next;
    }
    let is_surface = part.add(met);
    let (emitter, w) = part.found_light(common.scene, is_surface)?;
    Proposal::join(common, emitter, SubpathBuffer::default(), w, part)
}

/// Returns the logarithm of the density of the vertices `last` … k − 1, without factors that are equal both ways.
fn log_made(x: &PathState, last: usize) -> f64 {
    x.steps.perturbation[1][last..].iter().map(|density| density.ln()).sum()
}

/// Proposes a change of the vertices seen from the camera. Returns the logarithm of the ratio of densities, backward
/// over forward.
fn propose<'a>(
    common: &ChainContext<'a>,
    x: &PathState<'a>,
    y: &mut PathState<'a>,
    numbers: &mut Numbers,
) -> Option<f64> {
    let (last, _) = reach(x);
    let draft = perturb(x, last, &mut SubpathSampler { common, numbers, tally: &mut y.tally })?;
    y.set(common, draft)?;
    Some(log_made(x, last) - log_made(y, last))
}

/// Returns the number of perturbed directions if the path has vertices to move.
fn turns(x: &PathState) -> Option<usize> {
    let (last, turned) = reach(x);
    (last > 0 || x.steps.connects[0]).then_some(turned)
}

impl<'a> Kernel<PathState<'a>> for LensPerturbation<'_, 'a> {
    fn suitability(&self, x: &PathState<'a>) -> f64 {
        if turns(x) == Some(0) { self.weight } else { 0.0 }
    }

    fn propose(&self, x: &PathState<'a>, y: &mut PathState<'a>, numbers: &mut Numbers) -> Option<f64> {
        propose(self.common, x, y, numbers)
    }
}

impl<'a> Kernel<PathState<'a>> for MultiChainPerturbation<'_, 'a> {
    fn suitability(&self, x: &PathState<'a>) -> f64 {
        if turns(x).is_some_and(|turned| turned > 0) { self.weight } else { 0.0 }
    }

    fn propose(&self, x: &PathState<'a>, y: &mut PathState<'a>, numbers: &mut Numbers) -> Option<f64> {
        propose(self.common, x, y, numbers)
    }
}
