//! Samples of a pass: a camera ray and random numbers for each pixel, as pure functions of seed, pass and pixel.

use super::IntegratorConfig;
use crate::camera::{Camera, CameraSample};
use crate::film::{FilterSampler, Layout};
use crate::geometry::Bodies;
use crate::sampling::{Address, IndependentSampler, Sampler, SamplerKind, Slot, Sobol};
use etendue_lanes::{Float, Long, Vec3};

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
    /// Runs the computation.
    fn run(self, numbers: impl PassNumbers) -> Self::Output;
}

/// Random numbers of a pass: samplers for all pixels and their light subpaths, by index.
pub(super) trait PassNumbers: Copy + Send + Sync {
    /// Sampler of the indices in the lanes of a group.
    type Sampler<L: Long>: Sampler<L::Float>;
    /// Returns the keys of indices.
    fn keys<L: Long>(self, indices: L) -> L;
    /// Returns the sampler with these keys.
    fn of_keys<L: Long>(self, keys: L) -> Self::Sampler<L>;
    /// Returns the sampler of `index`.
    #[inline]
    fn of(self, index: u64) -> Self::Sampler<u64> {
        self.of_keys(self.keys(index))
    }
    /// Returns the sampler of the light subpath of pixel number `index`.
    #[inline]
    fn of_light(self, index: u64) -> Self::Sampler<u64> {
        self.of(index | LIGHT_STREAM)
    }
}

/// Independent random numbers of a pass.
#[derive(Clone, Copy)]
struct Independent(Address);

impl PassNumbers for Independent {
    type Sampler<L: Long> = IndependentSampler<L>;
    #[inline]
    fn keys<L: Long>(self, indices: L) -> L {
        self.0.in_lanes::<L>().with(indices).key()
    }
    #[inline]
    fn of_keys<L: Long>(self, keys: L) -> IndependentSampler<L> {
        IndependentSampler::new(Address::from_key(keys))
    }
}

/// Points of a number of the sequences of a replicate.
#[derive(Clone, Copy)]
struct SobolPoint(Address, u32);

impl PassNumbers for SobolPoint {
    type Sampler<L: Long> = Sobol<L>;
    #[inline]
    fn keys<L: Long>(self, indices: L) -> L {
        self.0.in_lanes::<L>().with(indices).key()
    }
    #[inline]
    fn of_keys<L: Long>(self, keys: L) -> Sobol<L> {
        Sobol::new(Address::from_key(keys), self.1)
    }
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
            SamplerKind::Independent => work.run(Independent(seed.with(pass))),
            SamplerKind::Sobol => {
                let replicates = u64::from(self.options.replicates);
                work.run(SobolPoint(seed.with(pass % replicates), (pass / replicates) as u32))
            }
        }
    }

    /// Returns the sample of the rendered pixel number `at` of `layout`.
    #[inline]
    pub(super) fn of_pixel<N: PassNumbers>(&self, layout: &Layout, at: usize, numbers: N) -> Sample<N::Sampler<u64>> {
        let pixel = layout.pixel(at);
        let index = layout.index(pixel);
        let mut numbers = numbers.of(index);
        let camera = self.camera_sample(pixel, &mut numbers);
        Sample { pixel, index, camera, numbers }
    }

    /// Samples camera rays of the pixels with these columns and rows in lanes: origins and directions, and the bodies
    /// that contain the camera, as [`Samples::of_pixel`] does. `None` for cameras whose rays have no kernel.
    #[inline(always)]
    pub(super) fn camera_rays<F: Float>(
        &self,
        pixel: [F; 2],
        sampler: &mut impl Sampler<F>,
    ) -> Option<([Vec3<F>; 2], Option<Bodies>)> {
        let ([x, y], [dx, dy]) = (pixel, self.filter.sample(sampler.u2(0, Slot::Film)));
        let half = F::splat(0.5);
        self.camera.pinhole_rays([x + half + dx, y + half + dy])
    }

    /// Samples the position within a pixel, by the filter, and the lens.
    #[inline]
    fn camera_sample(&self, pixel: [u32; 2], sampler: &mut impl Sampler) -> CameraSample {
        let offset = self.filter.sample(sampler.u2(0, Slot::Film));
        let film = [pixel[0] as f32 + 0.5 + offset[0], pixel[1] as f32 + 0.5 + offset[1]];
        camera_sample(&self.camera, film, sampler)
    }
}
