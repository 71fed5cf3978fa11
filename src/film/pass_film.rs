//! Values of one pass, before they are added to the film: one sample per pixel, plus splats.

use super::{Layout, Splats};
use rayon::prelude::*;

/// f32 values of one pass: pixel by pixel, with channels in the order of the layout.
#[derive(Debug)]
pub struct PassFilm {
    layout: Layout,
    values: Vec<f32>,
    splats: Splats,
}

/// Default unit of splats, without a typical radiance.
const UNIT: f64 = 1.0 / (1u32 << 24) as f64;

impl PassFilm {
    /// Returns a pass of zeros.
    pub fn new(layout: &Layout) -> Self {
        let values = vec![0.0; layout.pixels() * layout.channels()];
        PassFilm { layout: layout.clone(), values, splats: Splats::new(layout, UNIT) }
    }

    /// Sets the unit of splats, which must be above zero: [`super::Units::radiance`].
    #[must_use]
    pub fn with_unit(self, unit: f64) -> Self {
        PassFilm { splats: Splats::new(&self.layout, unit), ..self }
    }

    /// Returns the pixels and planes of the pass.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Sets all values and splats to zero.
    pub fn clear(&mut self) {
        self.values.fill(0.0);
        self.splats.clear();
    }

    /// Returns the splats.
    pub fn splats(&self) -> &Splats {
        &self.splats
    }

    /// Adds the splats to the samples.
    pub fn fold_splats(&mut self) {
        self.splats.fold_into(&mut self.values, self.layout.channels());
    }

    /// Returns all values: pixels × channels.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Splits the values into disjoint runs of pixels for parallel writing. Each item is (index of the first pixel,
    /// values of the run).
    ///
    /// # Panics
    /// If `pixels_per_chunk` is 0.
    pub fn par_chunks(&mut self, pixels_per_chunk: usize) -> impl IndexedParallelIterator<Item = (usize, &mut [f32])> {
        self.par_chunks_and_splats(pixels_per_chunk).0
    }

    /// Returns [`PassFilm::par_chunks`] and the splats for use at the same time.
    ///
    /// # Panics
    /// If `pixels_per_chunk` is 0.
    pub fn par_chunks_and_splats(
        &mut self,
        pixels_per_chunk: usize,
    ) -> (impl IndexedParallelIterator<Item = (usize, &mut [f32])>, &Splats) {
        let chunk = pixels_per_chunk * self.layout.channels();
        let chunks =
            self.values.par_chunks_mut(chunk).enumerate().map(move |(i, values)| (i * pixels_per_chunk, values));
        (chunks, &self.splats)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Crop, Plane};

    #[test]
    fn chunks_cover_every_pixel_once() {
        let layout = Layout::new(9, 7, Some(Crop { x0: 1, y0: 2, x1: 8, y1: 5 }), &[Plane::Depth]);
        let channels = layout.channels();
        let mut pass = PassFilm::new(&layout);
        pass.par_chunks(4).for_each(|(first, values)| {
            for (i, pixel) in values.chunks_exact_mut(channels).enumerate() {
                pixel.iter_mut().for_each(|v| *v += (first + i + 1) as f32);
            }
        });
        let expected: Vec<f32> = (0..layout.pixels() * channels).map(|i| (i / channels + 1) as f32).collect();
        assert_eq!(pass.values(), expected);
        pass.clear();
        assert!(pass.values().iter().all(|v| v.to_bits() == 0));
    }
}
