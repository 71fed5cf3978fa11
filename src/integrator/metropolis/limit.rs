//! Who has what light: bidirectional path tracing all that its samples find up to a limit, chains the rest.
//!
//! A sample that is worth many times what is usual where it falls is one of few that make up that light: noise for independent samples,
//! and what chains are good at. So a sample counts up to the limit and chains have what is above, as functions of the path alone: both
//! parts together are the whole, whatever the limit. Where nothing is above it nothing is left to chains, and their noise vanishes with
//! it. (Of [light-transport.md 0.7], where the split is by path and not by value.)

use super::FEWEST_EVENTS;
use super::contribution::Picture;
use crate::camera::Camera;
use crate::defects::{Defect, planted};
use crate::geometry::Ray;
use crate::integrator::bidirectional::{Bidirectional, Found, Sink};
use crate::integrator::camera_pass::Radiance;
use crate::path::Tally;
use crate::sampling::Sampler;
use crate::spectrum::Spectrum;

/// No cell is taken for darker than this share of the mean.
const DARKEST: f64 = 0.1;

/// How much a sample may be worth before chains have a part in it; nothing, where chains have everything.
#[derive(Debug, Clone)]
pub(super) struct Limit(Option<Picture>);

impl Limit {
    /// Chains have everything.
    pub(super) const NONE: Limit = Limit(None);

    /// `times` what is usual in each part of the image.
    pub(super) fn new(usual: &Picture, times: f64) -> Self {
        let darkest = DARKEST * usual.mean();
        Limit(Some(usual.map(|cell| times * cell.max(darkest))))
    }

    /// Whether chains have everything.
    pub(super) fn is_none(&self) -> bool {
        self.0.is_none()
    }

    /// The limit at a film position.
    pub(super) fn at(&self, film: [f32; 2]) -> f64 {
        self.0.as_ref().map_or(0.0, |picture| picture.at(film))
    }

    /// What chains have of a sample that is worth `worth`.
    pub(super) fn above(limit: f64, worth: f64) -> f64 {
        if worth > limit { 1.0 - limit / worth } else { 0.0 }
    }

    /// What chains have of the light that was `found` as one of so many walks a pixel. Roulette does not make it worth more.
    pub(super) fn share_of_chains(&self, film: [f32; 2], found: &Found, walks: f32) -> f32 {
        if found.s + found.t < FEWEST_EVENTS + 2 {
            return 0.0;
        }
        let worth = f64::from(found.value.mean()) * found.weight * f64::from(found.survival / walks);
        Self::above(self.at(film), worth) as f32
    }
}

/// Bidirectional path tracing without what is left to chains.
pub(super) struct Limited<'a> {
    pub(super) tracer: Bidirectional<'a>,
    pub(super) camera: Camera,
    pub(super) limit: Limit,
    /// Walks from lights for each pixel.
    pub(super) walks: f32,
}

struct Below<'l, F> {
    limit: &'l Limit,
    walks: f32,
    /// Of the sample.
    film: [f32; 2],
    color: Spectrum,
    splats: &'l mut F,
}

impl<F: FnMut([f32; 2], Spectrum)> Sink for Below<'_, F> {
    fn add(&mut self, found: Found) {
        let share = self.limit.share_of_chains(self.film, &found, 1.0);
        self.color += found.value * (found.weight as f32 * (1.0 - share));
    }

    fn splat(&mut self, film: [f32; 2], found: Found) {
        let share = if planted(Defect::SplatsUnlimited) { 0.0 } else { self.limit.share_of_chains(film, &found, self.walks) };
        (self.splats)(film, found.value * (found.weight as f32 * (1.0 - share)));
    }
}

impl Radiance for Limited<'_> {
    fn radiance<S: Sampler>(
        &self,
        ray: Ray,
        sampler: &mut S,
        light: impl FnOnce() -> S,
        splats: &mut impl FnMut([f32; 2], Spectrum),
        tally: &mut Tally,
    ) -> Spectrum {
        let film = self.camera.seen(ray.at(1.0)).map_or([0.0; 2], |seen| seen.film);
        let mut sink = Below { limit: &self.limit, walks: self.walks, film, color: Spectrum::ZERO, splats };
        self.tracer.sample(ray, sampler, light, &mut sink, tally);
        sink.color
    }
}
