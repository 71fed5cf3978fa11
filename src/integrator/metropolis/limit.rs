//! Splits each sample's contribution at a threshold: below it BDPT, above it MCMC.
//!
//! Contributions far above the typical radiance at their position come from rare samples. They are noise for
//! independent sampling and suit Markov chains. A sample counts up to the threshold, and chains estimate the excess.
//! Both parts are functions of the path alone and sum to the whole for any threshold. Without an excess chains receive
//! nothing, and their noise vanishes. (Derived from [light-transport.md 0.7], where the split is by path and not by
//! value.)

use super::FEWEST_EVENTS;
use super::contribution::RegionMap;
use crate::camera::CameraSample;
use crate::integrator::bidirectional::{Bidirectional, Sink, TechniqueSample};
use crate::integrator::camera_pass::Radiance;
use crate::path::TraceStats;
use crate::sampling::Sampler;
use crate::spectrum::Spectrum;

/// Lower bound of a cell's typical radiance, as a share of the mean.
const DARKEST: f64 = 0.1;

/// Contribution above which chains estimate the excess; `None` if chains estimate everything.
#[derive(Debug, Clone)]
pub(super) struct SampleThreshold(Option<RegionMap>);

impl SampleThreshold {
    /// Chains estimate everything.
    pub(super) const NONE: SampleThreshold = SampleThreshold(None);

    /// Sets the threshold to `times` the typical radiance in each part of the image.
    pub(super) fn new(usual: &RegionMap, times: f64) -> Self {
        let darkest = DARKEST * usual.mean();
        SampleThreshold(Some(usual.map(|cell| times * cell.max(darkest))))
    }

    /// Whether chains estimate everything.
    pub(super) fn is_none(&self) -> bool {
        self.0.is_none()
    }

    /// Returns the threshold at a raster position.
    pub(super) fn at(&self, film: [f32; 2]) -> f64 {
        self.0.as_ref().map_or(0.0, |picture| picture.at(film))
    }

    /// Returns the share of a contribution `worth` that lies above the threshold.
    pub(super) fn above(limit: f64, worth: f64) -> f64 {
        if worth > limit { 1.0 - limit / worth } else { 0.0 }
    }

    /// Returns the chains' share of the contribution `found`, one of `walks` subpaths per pixel. The roulette factor is
    /// removed first.
    pub(super) fn share_of_chains(&self, film: [f32; 2], found: &TechniqueSample, walks: f32) -> f32 {
        if found.s + found.t < FEWEST_EVENTS + 2 {
            return 0.0;
        }
        let worth = f64::from(found.value.mean()) * found.weight * f64::from(found.survival / walks);
        Self::above(self.at(film), worth) as f32
    }
}

/// Bidirectional path tracing without the chains' share.
pub(super) struct Limited<'a> {
    pub(super) tracer: Bidirectional<'a>,
    pub(super) limit: SampleThreshold,
    /// Light subpaths per pixel.
    pub(super) walks: f32,
}

struct Below<'l, F> {
    limit: &'l SampleThreshold,
    walks: f32,
    /// Raster position of the sample.
    film: [f32; 2],
    color: Spectrum,
    splats: &'l mut F,
}

impl<F: FnMut([f32; 2], Spectrum)> Sink for Below<'_, F> {
    fn add(&mut self, found: TechniqueSample) {
        let share = self.limit.share_of_chains(self.film, &found, 1.0);
        self.color += found.value * (found.weight as f32 * (1.0 - share));
    }

    fn splat(&mut self, film: [f32; 2], found: TechniqueSample) {
        let share = self.limit.share_of_chains(film, &found, self.walks);
        (self.splats)(film, found.value * (found.weight as f32 * (1.0 - share)));
    }
}

impl Radiance for Limited<'_> {
    fn radiance<S: Sampler>(
        &self,
        camera: &CameraSample,
        sampler: &mut S,
        light: impl FnOnce() -> S,
        splats: &mut impl FnMut([f32; 2], Spectrum),
        tally: &mut TraceStats,
    ) -> Spectrum {
        let (limit, walks, film) = (&self.limit, self.walks, camera.film);
        let mut sink = Below { limit, walks, film, color: Spectrum::ZERO, splats };
        self.tracer.sample(camera, sampler, light, &mut sink, tally);
        sink.color
    }
}
