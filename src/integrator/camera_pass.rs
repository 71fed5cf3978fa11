//! One pass: one sample for every pixel, and splats at arbitrary raster positions. The integration method evaluates the
//! samples.

use super::samples::{PassNumbers, Sample, Samples, Work};
use super::{Guards, Integrator, IntegratorConfig, InvalidSample, LightSelection, PassReport, RayCounts};
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

/// A renderer of passes in chunks of consecutive pixels, which tasks share.
pub(super) trait Chunks: Send + Sync {
    /// Returns the generator of its samples.
    fn samples(&self) -> &Samples;
    /// Returns the number of pixels in a chunk, in a pass of `pixels`.
    fn chunk_size(&self, pixels: usize) -> usize;
    /// Renders consecutive pixels: the number of the first, and the values of all planes.
    fn chunk(
        &self,
        pass: u64,
        layout: &Layout,
        pixels: (usize, &mut [f32]),
        splats: &Splats,
        numbers: impl PassNumbers,
    ) -> PassReport;
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
}

impl<M: Radiance> Chunks for CameraPass<'_, M> {
    fn samples(&self) -> &Samples {
        &self.samples
    }

    fn chunk_size(&self, _: usize) -> usize {
        CHUNK
    }

    fn chunk(
        &self,
        pass: u64,
        layout: &Layout,
        (first, out): (usize, &mut [f32]),
        splats: &Splats,
        numbers: impl PassNumbers,
    ) -> PassReport {
        let mut record = SampleRecord::new(self.scene, &self.options, layout, pass);
        let address = Address::new(self.options.seed).with(pass);
        // A pass has as many light subpaths as pixels.
        let per_walk = (self.options.pixels() as f32).recip();
        let mut queue = splats.queue(self.options.filter);
        for (i, values) in out.chunks_exact_mut(layout.channels()).enumerate() {
            // Borrowed, since a copy of what was just written stalls.
            let sample = &mut self.samples.of_pixel(layout, first + i, numbers);
            let (mut valid, mut key) = (true, address.with(sample.index));
            let mut splat = |film: [f32; 2], light: Spectrum| {
                let light = limited(&self.options, light * per_walk, &mut valid, &mut record.report.guards);
                key = key.with(0);
                queue.add(film, light, key.bits(0));
            };
            let light = || numbers.of_light(sample.index);
            let tally = &mut record.tally;
            let color = self.method.radiance(&sample.camera, &mut sample.numbers, light, &mut splat, tally);
            record.put(sample.pixel, color, valid, values);
            record.features(sample, values);
        }
        record.finish()
    }
}

/// Records the samples of a part of a pass in the planes of their pixels.
pub(super) struct SampleRecord<'p> {
    scene: &'p Scene,
    options: &'p IntegratorConfig,
    layout: &'p Layout,
    pass: u64,
    report: PassReport,
    /// Counters of the random walks.
    pub(super) tally: TraceStats,
}

impl<'p> SampleRecord<'p> {
    pub(super) fn new(scene: &'p Scene, options: &'p IntegratorConfig, layout: &'p Layout, pass: u64) -> Self {
        SampleRecord { scene, options, layout, pass, report: PassReport::default(), tally: TraceStats::default() }
    }

    /// Writes the `color` of a sample of `pixel` to the `values` of the pixel. A sample that is not `valid` or not finite
    /// counts as black.
    #[inline]
    pub(super) fn put(&mut self, pixel: [u32; 2], color: Spectrum, mut valid: bool, values: &mut [f32]) {
        let color = limited(self.options, color, &mut valid, &mut self.report.guards);
        if !valid {
            self.report.drop_sample(InvalidSample { pass: self.pass, x: pixel[0], y: pixel[1] });
            if let Some(at) = self.layout.offset(Plane::Invalid) {
                values[at] = 1.0;
            }
        }
        values[..LANES].copy_from_slice(&color.to_rgb());
    }

    /// Whether there are planes besides colour.
    #[inline]
    pub(super) fn has_features(&self) -> bool {
        self.layout.planes().len() > 1
    }

    /// Writes the feature planes of `sample`, if there are any, to the `values` of its pixel.
    #[inline]
    pub(super) fn features<P: Sampler>(&mut self, sample: &mut Sample<P>, values: &mut [f32]) {
        if self.has_features() {
            let Sample { camera, numbers, .. } = sample;
            super::features::record(self.scene, camera, numbers, self.layout, values, &mut self.tally);
        }
    }

    /// Returns the report of all samples.
    pub(super) fn finish(mut self) -> PassReport {
        self.report.add_tally(&self.tally);
        self.report
    }
}

/// Replaces a nonfinite `color` by black and sets `valid` to false. Clamps other values to the limit, if any.
fn limited(options: &IntegratorConfig, color: Spectrum, valid: &mut bool, guards: &mut Guards) -> Spectrum {
    if !color.is_finite() {
        *valid = false;
        return Spectrum::ZERO;
    }
    options.clamp.map_or(color, |most| clamp(color, most, guards))
}

impl<C: Chunks> Integrator for C {
    fn run_pass(&self, pass: u64, cancel: &Cancel, out: &mut PassFilm) -> Option<PassReport> {
        self.samples().of_pass(pass, Pass { all: self, pass, cancel, out })
    }
}

/// State of a running pass.
struct Pass<'p, C: Chunks> {
    all: &'p C,
    pass: u64,
    cancel: &'p Cancel,
    out: &'p mut PassFilm,
}

impl<C: Chunks> Work for Pass<'_, C> {
    type Output = Option<PassReport>;

    fn run(self, numbers: impl PassNumbers) -> Option<PassReport> {
        let Pass { all, pass, cancel, out } = self;
        let layout = out.layout().clone();
        let (chunks, splats) = out.par_chunks_and_splats(all.chunk_size(layout.pixels()));
        let report =
            gather(chunks.map(|chunk| (!cancel.requested()).then(|| all.chunk(pass, &layout, chunk, splats, numbers))));
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
            guards: Guards {
                bad_hits: tally.bad_hits,
                overlong_paths: tally.overlong,
                clamped: tally.clamped,
                clamped_energy: tally.clamped_energy,
                ..Guards::default()
            },
            selection: LightSelection {
                seconds: tally.selection.seconds(),
                cuts: tally.selection.cuts,
                groups: tally.selection.groups,
            },
            ..PassReport::default()
        });
    }
}
