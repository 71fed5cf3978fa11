//! The values of one pass, one sample per pixel, before they are added to the film.

use super::Layout;
use rayon::prelude::*;

/// f32 values of one pass: pixel by pixel, channels as the layout orders them.
#[derive(Debug, Clone)]
pub struct PassFilm {
    layout: Layout,
    values: Vec<f32>,
}

impl PassFilm {
    /// All zero.
    pub fn new(layout: &Layout) -> Self {
        PassFilm { layout: layout.clone(), values: vec![0.0; layout.pixels() * layout.channels()] }
    }

    /// Which pixels and planes it holds.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Sets everything to zero.
    pub fn clear(&mut self) {
        self.values.fill(0.0);
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
        let chunk = pixels_per_chunk * self.layout.channels();
        self.values.par_chunks_mut(chunk).enumerate().map(move |(i, values)| (i * pixels_per_chunk, values))
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
