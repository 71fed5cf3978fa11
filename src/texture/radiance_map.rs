//! Radiance over all directions: the texels of a latitude-longitude map.

use crate::huge_vec::HugeVec;

/// Linear radiance in latitude-longitude layout, three f32 per texel. The first row is at the zenith.
pub struct RadianceMap {
    width: u32,
    height: u32,
    texels: HugeVec<[f32; 3]>,
}

/// Prints size and content hash, but not the texels.
impl std::fmt::Debug for RadianceMap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "RadianceMap({}x{} {})", self.width, self.height, self.texel_hash().to_hex())
    }
}

impl RadianceMap {
    /// Largest radiance of a texel: sums and squares of scaled values stay within the range of f32.
    pub const BRIGHTEST: f32 = 1.0e30;

    /// Returns a map of `width` × `height` texels, row by row from the zenith, linear Rec. 709.
    ///
    /// # Panics
    /// If a side is 0, the number of texels differs from `width` × `height`, or a value is not between 0 and
    /// [`RadianceMap::BRIGHTEST`].
    pub fn new(width: u32, height: u32, texels: Vec<[f32; 3]>) -> Self {
        let count = texels.len();
        assert!(
            width > 0 && height > 0 && count == width as usize * height as usize,
            "{count} texels for {width}x{height}"
        );
        assert!(texels.iter().flatten().all(|x| (0.0..=Self::BRIGHTEST).contains(x)), "a texel out of range");
        RadianceMap { width, height, texels: texels.into() }
    }

    /// Returns a hash of the texels.
    pub fn texel_hash(&self) -> blake3::Hash {
        blake3::hash(bytemuck::cast_slice(&self.texels))
    }

    /// Returns width and height.
    pub fn size(&self) -> [usize; 2] {
        [self.width as usize, self.height as usize]
    }

    /// Returns the texels of row `y`.
    #[inline]
    pub fn row(&self, y: usize) -> &[[f32; 3]] {
        let width = self.width as usize;
        &self.texels[y * width..(y + 1) * width]
    }

    /// Returns the memory in bytes.
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(&self.texels[..])
    }
}
