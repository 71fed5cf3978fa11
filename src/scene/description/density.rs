//! Densities on grids as loaded.

use crate::error::{Error, Result};
use crate::medium::Blocks;
use glam::DAffine3;
use std::sync::Arc;

/// Largest density: times the largest coefficients it is far below the end of f32.
const MOST: f32 = 1e12;

/// Densities of a medium in cells that fill a box. They multiply all its coefficients; outside of the box they are 0.
#[derive(Debug, Clone)]
pub struct DensityGrid {
    pub(in crate::scene) blocks: Arc<Blocks>,
    /// From the unit cube that the cells fill to the space of the meshes that the medium fills.
    pub(in crate::scene) transform: DAffine3,
}

impl DensityGrid {
    /// Creates the grid of `values`, x first, then y, then z, in `size` cells. `transform` maps the unit cube that the cells
    /// fill to the space of the mesh whose material has the medium: an instance takes its grid along.
    ///
    /// # Errors
    /// A scene error if the number of values is not that of the cells, a value is negative, NaN or above 1e12, or
    /// `transform` has no inverse.
    pub fn new(size: [usize; 3], values: Vec<f32>, transform: DAffine3) -> Result<DensityGrid> {
        let cells = size.iter().try_fold(1usize, |product, &n| product.checked_mul(n));
        if cells != Some(values.len()) || values.is_empty() {
            return Err(Error::scene(format!("a density grid of {size:?} cells has {} values", values.len())));
        }
        if let Some((index, value)) = values.iter().enumerate().find(|(_, value)| !(0.0..=MOST).contains(*value)) {
            return Err(Error::scene(format!("the density of cell {index} is {value}, not between 0 and {MOST:e}")));
        }
        let inverse = transform.inverse();
        if !(transform.is_finite() && inverse.is_finite()) {
            return Err(Error::scene("the transform of a density grid has no inverse"));
        }
        Ok(DensityGrid { blocks: Arc::new(Blocks::new(size, &values)), transform })
    }
}
