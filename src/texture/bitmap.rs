//! Decoded images.

use super::Encoding;
use super::block_extremes::{self, Stored};
use crate::huge_vec::HugeVec;
use etendue_lanes::prefetch;
use glam::Vec4;
use std::sync::{LazyLock, OnceLock};

/// Stored texels, row by row from the top.
#[derive(Debug)]
pub enum Texels {
    /// 8 bits per channel.
    Rgba8(HugeVec<[u8; 4]>),
    /// 16 bits per channel.
    Rgba16(HugeVec<[u16; 4]>),
}

/// An image in memory.
pub struct Bitmap {
    width: u32,
    height: u32,
    texels: Texels,
    /// Cached properties, since many materials may share an image.
    hash: OnceLock<blake3::Hash>,
    blocks: OnceLock<Box<[Stored]>>,
}

/// Prints size and content hash, but not the texels.
impl std::fmt::Debug for Bitmap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Bitmap({}x{} {})", self.width, self.height, self.texel_hash().to_hex())
    }
}

static SRGB8: LazyLock<[f32; 256]> = LazyLock::new(|| LINEAR8.map(srgb_to_linear));

/// Table of i / 255: a lookup needs up to sixteen of them, and a division takes longer than a load.
static LINEAR8: [f32; 256] = {
    let mut values = [0.0; 256];
    let mut i = 0;
    while i < 256 {
        values[i] = i as f32 / 255.0;
        i += 1;
    }
    values
};

/// The sRGB electro-optical transfer function (IEC 61966-2-1).
fn srgb_to_linear(x: f32) -> f32 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

#[inline]
fn linear8([r, g, b, a]: [u8; 4], colors: &[f32; 256]) -> [f32; 4] {
    [colors[usize::from(r)], colors[usize::from(g)], colors[usize::from(b)], LINEAR8[usize::from(a)]]
}

#[inline]
fn linear16(texel: [u16; 4], encoding: Encoding) -> [f32; 4] {
    let [r, g, b, a] = texel.map(|c| f32::from(c) / 65535.0);
    match encoding {
        Encoding::Linear => [r, g, b, a],
        Encoding::Srgb => [srgb_to_linear(r), srgb_to_linear(g), srgb_to_linear(b), a],
    }
}

impl Bitmap {
    /// Returns an image of `width` × `height` texels.
    ///
    /// # Panics
    /// If a side is 0 or the number of texels differs from `width` × `height`.
    pub fn new(width: u32, height: u32, texels: Texels) -> Self {
        let count = match &texels {
            Texels::Rgba8(t) => t.len(),
            Texels::Rgba16(t) => t.len(),
        };
        assert!(
            width > 0 && height > 0 && count == width as usize * height as usize,
            "{count} texels for {width}x{height}"
        );
        Bitmap { width, height, texels, hash: OnceLock::new(), blocks: OnceLock::new() }
    }

    /// Returns a hash of the stored texels.
    pub fn texel_hash(&self) -> &blake3::Hash {
        let bytes: &[u8] = match &self.texels {
            Texels::Rgba8(t) => bytemuck::cast_slice(t),
            Texels::Rgba16(t) => bytemuck::cast_slice(t),
        };
        self.hash.get_or_init(|| blake3::hash(bytes))
    }

    /// Returns width and height.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Returns the memory in bytes.
    pub fn bytes(&self) -> usize {
        match &self.texels {
            Texels::Rgba8(t) => t.len() * 4,
            Texels::Rgba16(t) => t.len() * 8,
        }
    }

    /// Returns the linear value of texel (x, y).
    #[inline]
    pub fn texel(&self, x: u32, y: u32, encoding: Encoding) -> [f32; 4] {
        let i = y as usize * self.width as usize + x as usize;
        match &self.texels {
            Texels::Rgba8(t) => linear8(t[i], if encoding == Encoding::Srgb { &SRGB8 } else { &LINEAR8 }),
            Texels::Rgba16(t) => linear16(t[i], encoding),
        }
    }

    /// Returns the linear values at the four crossings of two columns and two rows: `[row][column]`.
    #[inline]
    pub fn crossing(&self, columns: [u32; 2], rows: [u32; 2], encoding: Encoding) -> [[Vec4; 2]; 2] {
        match (&self.texels, encoding) {
            (Texels::Rgba8(t), Encoding::Linear) => self.four(columns, rows, |i| linear8(t[i], &LINEAR8)),
            (Texels::Rgba8(t), Encoding::Srgb) => {
                let colors = &*SRGB8;
                self.four(columns, rows, |i| linear8(t[i], colors))
            }
            (Texels::Rgba16(t), _) => self.four(columns, rows, |i| linear16(t[i], encoding)),
        }
    }

    // Written out, since `std::array::map` is not always inlined.
    #[inline(always)]
    fn four(
        &self,
        [left, right]: [u32; 2],
        [top, bottom]: [u32; 2],
        texel: impl Fn(usize) -> [f32; 4],
    ) -> [[Vec4; 2]; 2] {
        let at = |x: u32, y: u32| Vec4::from(texel(y as usize * self.width as usize + x as usize));
        [[at(left, top), at(right, top)], [at(left, bottom), at(right, bottom)]]
    }

    /// Asks for the memory that [`Bitmap::crossing`] will read.
    #[inline]
    pub fn prefetch(&self, columns: [u32; 2], rows: [u32; 2]) {
        for (y, x) in rows.into_iter().flat_map(|y| columns.map(|x| (y, x))) {
            let i = y as usize * self.width as usize + x as usize;
            match &self.texels {
                Texels::Rgba8(t) => prefetch(&t[i]),
                Texels::Rgba16(t) => prefetch(&t[i]),
            }
        }
    }

    /// Returns the stored value of texel (x, y), 8 or 16 bits per channel.
    pub(super) fn stored(&self, x: usize, y: usize) -> [u16; 4] {
        let i = y * self.width as usize + x;
        match &self.texels {
            Texels::Rgba8(t) => t[i].map(u16::from),
            Texels::Rgba16(t) => t[i],
        }
    }

    /// Decodes a stored value of this image to linear.
    pub(super) fn linear(&self, stored: [u16; 4], encoding: Encoding) -> [f32; 4] {
        match &self.texels {
            Texels::Rgba8(_) => {
                linear8(stored.map(|c| c as u8), if encoding == Encoding::Srgb { &SRGB8 } else { &LINEAR8 })
            }
            Texels::Rgba16(_) => linear16(stored, encoding),
        }
    }

    /// Returns the extremes of its blocks.
    pub(super) fn blocks(&self) -> &[Stored] {
        self.blocks.get_or_init(|| block_extremes::blocks(self.size(), |x, y| self.stored(x, y)))
    }
}
