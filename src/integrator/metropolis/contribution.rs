//! Image contribution of a chain state, and its scalar contribution function, the target density.

use crate::film::{Crop, Filter};
use crate::spectrum::{LANES, Spectrum};
use std::sync::Arc;

/// Part of the film on which paths may end: the rendered pixels plus the filter margin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Region {
    start: [f32; 2],
    size: [f32; 2],
}

impl Region {
    pub(super) fn new(crop: Crop, filter: Filter) -> Self {
        let reach = filter.radius() as f32;
        // The filter of a pixel is centred half a pixel inside.
        let margin = (reach - 0.5).max(0.0);
        let start = [crop.x0, crop.y0].map(|x| x as f32 - margin);
        let end = [crop.x1, crop.y1].map(|x| x as f32 + margin);
        Region { start, size: [end[0] - start[0], end[1] - start[1]] }
    }

    /// Area in pixels.
    pub(super) fn area(&self) -> f32 {
        self.size[0] * self.size[1]
    }

    /// Length of the longer side, in pixels.
    pub(super) fn side(&self) -> f32 {
        self.size[0].max(self.size[1])
    }

    /// Maps two uniform random numbers to a raster position.
    pub(super) fn at(&self, u: [f32; 2]) -> [f32; 2] {
        [0, 1].map(|i| self.start[i] + u[i] * self.size[i])
    }

    /// Returns the row-major index of the cell that contains a position.
    pub(super) fn cell(&self, film: [f32; 2], [columns, rows]: [usize; 2]) -> usize {
        let along =
            |i: usize, n: usize| (((film[i] - self.start[i]) / self.size[i] * n as f32).max(0.0) as usize).min(n - 1);
        along(1, rows) * columns + along(0, columns)
    }

    pub(super) fn contains(&self, film: [f32; 2]) -> bool {
        (0..2).all(|i| (0.0..self.size[i]).contains(&(film[i] - self.start[i])))
    }
}

/// A value for each cell of the region, in row-major order; a single cell for a constant.
#[derive(Debug, Clone)]
pub(super) struct RegionMap {
    pub(super) region: Region,
    pub(super) cells: Arc<[f64]>,
    pub(super) columns: usize,
}

impl RegionMap {
    /// Creates a constant map.
    pub(super) fn flat(region: Region, value: f64) -> Self {
        RegionMap { region, cells: Arc::new([value]), columns: 1 }
    }

    /// Applies a function to each cell.
    pub(super) fn map(&self, of: impl Fn(f64) -> f64) -> Self {
        RegionMap { cells: self.cells.iter().map(|&cell| of(cell)).collect(), ..*self }
    }

    /// Returns the mean over all cells.
    pub(super) fn mean(&self) -> f64 {
        self.cells.iter().sum::<f64>() / self.cells.len() as f64
    }

    /// Returns the value at a raster position.
    pub(super) fn at(&self, film: [f32; 2]) -> f64 {
        self.cells[self.region.cell(film, [self.columns, self.cells.len() / self.columns])]
    }
}

/// Typical radiance by image region, never 0, by which the target is divided [Veach97 §11.4.3].
#[derive(Debug, Clone)]
pub(super) struct ImageImportance(RegionMap);

impl ImageImportance {
    /// Creates a uniform importance: the target is proportional to radiance.
    pub(super) fn uniform(region: Region) -> Self {
        ImageImportance(RegionMap::flat(region, 1.0))
    }

    /// Creates the importance for typical radiances. Dark regions are raised by a share of the mean, so that noise in
    /// them does not attract chains.
    pub(super) fn new(usual: &RegionMap) -> Self {
        /// Share of the mean.
        const LEAST: f64 = 0.1;
        let mean = usual.mean();
        if mean > 0.0 { ImageImportance(usual.map(|cell| cell / mean + LEAST)) } else { Self::uniform(usual.region) }
    }

    /// Returns the target value of `light` at a raster position: positive wherever a lane is.
    pub(super) fn scalar(&self, film: [f32; 2], light: Spectrum) -> f64 {
        light.0.iter().map(|&x| f64::from(x)).sum::<f64>() / (LANES as f64 * self.0.at(film))
    }
}

/// Splats at raster positions, and their scalar contribution.
#[derive(Debug, Clone, Default)]
pub(super) struct Contribution {
    splats: Vec<([f32; 2], Spectrum)>,
    scalar: f64,
}

impl Contribution {
    pub(super) fn clear(&mut self) {
        self.splats.clear();
        self.scalar = 0.0;
    }

    /// Adds light at a position in the region. A nonfinite value makes the scalar nonfinite.
    pub(super) fn add(&mut self, importance: &ImageImportance, film: [f32; 2], light: Spectrum) {
        if !light.is_black() {
            self.scalar += importance.scalar(film, light);
            self.splats.push((film, light));
        }
    }

    /// Returns the logarithm of the scalar contribution; −∞ if black.
    pub(super) fn log_scalar(&self) -> f64 {
        self.scalar.ln()
    }

    /// Scalar contribution.
    pub(super) fn scalar(&self) -> f64 {
        self.scalar
    }

    /// Splats.
    pub(super) fn splats(&self) -> &[([f32; 2], Spectrum)] {
        &self.splats
    }
}
