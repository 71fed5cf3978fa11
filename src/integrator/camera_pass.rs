//! One pass: one sample for every pixel, and splats at arbitrary raster positions. The integration method evaluates the
//! samples.

use super::samples::{Sample, Samples, Work};
use super::{Guards, Integrator, IntegratorConfig, InvalidSample, PassReport, RayCounts};
use crate::camera::{Camera, CameraSample};
use crate::film::{Layout, PassFilm, Plane, Splats};
use crate::parallel::Cancel;
use crate::path::TraceStats;
use crate::sampling::{Address, Sampler};
use crate::scene::Scene;
use crate::spectrum::{LANES, Spectrum};
use rayon::prelude::*;

/// Pixels per task: enough to amortise the cost of a task, few enough for load balance.
pub(super) const CHUNK: usize = 128;

/// A method that estimates the radiance along a camera ray.
pub(super) trait Radiance: Send + Sync {
    /// Returns an unbiased estimate of the radiance along the ray of `camera`. Calls `splats` with contributions at
    /// raster positions, per pixel of film area and light subpath. `light` creates the sampler of the light subpath,
    /// one for each camera sample.
    fn radiance<S: Sampler>(
        &self,
        camera: &CameraSample,
        sampler: &mut S,
        light: impl FnOnce() -> S,
        splats: &mut impl FnMut([f32; 2], Spectrum),
        tally: &mut TraceStats,
    ) -> Spectrum;
}

/// An integrator that renders each pixel by `method`.
pub(super) struct CameraPass<'a, M: Radiance> {
    method: M,
    scene: &'a Scene,
    samples: Samples,
    options: IntegratorConfig,
}

impl<'a, M: Radiance> CameraPass<'a, M> {
    pub(super) fn new(method: M, scene: &'a Scene, camera: Camera, options: &IntegratorConfig) -> Self {
        CameraPass { method, scene, samples: Samples::new(camera, options), options: *options }
    }

    /// Renders consecutive pixels from `first` on.
    fn chunk<P: Sampler>(
        &self,
        pass: u64,
        layout: &Layout,
        (first, out): (usize, &mut [f32]),
        splats: &Splats,
        sampler: impl Fn(u64) -> P,
    ) -> PassReport {
        let channels = layout.channels();
        let mut report = PassReport::default();
        let address = Address::new(self.options.seed).with(pass);
        // A pass has as many light subpaths as pixels.
        let per_walk = (self.options.pixels() as f32).recip();
        let mut tally = TraceStats::default();
        for (i, values) in out.chunks_exact_mut(channels).enumerate() {
            // Borrowed, since a copy of what was just written stalls.
            let Sample { pixel, index, camera, numbers } = &mut self.samples.of_pixel(layout, first + i, &sampler);
            let (mut valid, mut key) = (true, address.with(*index));
            let mut splat = |film: [f32; 2], light: Spectrum| {
                let light = self.limited(light * per_walk, &mut valid, &mut report.guards);
                key = key.with(0);
                splats.add(self.options.filter, film, light, key.bits(0));
            };
            let light = || Samples::of_light(*index, &sampler);
            let color = self.method.radiance(camera, numbers, light, &mut splat, &mut tally);
            let color = self.limited(color, &mut valid, &mut report.guards);
            if !valid {
                report.drop_sample(InvalidSample { pass, x: pixel[0], y: pixel[1] });
                if let Some(at) = layout.offset(Plane::Invalid) {
                    values[at] = 1.0;
                }
            }
            values[..LANES].copy_from_slice(&color.to_rgb());
            if layout.planes().len() > 1 {
                super::features::record(self.scene, camera, numbers, layout, values, &mut tally);
            }
        }
        report.add_tally(&tally);
        report
    }

    /// Replaces a nonfinite `color` by black and sets `valid` to false. Clamps other values to the limit, if any.
    fn limited(&self, color: Spectrum, valid: &mut bool, guards: &mut Guards) -> Spectrum {
        if !color.is_finite() {
            *valid = false;
            return Spectrum::ZERO;
        }
        self.options.clamp.map_or(color, |most| clamp(color, most, guards))
    }
}

impl<M: Radiance> Integrator for CameraPass<'_, M> {
    fn run_pass(&self, pass: u64, cancel: &Cancel, out: &mut PassFilm) -> Option<PassReport> {
        self.samples.of_pass(pass, Pass { all: self, pass, cancel, out })
    }
}

/// State of a running pass.
struct Pass<'p, 'a, M: Radiance> {
    all: &'p CameraPass<'a, M>,
    pass: u64,
    cancel: &'p Cancel,
    out: &'p mut PassFilm,
}

impl<M: Radiance> Work for Pass<'_, '_, M> {
    type Output = Option<PassReport>;

    fn run<P: Sampler>(self, source: impl Fn(u64) -> P + Sync) -> Option<PassReport> {
        let Pass { all, pass, cancel, out } = self;
        let layout = out.layout().clone();
        let (chunks, splats) = out.par_chunks_and_splats(CHUNK);
        let report =
            gather(chunks.map(|chunk| (!cancel.requested()).then(|| all.chunk(pass, &layout, chunk, splats, &source))));
        out.fold_splats();
        report
    }
}

/// Merges the reports of all parts of a pass; `None` if one was cancelled.
pub(super) fn gather(parts: impl ParallelIterator<Item = Option<PassReport>>) -> Option<PassReport> {
    parts.try_reduce(PassReport::default, |mut a, b| {
        a.absorb(b);
        Some(a)
    })
}

/// Clamps each lane to `most` and records the removed energy.
fn clamp(color: Spectrum, most: f32, guards: &mut Guards) -> Spectrum {
    let limited = color.map(|x: f32| x.min(most));
    if limited != color {
        guards.clamped += 1;
        guards.clamped_energy += (color - limited).0.iter().map(|&x| f64::from(x)).sum::<f64>();
    }
    limited
}

impl PassReport {
    /// Counts a nonfinite sample.
    pub(super) fn drop_sample(&mut self, sample: InvalidSample) {
        self.guards.nonfinite += 1;
        if self.invalid.len() < Self::MAX_INVALID {
            self.invalid.push(sample);
        }
    }

    /// Adds the counters of random walks.
    pub(super) fn add_tally(&mut self, tally: &TraceStats) {
        self.absorb(PassReport {
            rays: RayCounts { camera: tally.cameras, bounce: tally.bounces, shadow: tally.shadows },
            guards: Guards { bad_hits: tally.bad_hits, overlong_paths: tally.overlong, ..Guards::default() },
            ..PassReport::default()
        });
    }
}
