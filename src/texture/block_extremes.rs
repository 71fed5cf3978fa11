//! Least and greatest stored values of the blocks of an image.

use rayon::prelude::*;
use std::ops::RangeInclusive;

/// Side of a block in texels.
pub(super) const BLOCK: usize = 32;

/// Least and greatest stored value.
#[derive(Clone, Copy)]
pub(super) struct Stored {
    pub(super) min: [u16; 4],
    pub(super) max: [u16; 4],
}

impl Stored {
    pub(super) const NONE: Stored = Stored { min: [u16::MAX; 4], max: [0; 4] };

    pub(super) fn holds(&self, other: &Stored) -> bool {
        (0..4).all(|c| self.min[c] <= other.min[c] && other.max[c] <= self.max[c])
    }

    pub(super) fn take(&mut self, other: &Stored) {
        for c in 0..4 {
            self.min[c] = self.min[c].min(other.min[c]);
            self.max[c] = self.max[c].max(other.max[c]);
        }
    }
}

/// Range of texels along a side.
pub(super) type Span = RangeInclusive<usize>;

/// Returns the extremes of all blocks, row by row.
pub(super) fn blocks(size: [u32; 2], stored: impl Fn(usize, usize) -> [u16; 4] + Sync) -> Box<[Stored]> {
    let [columns, rows] = size.map(|side| (side as usize).div_ceil(BLOCK));
    let block = |i: usize| scan(&stored, span(i % columns, size[0]), span(i / columns, size[1]));
    (0..columns * rows).into_par_iter().map(block).collect()
}

/// Returns the texels of block `i` along a side.
pub(super) fn span(i: usize, side: u32) -> Span {
    i * BLOCK..=(i * BLOCK + BLOCK - 1).min(side as usize - 1)
}

/// Returns the extremes of a rectangle, texel by texel.
pub(super) fn scan(stored: impl Fn(usize, usize) -> [u16; 4], columns: Span, rows: Span) -> Stored {
    let mut found = Stored::NONE;
    for y in rows {
        for x in columns.clone() {
            let texel = stored(x, y);
            found.take(&Stored { min: texel, max: texel });
        }
    }
    found
}
