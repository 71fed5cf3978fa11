//! A pass: one sample of every pixel, each pixel its own, and what methods splat elsewhere. What the sample is worth is the method's.

use super::{Guards, Integrator, InvalidSample, Options, PassReport, RayCounts};
use crate::camera::Camera;
use crate::defects::{Defect, planted};
use crate::film::{FilterSampler, Layout, PassFilm, Plane, Splats};
use crate::geometry::Ray;
use crate::parallel::Cancel;
use crate::path::Tally;
use crate::sampling::{Address, Independent, Sampler, SamplerKind, Slot, Sobol};
use crate::scene::Scene;
use crate::spectrum::{LANES, Spectrum};
use rayon::prelude::*;

/// Pixels that one task renders: enough to hide the cost of a task, few enough to balance.
const CHUNK: usize = 128;

/// A method that estimates the radiance along a camera ray.
pub(super) trait Radiance: Send + Sync {
    /// An unbiased estimate of the radiance that arrives along `ray`, together with what it adds to `splats`: light at film positions,
    /// per pixel of film area and walk from a light. `light` makes the numbers of such a walk, one for each sample.
    fn radiance<S: Sampler>(
        &self,
        ray: Ray,
        sampler: &mut S,
        light: impl FnOnce() -> S,
        splats: &mut impl FnMut([f32; 2], Spectrum),
        tally: &mut Tally,
    ) -> Spectrum;
}

/// What sets the numbers of a walk from a light apart from those of the pixel's own.
const LIGHT_STREAM: u64 = 1 << 63;

/// An integrator that renders each pixel by `method`.
pub(super) struct CameraPass<'a, M: Radiance> {
    method: M,
    scene: &'a Scene,
    camera: Camera,
    options: Options,
    filter: FilterSampler,
}

impl<'a, M: Radiance> CameraPass<'a, M> {
    pub(super) fn new(method: M, scene: &'a Scene, camera: Camera, options: &Options) -> Self {
        CameraPass { method, scene, camera, options: *options, filter: FilterSampler::new(options.filter) }
    }

    /// The camera ray of one sample of a pixel.
    #[inline]
    fn camera_ray(&self, pixel: [u32; 2], sampler: &mut impl Sampler) -> Ray {
        let offset = self.filter.sample(sampler.u2(0, Slot::Aux));
        let centre = if planted(Defect::PixelCorner) { 0.0 } else { 0.5 };
        self.camera.ray([pixel[0] as f32 + centre + offset[0], pixel[1] as f32 + centre + offset[1]])
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
        let (address, per_walk) = (Address::new(self.options.seed).with(pass), (walks(layout) as f32).recip());
        let mut tally = Tally::default();
        for (i, values) in out.chunks_exact_mut(channels).enumerate() {
            let pixel = layout.pixel(first + i);
            let index = u64::from(pixel[1]) * u64::from(layout.width) + u64::from(pixel[0]);
            let mut numbers = sampler(index);
            let ray = self.camera_ray(pixel, &mut numbers);
            let (mut valid, mut key) = (true, address.with(index));
            let mut splat = |film: [f32; 2], light: Spectrum| {
                let light = self.limited(light * per_walk, &mut valid, &mut report.guards);
                key = key.with(0);
                splats.add(self.options.filter, film, light, key.bits(0));
            };
            let color = self.method.radiance(ray, &mut numbers, || sampler(index | LIGHT_STREAM), &mut splat, &mut tally);
            let color = self.limited(color, &mut valid, &mut report.guards);
            if !valid {
                report.drop_sample(InvalidSample { pass, x: pixel[0], y: pixel[1] });
                if let Some(at) = layout.offset(Plane::Invalid) {
                    values[at] = 1.0;
                }
            }
            values[..LANES].copy_from_slice(&color.to_rgb());
            if layout.planes().len() > 1 {
                super::features::record(self.scene, ray, &mut numbers, layout, values, &mut tally);
            }
        }
        report.add_tally(&tally);
        report
    }

    /// `color` as far as it is finite, which makes `valid` false otherwise, and not more than is allowed.
    fn limited(&self, color: Spectrum, valid: &mut bool, guards: &mut Guards) -> Spectrum {
        if !color.is_finite() {
            *valid = false;
            return Spectrum::ZERO;
        }
        self.options.clamp.map_or(color, |most| clamp(color, most, guards))
    }

    fn passes<P: Sampler>(
        &self,
        pass: u64,
        cancel: &Cancel,
        out: &mut PassFilm,
        sampler: impl Fn(u64) -> P + Sync,
    ) -> Option<PassReport> {
        let layout = out.layout().clone();
        let (chunks, splats) = out.par_chunks_and_splats(CHUNK);
        let report = chunks
            .map(|chunk| (!cancel.requested()).then(|| self.chunk(pass, &layout, chunk, splats, &sampler)))
            .try_reduce(PassReport::default, |mut a, b| {
                a.absorb(b);
                Some(a)
            });
        out.fold_splats();
        report
    }
}

impl<M: Radiance> Integrator for CameraPass<'_, M> {
    fn run_pass(&self, pass: u64, cancel: &Cancel, out: &mut PassFilm) -> Option<PassReport> {
        let seed = Address::new(self.options.seed);
        match self.options.sampler {
            SamplerKind::Independent => {
                let of_pass = seed.with(pass);
                self.passes(pass, cancel, out, |pixel| Independent::new(of_pass.with(pixel)))
            }
            SamplerKind::Sobol => {
                let replicates = u64::from(self.options.replicates);
                let replicate = if planted(Defect::OneScrambling) { 0 } else { pass % replicates };
                let (of_replicate, index) = (seed.with(replicate), (pass / replicates) as u32);
                self.passes(pass, cancel, out, |pixel| Sobol::new(of_replicate.with(pixel), index))
            }
        }
    }
}

/// How many walks start from lights in a pass over an image of `layout`.
fn walks(layout: &Layout) -> usize {
    if planted(Defect::SplatsOfTheWhole) { layout.width as usize * layout.height as usize } else { layout.pixels() }
}

/// Limits each lane to `most` and notes what that takes away.
fn clamp(color: Spectrum, most: f32, guards: &mut Guards) -> Spectrum {
    let limited = color.map(|x: f32| x.min(most));
    if limited != color {
        guards.clamped += 1;
        guards.clamped_energy += (color - limited).0.iter().map(|&x| f64::from(x)).sum::<f64>();
    }
    limited
}

impl PassReport {
    fn drop_sample(&mut self, sample: InvalidSample) {
        self.guards.nonfinite += 1;
        if self.invalid.len() < Self::MAX_INVALID {
            self.invalid.push(sample);
        }
    }

    fn add_tally(&mut self, tally: &Tally) {
        self.absorb(PassReport {
            rays: RayCounts { camera: tally.cameras, bounce: tally.bounces, shadow: tally.shadows },
            guards: Guards { bad_hits: tally.bad_hits, overlong_paths: tally.overlong, ..Guards::default() },
            invalid: Vec::new(),
        });
    }
}
