//! Sources of tile pyramids: films, and images that carry only per-pixel errors.

use super::sum::{Parts, Replicates, Sum};
use super::tiles::{CHANNELS, Level, Pyramid, Tile, smallest_tiles};
use crate::film::{Crop, Film, Independent, Plane};

/// Minimum number of samples of a tile with unknown skewness, so that the central limit theorem applies.
const LEAST_SAMPLES: f64 = 4096.0;

impl Pyramid {
    /// Computes the tiles of a film. `independent` tells which units of the film are independent. `None` with fewer
    /// than three replicates, or with an empty one.
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

/// Independent pixels with their standard errors.
pub struct PixelErrors<'a> {
    /// Window of the pixels.
    pub crop: Crop,
    /// Means, three values per pixel.
    pub means: &'a [f32],
    /// Standard errors, three values per pixel.
    pub errors: &'a [f32],
    /// Replicates behind the errors.
    pub replicates: usize,
    /// Samples per pixel.
    pub spp: u64,
}

impl PixelErrors<'_> {
    /// Computes the tiles of the `taken` pixels; `None` with fewer than three replicates. Pixel errors do not determine
    /// skewness, so that only tiles with 4096 samples are tested.
    pub fn pyramid(&self, taken: impl Fn(usize) -> bool) -> Option<Pyramid> {
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
