//! Colours on a grid of cells: single-scattering albedos, or what multiplies emission.

use super::track::clip;
use crate::huge_vec::HugeVec;
use crate::spectrum::Spectrum;
use glam::{DAffine3, DVec3, Vec3};
use std::sync::Arc;

/// Colours in cells, without a place in the scene.
#[derive(Debug)]
pub struct ColorCells {
    size: [usize; 3],
    values: HugeVec<[f32; 3]>,
}

/// Colours in a box of the scene, linear between the centres of cells.
#[derive(Debug)]
pub struct Colors {
    cells: Arc<ColorCells>,
    /// From the scene to cells: the centre of cell (x, y, z) is at (x, y, z).
    to_cells: DAffine3,
}

impl ColorCells {
    /// Creates the colours of cells, x first, then y, then z.
    ///
    /// # Panics
    /// If the number of values is not the number of cells, or there are none.
    pub fn new(size: [usize; 3], values: Vec<[f32; 3]>) -> Self {
        let count = size.iter().product::<usize>();
        assert!(!values.is_empty() && values.len() == count, "{} values for {size:?}", values.len());
        ColorCells { size, values: values.into() }
    }

    /// Returns the number of cells on each axis.
    pub fn cells(&self) -> [usize; 3] {
        self.size
    }

    /// Returns the values.
    pub fn values(&self) -> &[[f32; 3]] {
        &self.values
    }

    /// Returns the colour at the position `q`, where centres are at whole numbers.
    fn lookup(&self, q: Vec3) -> Spectrum {
        let (mut low, mut high, mut part) = ([0; 3], [0; 3], [0.0; 3]);
        for axis in 0..3 {
            let last = self.size[axis] - 1;
            let x = q[axis].clamp(0.0, last as f32);
            low[axis] = (x as usize).min(last);
            high[axis] = (low[axis] + 1).min(last);
            part[axis] = x - low[axis] as f32;
        }
        let mix = |a: Spectrum, b: Spectrum, t: f32| a * (1.0 - t) + b * t;
        let cell = |x: usize, y: usize, z: usize| Spectrum(self.values[(z * self.size[1] + y) * self.size[0] + x]);
        let row = |y: usize, z: usize| mix(cell(low[0], y, z), cell(high[0], y, z), part[0]);
        let plane = |z: usize| mix(row(low[1], z), row(high[1], z), part[1]);
        mix(plane(low[2]), plane(high[2]), part[2])
    }
}

impl Colors {
    /// Places `cells`: `to_scene` maps the unit cube that their cells fill to the scene and has an inverse.
    pub fn new(cells: Arc<ColorCells>, to_scene: &DAffine3) -> Self {
        let scale = DAffine3::from_scale(DVec3::from(cells.cells().map(|n| n as f64)));
        let to_cells = DAffine3::from_translation(DVec3::splat(-0.5)) * scale * to_scene.inverse();
        Colors { cells, to_cells }
    }

    /// Returns the colour at the point `p`; beyond the box it is that of the border.
    pub fn at(&self, p: Vec3) -> Spectrum {
        self.cells.lookup(self.to_cells.transform_point3(p.as_dvec3()).as_vec3())
    }

    /// Returns the part in the box of the segment of `length` from `origin` along the unit vector `w`: distances of its
    /// ends, and how many cells it crosses on the axis where it crosses most.
    pub(super) fn crossed(&self, origin: Vec3, w: Vec3, length: f32) -> Option<([f32; 2], f32)> {
        let p = self.to_cells.transform_point3(origin.as_dvec3()) + 0.5;
        let d = self.to_cells.transform_vector3(w.as_dvec3());
        let [from, to] = clip(self.cells.cells(), p, d, length.into())?;
        Some(([from as f32, to as f32], ((to - from) * d.abs().max_element()) as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    #[test]
    fn albedos_are_linear_between_centres_and_constant_beyond() {
        // x + 10 y + 100 z in cells of a turned and stretched box.
        let size = [3, 2, 4];
        let value = |i: usize| (i % 3 + 10 * (i / 3 % 2) + 100 * (i / 6)) as f32;
        let values = (0..24).map(|i| [value(i), 2.0 * value(i), 0.5]).collect();
        let place = DAffine3::from_scale_rotation_translation(
            DVec3::new(3.0, 1.0, 2.0),
            DQuat::from_rotation_y(0.6),
            DVec3::new(1.0, 2.0, 3.0),
        );
        let grid = Colors::new(Arc::new(ColorCells::new(size, values)), &place);
        for [x, y, z] in [[0.5, 0.5, 0.5], [1.25, 1.0, 2.75], [2.5, 1.5, 3.5], [-4.0, 0.7, 9.0]] {
            let p = place.transform_point3(DVec3::new(x / 3.0, y / 2.0, z / 4.0)).as_vec3();
            let inside = |x: f64, n: f64| (x - 0.5).clamp(0.0, n - 1.0) as f32;
            let expected = inside(x, 3.0) + 10.0 * inside(y, 2.0) + 100.0 * inside(z, 4.0);
            let Spectrum([r, g, b]) = grid.at(p);
            // Roundings of positions of some metres, in numbers of a hundred a cell.
            assert!((r - expected).abs() < 1e-3 && (g - 2.0 * expected).abs() < 2e-3, "{r} {g} {expected}");
            assert!((b - 0.5).abs() < 1e-6);
        }
    }
}
