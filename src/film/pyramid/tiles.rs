//! Pyramid of tile means: each level doubles the tile side, from small tiles up to the whole image.

use super::sum::{Replicates, Sum};
use crate::film::{Crop, Independent};
use crate::stats::Estimate;

/// Side in pixels of the smallest tiles of a small picture.
const SIDE: u32 = 8;
/// Maximum number of smallest tiles. Large pictures have larger tiles, so that the record in an image stays small
/// relative to its pixels.
const MOST_TILES: u64 = 4096;
/// Channels of colour.
pub const CHANNELS: usize = 3;

/// Tiles of all sizes, level by level.
#[derive(Debug, Clone)]
pub struct Pyramid {
    pub(crate) crop: Crop,
    pub(crate) independent: Independent,
    pub(crate) replicates: Replicates,
    /// The smallest tiles first; the last level is one tile, the image.
    pub(crate) levels: Vec<Level>,
    /// The first level whose tiles have enough samples to be tested.
    pub(crate) first: usize,
}

/// Tiles of one size, row by row.
#[derive(Debug, Clone)]
pub(crate) struct Level {
    pub(crate) columns: usize,
    pub(crate) tiles: Vec<Tile>,
}

/// Sums over the pixels of a tile.
#[derive(Debug, Clone)]
pub(crate) struct Tile {
    pub(crate) area: Crop,
    pub(crate) pixels: f64,
    /// By channel.
    pub(crate) sums: [Sum; CHANNELS],
}

/// Side in pixels of the smallest tiles of `crop`.
pub(crate) fn smallest_side(crop: Crop) -> u32 {
    let tiles =
        |side: u32| u64::from((crop.x1 - crop.x0).div_ceil(side)) * u64::from((crop.y1 - crop.y0).div_ceil(side));
    let mut side = SIDE;
    while tiles(side) > MOST_TILES {
        side *= 2;
    }
    side
}

/// The windows of the smallest tiles, row by row, and the number of columns.
pub(crate) fn smallest_tiles(crop: Crop) -> (usize, Vec<Crop>) {
    let side = smallest_side(crop);
    let steps =
        |start: u32, end: u32| (start..end).step_by(side as usize).map(move |a| (a, end.min(a.saturating_add(side))));
    let row = |(y0, y1): (u32, u32)| steps(crop.x0, crop.x1).map(move |(x0, x1)| Crop { x0, y0, x1, y1 });
    (steps(crop.x0, crop.x1).count(), steps(crop.y0, crop.y1).flat_map(row).collect())
}

impl Pyramid {
    /// Builds the pyramid of the pixels in `crop`; `independent` tells which units are independent. `means` fills in
    /// the replicate means of a pixel (row by row) and channel.
    pub(crate) fn new(
        crop: Crop,
        independent: Independent,
        replicates: Replicates,
        means: impl Fn(usize, usize, &mut Vec<f64>),
    ) -> Pyramid {
        let width = (crop.x1 - crop.x0) as usize;
        let mut scratch = Vec::new();
        let mut tile = |area: Crop| {
            let mut tile = Tile::new(area, std::array::from_fn(|_| Sum::new(independent, &replicates)));
            for (x, y) in (area.y0..area.y1).flat_map(|y| (area.x0..area.x1).map(move |x| (x, y))) {
                let pixel = (y - crop.y0) as usize * width + (x - crop.x0) as usize;
                for (channel, sum) in tile.sums.iter_mut().enumerate() {
                    means(pixel, channel, &mut scratch);
                    sum.add_pixel(&scratch, &replicates);
                }
            }
            tile.sums.iter_mut().for_each(|sum| sum.finish(&replicates));
            tile
        };
        let (columns, areas) = smallest_tiles(crop);
        let tiles = areas.into_iter().map(&mut tile).collect();
        Pyramid::upon(crop, independent, replicates, Level { columns, tiles })
    }

    /// Builds the pyramid upon these smallest tiles.
    pub(crate) fn upon(crop: Crop, independent: Independent, replicates: Replicates, smallest: Level) -> Pyramid {
        let mut levels = vec![smallest];
        while let Some(coarser) = levels.last().filter(|l| l.tiles.len() > 1).map(Level::coarser) {
            levels.push(coarser);
        }
        Pyramid { crop, independent, replicates, levels, first: 0 }
    }

    /// Excludes from the tests the levels with fewer than `pixels` pixels per tile.
    pub(crate) fn with_tiles_of(self, pixels: f64) -> Pyramid {
        let last = self.levels.len() - 1;
        let side = f64::from(smallest_side(self.crop));
        let first = (0..last).find(|&i| (side * (1_u64 << i) as f64).powi(2) >= pixels).unwrap_or(last);
        Pyramid { first, ..self }
    }

    /// Side in pixels of the tiles of a level.
    pub(crate) fn side(&self, level: usize) -> u32 {
        smallest_side(self.crop) << level
    }

    /// The image as one tile.
    pub(crate) fn image(&self) -> &Tile {
        // `upon` ends with a level of one tile.
        let level = &self.levels[self.levels.len() - 1];
        &level.tiles[0]
    }

    /// Mean of a channel of the image.
    pub(crate) fn image_mean(&self, channel: usize) -> Estimate {
        self.estimate(self.image(), channel)
    }

    /// Mean of a channel of a tile.
    pub(crate) fn estimate(&self, tile: &Tile, channel: usize) -> Estimate {
        tile.sums[channel].estimate(tile.pixels, &self.replicates)
    }

    /// Third cumulant of this mean.
    pub(crate) fn third(&self, tile: &Tile, channel: usize) -> f64 {
        tile.sums[channel].third(tile.pixels, &self.replicates)
    }

    /// Scales every mean by `factor`, to simulate a biased renderer.
    #[cfg(test)]
    pub(crate) fn times(mut self, factor: f64) -> Pyramid {
        for tile in self.levels.iter_mut().flat_map(|l| &mut l.tiles) {
            tile.sums.iter_mut().for_each(|sum| sum.scale(factor));
        }
        self
    }
}

impl Level {
    /// Merges tiles two by two.
    fn coarser(&self) -> Level {
        let columns = self.columns.div_ceil(2);
        let rows = (self.tiles.len() / self.columns).div_ceil(2);
        let mut tiles: Vec<Option<Tile>> = vec![None; columns * rows];
        for (i, tile) in self.tiles.iter().enumerate() {
            match &mut tiles[i / self.columns / 2 * columns + i % self.columns / 2] {
                Some(merged) => merged.merge(tile),
                empty => *empty = Some(tile.clone()),
            }
        }
        Level { columns, tiles: tiles.into_iter().flatten().collect() }
    }

    /// Indices of the tiles at most two columns and rows away from tile `at`, itself included.
    pub(crate) fn around(&self, at: usize) -> impl Iterator<Item = usize> + '_ {
        let (rows, x, y) = (self.tiles.len() / self.columns, at % self.columns, at / self.columns);
        let span = |x: usize, n: usize| x.saturating_sub(2)..(x + 3).min(n);
        span(y, rows).flat_map(move |y| span(x, self.columns).map(move |x| y * self.columns + x))
    }
}

impl Tile {
    /// A tile with these sums by channel.
    pub(crate) fn new(area: Crop, sums: [Sum; CHANNELS]) -> Tile {
        Tile { area, pixels: area.pixels() as f64, sums }
    }

    fn merge(&mut self, other: &Tile) {
        let (a, b) = (self.area, other.area);
        self.area = Crop { x0: a.x0.min(b.x0), y0: a.y0.min(b.y0), x1: a.x1.max(b.x1), y1: a.y1.max(b.y1) };
        self.pixels += other.pixels;
        self.sums.iter_mut().zip(&other.sums).for_each(|(sum, other)| sum.merge(other));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pyramid(width: u32, height: u32) -> Pyramid {
        let crop = Crop { x0: 3, y0: 5, x1: 3 + width, y1: 5 + height };
        Pyramid::new(crop, Independent::Replicates, Replicates::of(&[1; 4]).unwrap(), |pixel, channel, means| {
            means.clear();
            means.extend((0..4).map(|r| pixel as f64 + 100.0 * channel as f64 + f64::from(r)));
        })
    }

    #[test]
    fn every_level_holds_every_pixel() {
        for (width, height) in [(1, 1), (8, 8), (40, 17), (9, 64)] {
            let pyramid = pyramid(width, height);
            for level in &pyramid.levels {
                let pixels: f64 = level.tiles.iter().map(|t| t.pixels).sum();
                let area: u32 = level.tiles.iter().map(|t| (t.area.x1 - t.area.x0) * (t.area.y1 - t.area.y0)).sum();
                assert_eq!((pixels, area), (f64::from(width * height), width * height));
            }
            let mean = f64::from(width * height - 1) / 2.0 + 1.5;
            let estimate = pyramid.image_mean(0);
            assert!((estimate.value - mean).abs() < 1e-9 && (estimate.dof - 3.0).abs() < 1e-9);
            assert!((estimate.standard_error - (5.0 / 12.0_f64).sqrt()).abs() < 1e-9);
        }
    }

    #[test]
    fn large_pictures_have_larger_tiles() {
        let crop = |x1, y1| Crop { x0: 0, y0: 0, x1, y1 };
        assert_eq!([crop(512, 512), crop(513, 512), crop(1920, 1080), crop(7, 3)].map(smallest_side), [8, 16, 32, 8]);
        let (columns, tiles) = smallest_tiles(crop(u32::MAX, 1));
        assert!(columns == tiles.len() && tiles.len() as u64 <= MOST_TILES && tiles[columns - 1].x1 == u32::MAX);
    }

    #[test]
    fn neighbours_are_at_most_two_tiles_away() {
        let level = &pyramid(64, 40).levels[0];
        assert_eq!((level.columns, level.tiles.len()), (8, 40));
        assert_eq!(level.around(0).collect::<Vec<_>>(), [0, 1, 2, 8, 9, 10, 16, 17, 18]);
        assert_eq!(level.around(20).count(), 25);
    }
}
