//! The values of one pass, one sample per pixel and what splats add to it, before they are added to the film.

use super::{Layout, Splats};
use rayon::prelude::*;

/// f32 values of one pass: pixel by pixel, channels as the layout orders them.
#[derive(Debug)]
pub struct PassFilm {
    layout: Layout,
    values: Vec<f32>,
    splats: Splats,
}

/// The unit of splats where nothing typical is known.
const UNIT: f64 = 1.0 / (1u32 << 24) as f64;

impl PassFilm {
    /// All zero.
    pub fn new(layout: &Layout) -> Self {
        let values = vec![0.0; layout.pixels() * layout.channels()];
        PassFilm { layout: layout.clone(), values, splats: Splats::new(layout, UNIT) }
    }

    /// The same with splats in whole numbers of `unit`, above zero: [`super::Units::radiance`].
    #[must_use]
    pub fn with_unit(self, unit: f64) -> Self {
        PassFilm { splats: Splats::new(&self.layout, unit), ..self }
    }

    /// Which pixels and planes it holds.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Sets everything to zero.
    pub fn clear(&mut self) {
        self.values.fill(0.0);
        self.splats.clear();
    }

    /// Where splats fall.
    pub fn splats(&self) -> &Splats {
        &self.splats
    }

    /// Makes the splats part of the samples.
    pub fn fold_splats(&mut self) {
        self.splats.fold_into(&mut self.values, self.layout.channels());
    }

    /// All values: pixels × channels.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Disjoint runs of pixels to be filled in parallel: (index of the first pixel, its values and those that follow).
    ///
    /// # Panics
    /// If `pixels_per_chunk` is 0.
    pub fn par_chunks(&mut self, pixels_per_chunk: usize) -> impl IndexedParallelIterator<Item = (usize, &mut [f32])> {
        self.par_chunks_and_splats(pixels_per_chunk).0
    }

    /// [`PassFilm::par_chunks`] and where splats fall at the same time.
    ///
    /// # Panics
    /// If `pixels_per_chunk` is 0.
    pub fn par_chunks_and_splats(
        &mut self,
        pixels_per_chunk: usize,
    ) -> (impl IndexedParallelIterator<Item = (usize, &mut [f32])>, &Splats) {
        let chunk = pixels_per_chunk * self.layout.channels();
        let chunks = self.values.par_chunks_mut(chunk).enumerate().map(move |(i, values)| (i * pixels_per_chunk, values));
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
