//! Textures: decoded images and their lookup.

mod bitmap;
mod block_extremes;
mod extremes;
mod radiance_map;

pub use bitmap::{Bitmap, Texels};
pub use extremes::Extremes;
pub use radiance_map::RadianceMap;

use glam::{Affine2, Vec2, Vec4};
use std::sync::Arc;

/// Encoding of stored values. Alpha is always linear.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// The sRGB transfer curve (colours).
    Srgb,
    /// As stored (data).
    Linear,
}

/// Wrap mode outside the unit square.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wrap {
    /// Repeats the image.
    #[default]
    Repeat,
    /// Repeats the image, alternately mirrored.
    Mirror,
    /// Extends the border texels.
    Clamp,
}

/// Interpolation between texel centres.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TextureFilter {
    /// The nearest texel.
    Nearest,
    /// Bilinear.
    #[default]
    Linear,
}

/// An image with its lookup parameters.
#[derive(Debug, Clone)]
pub struct Texture {
    /// The image; shared between the textures that use it.
    pub image: Arc<Bitmap>,
    /// Encoding of the stored values.
    pub encoding: Encoding,
    /// Wrapping along u and v.
    pub wrap: [Wrap; 2],
    /// Interpolation.
    pub filter: TextureFilter,
    /// Texture coordinate set, 0 or 1.
    pub uv_set: usize,
    /// KHR_texture_transform, applied to the coordinates first.
    pub transform: Affine2,
}

/// What a lookup reads: the texels where two columns and two rows cross, and how it mixes them.
#[derive(Debug, Clone, Copy, Default)]
pub struct Footprint {
    columns: [u32; 2],
    rows: [u32; 2],
    /// Weights of the second column and the second row.
    weights: Vec2,
}

impl Texture {
    /// Returns the linear value at texture coordinates `uv` of this texture's set; v = 0 is the first row.
    pub fn at(&self, uv: Vec2) -> [f32; 4] {
        self.value(self.footprint(uv))
    }

    /// Returns the linear value of the texels of `footprint`.
    #[inline]
    pub fn value(&self, footprint: Footprint) -> [f32; 4] {
        let Footprint { columns, rows, weights } = footprint;
        let mix = |[a, b]: [Vec4; 2], t: f32| a + (b - a) * t;
        let [above, below] = self.image.crossing(columns, rows, self.encoding);
        mix([mix(above, weights.x), mix(below, weights.x)], weights.y).to_array()
    }

    /// Whether lookups at equal coordinates have equal footprints in both textures.
    pub fn reads_like(&self, other: &Texture) -> bool {
        let layout = |t: &Texture| (t.image.size(), t.wrap, t.filter, t.uv_set, t.transform);
        layout(self) == layout(other)
    }

    /// Asks for the memory that [`Texture::value`] will read.
    #[inline]
    pub fn prefetch(&self, footprint: Footprint) {
        self.image.prefetch(footprint.columns, footprint.rows);
    }

    /// Returns what a lookup at texture coordinates `uv` reads.
    #[inline(always)] // else it is copied right after it was written
    pub fn footprint(&self, uv: Vec2) -> Footprint {
        let ([w, h], [across, down]) = (self.image.size(), self.wrap);
        let p = self.transform.transform_point2(uv) * Vec2::new(w as f32, h as f32);
        match self.filter {
            TextureFilter::Nearest => {
                let (column, row) = (across.index(p.x.floor() as i64, w), down.index(p.y.floor() as i64, h));
                Footprint { columns: [column; 2], rows: [row; 2], weights: Vec2::ZERO }
            }
            TextureFilter::Linear => {
                let q = p - 0.5;
                let base = q.floor();
                let (columns, rows) = (across.pair(base.x as i64, w), down.pair(base.y as i64, h));
                Footprint { columns, rows, weights: q - base }
            }
        }
    }
}

impl Wrap {
    /// Returns the texels of numbers `i` and `i` + 1 along a side of `size` texels.
    #[inline]
    fn pair(self, i: i64, size: u32) -> [u32; 2] {
        if (0..i64::from(size) - 1).contains(&i) {
            return [i as u32, i as u32 + 1];
        }
        [self.index(i, size), self.index(i.saturating_add(1), size)]
    }

    fn wrapped(self, i: i64, n: i64) -> i64 {
        match self {
            Wrap::Repeat if n & (n - 1) == 0 => i & (n - 1),
            Wrap::Repeat => i.rem_euclid(n),
            Wrap::Clamp => i.clamp(0, n - 1),
            Wrap::Mirror => {
                let j = i.rem_euclid(2 * n);
                if j < n { j } else { 2 * n - 1 - j }
            }
        }
    }

    #[inline]
    fn index(self, i: i64, size: u32) -> u32 {
        let n = i64::from(size);
        let i = if (0..n).contains(&i) { i } else { self.wrapped(i, n) };
        i as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrapping_repeats_clamps_and_mirrors() {
        let at = |w: Wrap| (-3..6).map(|i| w.index(i, 3)).collect::<Vec<_>>();
        assert_eq!(at(Wrap::Repeat), [0, 1, 2, 0, 1, 2, 0, 1, 2]);
        assert_eq!(at(Wrap::Clamp), [0, 0, 0, 0, 1, 2, 2, 2, 2]);
        assert_eq!(at(Wrap::Mirror), [2, 1, 0, 0, 1, 2, 2, 1, 0]);
    }

    #[test]
    fn bilinear_lookup_is_exact_at_texel_centres_and_midway() {
        let image = Arc::new(Bitmap::new(2, 1, Texels::Rgba8(vec![[0, 0, 0, 255], [255, 255, 255, 255]].into())));
        let texture = Texture {
            image,
            encoding: Encoding::Linear,
            wrap: [Wrap::Clamp; 2],
            filter: TextureFilter::Linear,
            uv_set: 0,
            transform: Affine2::IDENTITY,
        };
        let repeated = Texture { wrap: [Wrap::Repeat; 2], ..texture.clone() };
        let mirrored = Texture { wrap: [Wrap::Mirror; 2], ..texture.clone() };
        let cases =
            [(0.25, [0.0; 3]), (0.5, [0.5; 3]), (0.75, [1.0; 3]), (1.0, [1.0, 0.5, 1.0]), (-3.0, [0.0, 0.5, 1.0])];
        for (u, want) in cases {
            let found = [&texture, &repeated, &mirrored].map(|texture| texture.at(Vec2::new(u, 0.5))[0]);
            assert_eq!(found, want, "at {u}");
        }
    }
}
