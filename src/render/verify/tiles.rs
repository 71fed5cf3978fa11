//! The means of tiles of a picture by replicate, from tiles of 8×8 pixels to the whole in steps of two.

use crate::film::Crop;
use crate::stats::{Estimate, Moments, third_cumulant_of_mean};

/// Side of the smallest tiles, in pixels.
pub(super) const SIDE: u32 = 8;
pub(super) const CHANNELS: usize = 3;

/// Tiles of all sizes.
#[derive(Debug, Clone)]
pub struct Pyramid {
    /// The smallest tiles first; the last level is one tile, the image.
    pub(super) levels: Vec<Level>,
}

/// Tiles of one size, row by row.
#[derive(Debug, Clone)]
pub(super) struct Level {
    pub(super) columns: usize,
    pub(super) tiles: Vec<Tile>,
}

/// Sums over the pixels of a tile.
#[derive(Debug, Clone)]
pub(super) struct Tile {
    pub(super) area: Crop,
    pixels: f64,
    /// By channel and replicate: of the replicate's means.
    sums: [Vec<f64>; CHANNELS],
    /// By channel: of the third cumulants of the means over all replicates.
    thirds: [f64; CHANNELS],
}

impl Pyramid {
    /// The tiles of the pixels in `crop`; `means` fills in the mean of each replicate of a pixel (row by row) and channel.
    pub fn new(crop: Crop, means: impl Fn(usize, usize, &mut Vec<f64>)) -> Pyramid {
        let mut levels = vec![Level::finest(crop, means)];
        while let Some(coarser) = levels.last().filter(|l| l.tiles.len() > 1).map(Level::coarser) {
            levels.push(coarser);
        }
        Pyramid { levels }
    }

    /// The image as one tile.
    pub(super) fn image(&self) -> &Tile {
        // `new` ends with a level of one tile.
        let level = &self.levels[self.levels.len() - 1];
        &level.tiles[0]
    }

    /// The same with every mean times `factor`: what a wrong renderer would show.
    #[cfg(test)]
    pub(super) fn times(mut self, factor: f64) -> Pyramid {
        for tile in self.levels.iter_mut().flat_map(|l| &mut l.tiles) {
            tile.sums.iter_mut().flatten().for_each(|s| *s *= factor);
            tile.thirds.iter_mut().for_each(|t| *t *= factor.powi(3));
        }
        self
    }
}

impl Level {
    fn finest(crop: Crop, means: impl Fn(usize, usize, &mut Vec<f64>)) -> Level {
        let width = crop.x1 - crop.x0;
        let steps = |start: u32, end: u32| (start..end).step_by(SIDE as usize).map(move |a| (a, (a + SIDE).min(end)));
        let mut tiles = Vec::new();
        let mut scratch = Vec::new();
        for (y0, y1) in steps(crop.y0, crop.y1) {
            for (x0, x1) in steps(crop.x0, crop.x1) {
                let mut tile = Tile::new(Crop { x0, y0, x1, y1 });
                for (x, y) in (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y))) {
                    let pixel = (y - crop.y0) as usize * width as usize + (x - crop.x0) as usize;
                    for channel in 0..CHANNELS {
                        means(pixel, channel, &mut scratch);
                        tile.add(channel, &scratch);
                    }
                }
                tiles.push(tile);
            }
        }
        Level { columns: width.div_ceil(SIDE) as usize, tiles }
    }

    /// Two by two tiles made one.
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

    /// The tiles at most two away from tile `at`, itself included.
    pub(super) fn around(&self, at: usize) -> impl Iterator<Item = usize> + '_ {
        let (rows, x, y) = (self.tiles.len() / self.columns, at % self.columns, at / self.columns);
        let span = |x: usize, n: usize| x.saturating_sub(2)..(x + 3).min(n);
        span(y, rows).flat_map(move |y| span(x, self.columns).map(move |x| y * self.columns + x))
    }
}

impl Tile {
    fn new(area: Crop) -> Tile {
        let pixels = f64::from(area.x1 - area.x0) * f64::from(area.y1 - area.y0);
        Tile { area, pixels, sums: Default::default(), thirds: [0.0; CHANNELS] }
    }

    /// Adds a pixel's means.
    fn add(&mut self, channel: usize, means: &[f64]) {
        let sums = &mut self.sums[channel];
        sums.resize(means.len(), 0.0);
        sums.iter_mut().zip(means).for_each(|(sum, m)| *sum += m);
        self.thirds[channel] += third_cumulant_of_mean(means, means.iter().sum::<f64>() / means.len() as f64);
    }

    fn merge(&mut self, other: &Tile) {
        let (a, b) = (self.area, other.area);
        self.area = Crop { x0: a.x0.min(b.x0), y0: a.y0.min(b.y0), x1: a.x1.max(b.x1), y1: a.y1.max(b.y1) };
        self.pixels += other.pixels;
        for c in 0..CHANNELS {
            self.sums[c].iter_mut().zip(&other.sums[c]).for_each(|(a, b)| *a += b);
            self.thirds[c] += other.thirds[c];
        }
    }

    /// The mean of a channel.
    pub(super) fn estimate(&self, channel: usize) -> Estimate {
        let moments: Moments = self.sums[channel].iter().map(|s| s / self.pixels).collect();
        moments.estimate().unwrap_or(Estimate { value: 0.0, standard_error: f64::INFINITY, dof: 1.0 })
    }

    /// The third cumulant of that mean, its pixels being independent.
    pub(super) fn third(&self, channel: usize) -> f64 {
        self.thirds[channel] / self.pixels.powi(3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pyramid(width: u32, height: u32) -> Pyramid {
        let crop = Crop { x0: 3, y0: 5, x1: 3 + width, y1: 5 + height };
        Pyramid::new(crop, |pixel, channel, means| {
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
            let estimate = pyramid.image().estimate(0);
            assert!((estimate.value - mean).abs() < 1e-9 && (estimate.dof - 3.0).abs() < 1e-9);
            assert!((estimate.standard_error - (5.0 / 12.0_f64).sqrt()).abs() < 1e-9);
        }
    }

    #[test]
    fn neighbours_are_at_most_two_tiles_away() {
        let level = &pyramid(64, 40).levels[0];
        assert_eq!((level.columns, level.tiles.len()), (8, 40));
        assert_eq!(level.around(0).collect::<Vec<_>>(), [0, 1, 2, 8, 9, 10, 16, 17, 18]);
        assert_eq!(level.around(20).count(), 25);
    }
}
