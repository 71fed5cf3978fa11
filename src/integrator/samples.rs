//! The samples of a pass: a camera ray and random numbers for each pixel, functions of seed, pass and pixel alone, whoever asks.

use super::Options;
use crate::camera::Camera;
use crate::defects::{Defect, planted};
use crate::film::{FilterSampler, Layout};
use crate::geometry::Ray;
use crate::sampling::{Address, Independent, Sampler, SamplerKind, Slot, Sobol};

/// What sets the numbers of a walk from a light apart from those of the pixel's own.
const LIGHT_STREAM: u64 = 1 << 63;

/// What an image's samples are made of.
pub(super) struct Samples {
    camera: Camera,
    options: Options,
    filter: FilterSampler,
}

/// The sample of a pixel.
pub(super) struct Sample<P> {
    /// Column and row in the full image.
    pub(super) pixel: [u32; 2],
    /// The pixel's number in the full image.
    pub(super) index: u64,
    /// The ray through it.
    pub(super) ray: Ray,
    /// What is left of its numbers.
    pub(super) numbers: P,
}

/// What is done with the numbers of a pass, of whatever kind they are.
pub(super) trait Work {
    /// What comes of it.
    type Output;
    /// Does it; `source` has the numbers of each pixel and of the walk from a light that belongs to it.
    fn run<P: Sampler>(self, source: impl Fn(u64) -> P + Sync) -> Self::Output;
}

impl Samples {
    pub(super) fn new(camera: Camera, options: &Options) -> Self {
        Samples { camera, options: *options, filter: FilterSampler::new(options.filter) }
    }

    /// Does `work` with the numbers of `pass`.
    pub(super) fn of_pass<W: Work>(&self, pass: u64, work: W) -> W::Output {
        let seed = Address::new(self.options.seed);
        match self.options.sampler {
            SamplerKind::Independent => {
                let of_pass = seed.with(pass);
                work.run(|pixel| Independent::new(of_pass.with(pixel)))
            }
            SamplerKind::Sobol => {
                let replicates = u64::from(self.options.replicates);
                let replicate = if planted(Defect::OneScrambling) { 0 } else { pass % replicates };
                let (of_replicate, index) = (seed.with(replicate), (pass / replicates) as u32);
                work.run(|pixel| Sobol::new(of_replicate.with(pixel), index))
            }
        }
    }

    /// The sample of the rendered pixel number `at` of `layout`.
    #[inline]
    pub(super) fn of_pixel<P: Sampler>(&self, layout: &Layout, at: usize, source: impl Fn(u64) -> P) -> Sample<P> {
        let pixel = layout.pixel(at);
        let index = u64::from(pixel[1]) * u64::from(layout.width) + u64::from(pixel[0]);
        let mut numbers = source(index);
        let ray = self.camera_ray(pixel, &mut numbers);
        Sample { pixel, index, ray, numbers }
    }

    /// The numbers of the walk from a light that belongs to the pixel number `index`.
    #[inline]
    pub(super) fn of_light<P: Sampler>(index: u64, source: impl Fn(u64) -> P) -> P {
        source(index | LIGHT_STREAM)
    }

    /// The camera ray of one sample of a pixel.
    #[inline]
    fn camera_ray(&self, pixel: [u32; 2], sampler: &mut impl Sampler) -> Ray {
        let offset = self.filter.sample(sampler.u2(0, Slot::Aux));
        let centre = if planted(Defect::PixelCorner) { 0.0 } else { 0.5 };
        self.camera.ray([pixel[0] as f32 + centre + offset[0], pixel[1] as f32 + centre + offset[1]])
    }
}
