//! Densities, albedos and emission on grids as loaded.

use crate::error::{Error, Result};
use crate::medium::{Blocks, ColorCells};
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
    /// Creates the grid of `values`, x first, then y, then z, in `size` cells. `transform` maps the unit cube that the
    /// cells fill to the space of the mesh whose material has the medium: an instance takes its grid along.
    ///
    /// # Errors
    /// A scene error if the number of values is not that of the cells, a value is negative, NaN or above 1e12, or
    /// `transform` has no inverse.
    pub fn new(size: [usize; 3], values: Vec<f32>, transform: DAffine3) -> Result<DensityGrid> {
        check_cells("a density grid", size, values.len())?;
        if let Some((index, value)) = values.iter().enumerate().find(|(_, value)| !(0.0..=MOST).contains(*value)) {
            return Err(Error::scene(format!("the density of cell {index} is {value}, not between 0 and {MOST:e}")));
        }
        check_transform(&transform)?;
        Ok(DensityGrid { blocks: Arc::new(Blocks::new(size, &values)), transform })
    }
}

/// Colours in cells that fill a box: albedos, which multiply the scattering of a medium, or what multiplies its
/// emission.
#[derive(Debug, Clone)]
pub struct ColorGrid {
    pub(in crate::scene) cells: Arc<ColorCells>,
    /// From the unit cube that the cells fill to the space of the meshes that the medium fills.
    pub(in crate::scene) transform: DAffine3,
}

impl ColorGrid {
    /// Creates a grid of albedos, as [`DensityGrid::new`]. What they take away of scattering is absorbed. Outside of
    /// the box they are those of its border.
    ///
    /// # Errors
    /// A scene error if the number of values is not that of the cells, a value is not from 0 to 1, or `transform` has
    /// no inverse.
    pub fn albedos(size: [usize; 3], values: Vec<[f32; 3]>, transform: DAffine3) -> Result<ColorGrid> {
        ColorGrid::within("albedo", 1.0, size, values, transform)
    }

    /// Creates a grid of what multiplies emission, as [`DensityGrid::new`]. Outside of the box there is none.
    ///
    /// # Errors
    /// A scene error if the number of values is not that of the cells, a value is negative, NaN or above 1e12, or
    /// `transform` has no inverse.
    pub fn emission(size: [usize; 3], values: Vec<[f32; 3]>, transform: DAffine3) -> Result<ColorGrid> {
        ColorGrid::within("emission", MOST, size, values, transform)
    }

    fn within(
        what: &str,
        most: f32,
        size: [usize; 3],
        values: Vec<[f32; 3]>,
        transform: DAffine3,
    ) -> Result<ColorGrid> {
        check_cells(&format!("the {what} grid"), size, values.len())?;
        let is_wrong = |value: &[f32; 3]| !value.iter().all(|lane| (0.0..=most).contains(lane));
        if let Some(index) = values.iter().position(is_wrong) {
            let value = values[index];
            return Err(Error::scene(format!("the {what} of cell {index} is {value:?}, not from 0 to {most:?}")));
        }
        check_transform(&transform)?;
        Ok(ColorGrid { cells: Arc::new(ColorCells::new(size, values)), transform })
    }
}

/// Checks that the number of `values` is that of the cells of `grid`, and not 0.
fn check_cells(grid: &str, size: [usize; 3], values: usize) -> Result<()> {
    let cells = size.iter().try_fold(1usize, |product, &n| product.checked_mul(n));
    if cells == Some(values) && values > 0 {
        return Ok(());
    }
    Err(Error::scene(format!("{grid} of {size:?} cells has {values} values")))
}

fn check_transform(transform: &DAffine3) -> Result<()> {
    if transform.is_finite() && transform.inverse().is_finite() {
        return Ok(());
    }
    Err(Error::scene("the transform of a grid has no inverse"))
}
