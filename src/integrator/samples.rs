//! Samples of a pass: a camera ray and random numbers for each pixel, as pure functions of seed, pass and pixel.

use super::IntegratorConfig;
use crate::camera::{Camera, CameraSample};
use crate::film::{FilterSampler, Layout};
use crate::sampling::{Address, IndependentSampler, Sampler, SamplerKind, Slot, Sobol};

/// Separates the random numbers of light subpaths from those of the pixel.
const LIGHT_STREAM: u64 = 1 << 63;

/// Generator of the samples of an image.
pub(super) struct Samples {
    camera: Camera,
    options: IntegratorConfig,
    filter: FilterSampler,
}

/// Sample of a pixel.
pub(super) struct Sample<P> {
    /// Column and row in the full image.
    pub(super) pixel: [u32; 2],
    /// Pixel index in the full image.
    pub(super) index: u64,
    /// First edge of its camera subpath.
    pub(super) camera: CameraSample,
    /// Sampler with the remaining random numbers.
    pub(super) numbers: P,
}

/// Computation on the samplers of a pass, generic over the sampler.
pub(super) trait Work {
    /// Result.
    type Output;
    /// Runs the computation. `source` returns the sampler of each pixel and of its light subpath.
    fn run<P: Sampler>(self, source: impl Fn(u64) -> P + Sync) -> Self::Output;
}

/// Samples the lens of `camera` for the raster position `film`, with the numbers of bounce 0.
#[inline]
pub(super) fn camera_sample(camera: &Camera, film: [f32; 2], sampler: &mut impl Sampler) -> CameraSample {
    camera.sample_ray(film, camera.sample_lens(|| sampler.u2(0, Slot::Lens)), 0.0)
}

impl Samples {
    pub(super) fn new(camera: Camera, options: &IntegratorConfig) -> Self {
        Samples { camera, options: *options, filter: FilterSampler::new(options.filter) }
    }

    /// Runs `work` with the samplers of `pass`.
    pub(super) fn of_pass<W: Work>(&self, pass: u64, work: W) -> W::Output {
        let seed = Address::new(self.options.seed);
        match self.options.sampler {
            SamplerKind::Independent => {
                let of_pass = seed.with(pass);
                work.run(|pixel| IndependentSampler::new(of_pass.with(pixel)))
            }
            SamplerKind::Sobol => {
                let replicates = u64::from(self.options.replicates);
                let (of_replicate, index) = (seed.with(pass % replicates), (pass / replicates) as u32);
                work.run(|pixel| Sobol::new(of_replicate.with(pixel), index))
            }
        }
    }

    /// Returns the sample of the rendered pixel number `at` of `layout`.
    #[inline]
    pub(super) fn of_pixel<P: Sampler>(&self, layout: &Layout, at: usize, source: impl Fn(u64) -> P) -> Sample<P> {
        let pixel = layout.pixel(at);
        let index = u64::from(pixel[1]) * u64::from(layout.width) + u64::from(pixel[0]);
        let mut numbers = source(index);
        let camera = self.camera_sample(pixel, &mut numbers);
        Sample { pixel, index, camera, numbers }
    }

    /// Returns the sampler of the light subpath of pixel number `index`.
    #[inline]
    pub(super) fn of_light<P: Sampler>(index: u64, source: impl Fn(u64) -> P) -> P {
        source(index | LIGHT_STREAM)
    }

    /// Samples the position within a pixel, by the filter, and the lens.
    #[inline]
    fn camera_sample(&self, pixel: [u32; 2], sampler: &mut impl Sampler) -> CameraSample {
        let offset = self.filter.sample(sampler.u2(0, Slot::Film));
        let film = [pixel[0] as f32 + 0.5 + offset[0], pixel[1] as f32 + 0.5 + offset[1]];
        camera_sample(&self.camera, film, sampler)
    }
}
