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

impl Texture {
    /// Returns the linear value at texture coordinates `uv` of this texture's set; v = 0 is the first row.
    pub fn at(&self, uv: Vec2) -> [f32; 4] {
        let [w, h] = self.image.size();
        let p = self.transform.transform_point2(uv) * Vec2::new(w as f32, h as f32);
        let column = |x: f32| self.wrap[0].index(x as i64, w);
        let row = |y: f32| self.wrap[1].index(y as i64, h);
        match self.filter {
            TextureFilter::Nearest => self.image.texel(column(p.x.floor()), row(p.y.floor()), self.encoding),
            TextureFilter::Linear => {
                let q = p - 0.5;
                let base = q.floor();
                let f = q - base;
                let (columns, rows) = ([column(base.x), column(base.x + 1.0)], [row(base.y), row(base.y + 1.0)]);
                let mix = |[a, b]: [Vec4; 2], t: f32| a + (b - a) * t;
                let [above, below] = self.image.crossing(columns, rows, self.encoding);
                mix([mix(above, f.x), mix(below, f.x)], f.y).to_array()
            }
        }
    }
}

impl Wrap {
    #[inline]
    fn index(self, i: i64, size: u32) -> u32 {
        let n = i64::from(size);
        if (0..n).contains(&i) {
            return i as u32;
        }
        let wrapped = match self {
            Wrap::Repeat => i.rem_euclid(n),
            Wrap::Clamp => i.clamp(0, n - 1),
            Wrap::Mirror => {
                let j = i.rem_euclid(2 * n);
                if j < n { j } else { 2 * n - 1 - j }
            }
        };
        wrapped as u32
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
        for (u, want) in [(0.25, 0.0), (0.5, 0.5), (0.75, 1.0), (9.0, 1.0)] {
            assert_eq!(texture.at(Vec2::new(u, 0.5))[0], want);
        }
    }
}
