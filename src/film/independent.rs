//! Which parts of an image are independent.

/// Independent parts of an image, which determine the noise of its estimated error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Independent {
    /// Pixels: each has its own samples.
    Pixels,
    /// Blocks of pixels: splats under a filter correlate neighbours, and seldom pixels further apart.
    Blocks,
    /// Replicates only: chains, photons or cached vertices serve the whole image.
    Replicates,
}

impl Independent {
    /// Returns the number of pixels that are pooled, of a block of `block` pixels.
    pub(super) fn together(self, block: usize) -> usize {
        match self {
            Independent::Pixels => 1,
            Independent::Blocks | Independent::Replicates => block,
        }
    }

    /// Returns the least number of replicates for an interval.
    pub(super) fn least_replicates(self) -> u32 {
        match self {
            Independent::Pixels | Independent::Blocks => 2,
            Independent::Replicates => 8,
        }
    }
}
