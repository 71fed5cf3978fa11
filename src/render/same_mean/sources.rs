//! Where tiles come from: films, and images that carry the errors of their pixels alone.

use super::sum::{Parts, Replicates, Sum};
use super::tiles::{CHANNELS, Level, Pyramid, Tile, smallest_tiles};
use crate::film::{Crop, Film, ImageError, Independent, Plane, Reason};

/// Samples that a tile has at least whose skewness is not known, for the central limit to work on.
const LEAST_SAMPLES: f64 = 4096.0;

impl Pyramid {
    /// The tiles of a film, of whose pixels that is `independent`; `None` with fewer than three replicates or an empty one.
    pub fn of_film(film: &Film, independent: Independent) -> Option<Pyramid> {
        let passes: Vec<u64> = (0..film.replicates()).map(|r| film.passes_of(r)).collect();
        let replicates = Replicates::of(&passes)?;
        let (layout, unit) = (film.layout(), film.units().of(Plane::Color));
        let scale: Vec<f64> = passes.iter().map(|&n| unit / n as f64).collect();
        let channels = layout.channels();
        Some(Pyramid::new(layout.crop, independent, replicates, |pixel, channel, means: &mut Vec<f64>| {
            let index = pixel * channels + channel;
            means.clear();
            means.extend(film.sums().iter().zip(&scale).map(|(sums, scale)| sums.value(index) * scale));
        }))
    }
}

/// Pixels that are independent of each other, with their standard errors from some replicates.
pub(in crate::render) struct PixelErrors<'a> {
    /// Which pixels.
    pub(in crate::render) crop: Crop,
    /// Three values a pixel.
    pub(in crate::render) means: &'a [f32],
    /// As many.
    pub(in crate::render) errors: &'a [f32],
    /// Replicates behind the errors.
    pub(in crate::render) replicates: usize,
    /// Samples per pixel.
    pub(in crate::render) spp: u64,
}

impl PixelErrors<'_> {
    /// Their tiles, without the pixels that are not `taken`; `None` with fewer than three replicates. Pixel errors do not say how
    /// skewed means are: tiles have [`LEAST_SAMPLES`].
    pub(in crate::render) fn pyramid(&self, taken: impl Fn(usize) -> bool) -> Option<Pyramid> {
        let replicates = Replicates::of(&vec![1; self.replicates])?;
        let width = (self.crop.x1 - self.crop.x0) as usize;
        let (columns, areas) = smallest_tiles(self.crop);
        let tile = |area: Crop| {
            let pixels = (area.y0..area.y1).flat_map(|y| (area.x0..area.x1).map(move |x| (x, y)));
            let pixels = pixels.map(|(x, y)| (y - self.crop.y0) as usize * width + (x - self.crop.x0) as usize);
            let pixels: Vec<usize> = pixels.filter(|&pixel| taken(pixel)).collect();
            let sum = |channel: usize| Sum::Pixels(self.sum(&pixels, channel));
            Tile { pixels: pixels.len() as f64, ..Tile::new(area, std::array::from_fn(sum)) }
        };
        let smallest = Level { columns, tiles: areas.into_iter().map(tile).collect() };
        let pyramid = Pyramid::upon(self.crop, Independent::Pixels, replicates, smallest);
        Some(pyramid.with_tiles_of(LEAST_SAMPLES / self.spp.max(1) as f64))
    }

    fn sum(&self, pixels: &[usize], channel: usize) -> Parts {
        let mut sum = Parts::default();
        for at in pixels.iter().map(|pixel| pixel * CHANNELS + channel) {
            sum.add(&Parts::one(f64::from(self.means[at]), f64::from(self.errors[at]).powi(2), 0.0));
        }
        sum
    }
}

/// Why the errors of a picture's means are not to be trusted, and what they may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Doubt {
    /// Why, in words.
    pub sentence: &'static str,
    /// What samples that were not met may bring at most to a channel, as a sum over pixels; infinite where nothing bounds it.
    pub unseen: f64,
}

impl Doubt {
    /// The doubt of a picture of so many `pixels`, if there is one: light that its method meets by luck, or a heavy tail, of which more
    /// may be to come. Noise alone is no reason, since a difference of means is judged by it. What is unseen holds but for a chance
    /// of `level`.
    ///
    /// This is the one place that decides it, for all that asks whether pictures have the same mean.
    pub fn of(error: &ImageError, pixels: usize, level: f64) -> Option<Doubt> {
        let by_luck = [Reason::RarePaths, Reason::HeavyTail, Reason::FewSamples];
        let reason = error.trust().reasons.iter().map(|distrust| distrust.reason).find(|reason| by_luck.contains(reason))?;
        // A sample is the mean of its channels; all of it may be in one.
        let unseen = error.unseen_share(pixels, level) * error.mean * (pixels * CHANNELS) as f64;
        Some(Doubt { sentence: reason.sentence(), unseen })
    }
}
