//! What a state of a chain adds to the image, and the scalar that chains are led by.

use crate::film::{Crop, Filter};
use crate::spectrum::{LANES, Spectrum};
use std::sync::Arc;

/// The part of the film that paths may end on: the rendered pixels and as far around them as the filter reaches.
#[derive(Debug, Clone, Copy)]
pub(super) struct Region {
    start: [f32; 2],
    size: [f32; 2],
}

impl Region {
    pub(super) fn new(crop: Crop, filter: Filter) -> Self {
        let reach = filter.radius() as f32;
        // A pixel's filter is centred half a pixel inside.
        let margin = (reach - 0.5).max(0.0);
        let start = [crop.x0, crop.y0].map(|x| x as f32 - margin);
        let end = [crop.x1, crop.y1].map(|x| x as f32 + margin);
        Region { start, size: [end[0] - start[0], end[1] - start[1]] }
    }

    /// In pixels.
    pub(super) fn area(&self) -> f32 {
        self.size[0] * self.size[1]
    }

    /// Length of its longer side, in pixels.
    pub(super) fn side(&self) -> f32 {
        self.size[0].max(self.size[1])
    }

    /// The film position that two uniform numbers choose.
    pub(super) fn at(&self, u: [f32; 2]) -> [f32; 2] {
        [0, 1].map(|i| self.start[i] + u[i] * self.size[i])
    }

    /// The cell of a position in it, of columns times rows row by row.
    pub(super) fn cell(&self, film: [f32; 2], [columns, rows]: [usize; 2]) -> usize {
        let along = |i: usize, n: usize| (((film[i] - self.start[i]) / self.size[i] * n as f32).max(0.0) as usize).min(n - 1);
        along(1, rows) * columns + along(0, columns)
    }

    pub(super) fn contains(&self, film: [f32; 2]) -> bool {
        (0..2).all(|i| (0.0..self.size[i]).contains(&(film[i] - self.start[i])))
    }
}

/// A number for each cell of the region, columns times rows, row by row; one where all are alike.
#[derive(Debug, Clone)]
pub(super) struct Picture {
    pub(super) region: Region,
    pub(super) cells: Arc<[f64]>,
    pub(super) columns: usize,
}

impl Picture {
    /// The same everywhere.
    pub(super) fn flat(region: Region, value: f64) -> Self {
        Picture { region, cells: Arc::new([value]), columns: 1 }
    }

    /// The same cells with other numbers.
    pub(super) fn map(&self, of: impl Fn(f64) -> f64) -> Self {
        Picture { cells: self.cells.iter().map(|&cell| of(cell)).collect(), ..*self }
    }

    /// Of all cells.
    pub(super) fn mean(&self) -> f64 {
        self.cells.iter().sum::<f64>() / self.cells.len() as f64
    }

    /// At a film position.
    pub(super) fn at(&self, film: [f32; 2]) -> f64 {
        self.cells[self.region.cell(film, [self.columns, self.cells.len() / self.columns])]
    }
}

/// How much a part of the image is wanted, by which targets are divided [Veach97 §11.4.3]: the radiance that it usually has, never 0.
#[derive(Debug, Clone)]
pub(super) struct Importance(Picture);

impl Importance {
    /// Each part as bright as it is.
    pub(super) fn uniform(region: Region) -> Self {
        Importance(Picture::flat(region, 1.0))
    }

    /// For radiances that parts usually have: dark ones are lifted to a share of the mean, so that noise in the dark does not attract
    /// chains.
    pub(super) fn new(usual: &Picture) -> Self {
        /// Of the mean.
        const LEAST: f64 = 0.1;
        let mean = usual.mean();
        if mean > 0.0 { Importance(usual.map(|cell| cell / mean + LEAST)) } else { Self::uniform(usual.region) }
    }

    /// The target of `light` at a film position: positive wherever a lane is.
    pub(super) fn scalar(&self, film: [f32; 2], light: Spectrum) -> f64 {
        light.0.iter().map(|&x| f64::from(x)).sum::<f64>() / (LANES as f64 * self.0.at(film))
    }
}

/// Light at film positions, and their scalar.
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

    /// Adds light at a position in the region. What is not finite makes the whole not finite.
    pub(super) fn add(&mut self, importance: &Importance, film: [f32; 2], light: Spectrum) {
        if !light.is_black() {
            self.scalar += importance.scalar(film, light);
            self.splats.push((film, light));
        }
    }

    /// Logarithm of the scalar; −∞ for what is black.
    pub(super) fn log_scalar(&self) -> f64 {
        self.scalar.ln()
    }

    /// The scalar.
    pub(super) fn scalar(&self) -> f64 {
        self.scalar
    }

    /// What it adds where.
    pub(super) fn splats(&self) -> &[([f32; 2], Spectrum)] {
        &self.splats
    }
}
