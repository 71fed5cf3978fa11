//! Selection of a cell in a strip, by the sums of the texels in the rows above and below, interpolated.

use super::{mix, next};
use crate::huge_vec::HugeVec;
use crate::sampling::warp::into_unit;
use crate::texture::RadianceMap;
use etendue_lanes::{Float, Int, MOST_LANES, prefetch};

/// Columns in a block of the two-level search: a cache line of sums.
const BLOCK: usize = 16;

/// Sums over the rows of a map.
#[derive(Debug)]
pub(super) struct Columns {
    width: usize,
    height: usize,
    /// Inclusive prefix sums over the cells of a row of centres, row by row.
    sums: HugeVec<f32>,
    /// Prefix sums at the ends of blocks of cells.
    blocks: Vec<f32>,
}

impl Columns {
    /// Returns the sums of `share` of texels, and the mean over each row.
    pub(super) fn new(map: &RadianceMap, share: impl Fn([f32; 3]) -> f64) -> (Self, Vec<f64>) {
        let [width, height] = map.size();
        let mut sums = Vec::with_capacity(width * height);
        let means = (0..height).map(|y| add_row(map.row(y), &share, &mut sums)).collect();
        let block_ends = |row: &[f32]| row.chunks(BLOCK).map(|block| block[block.len() - 1]).collect::<Vec<_>>();
        let blocks = sums.chunks(width).flat_map(block_ends).collect();
        (Columns { width, height, sums: sums.into(), blocks }, means)
    }

    /// Returns the memory held, in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.sums[..]) + size_of_val(&self.blocks[..])
    }

    /// Returns the columns of the cells at `u` in `strip`, in the row at `height` between two rows of centres, and the
    /// positions of `u` in them.
    #[inline(always)]
    pub(super) fn sample<F: Float>(&self, strip: F::Int, height: F, u: F) -> (F::Int, F) {
        let (mut blocks, mut targets) = ([0; MOST_LANES], [0.0; MOST_LANES]);
        for lane in 0..F::LANES {
            (blocks[lane], targets[lane]) = self.block(strip.lane(lane), height.lane(lane), u.lane(lane));
        }
        let (mut cells, mut rest) = ([0; MOST_LANES], [0.0; MOST_LANES]);
        for lane in 0..F::LANES {
            (cells[lane], rest[lane]) = self.cell(strip.lane(lane), height.lane(lane), targets[lane], blocks[lane]);
        }
        (F::Int::load(&cells, 0), F::load(&rest, 0))
    }

    /// Returns the rows of `table`, of `count` numbers each, above and below a strip.
    #[inline(always)]
    fn rows<'a>(&self, table: &'a [f32], count: usize, strip: u32) -> [&'a [f32]; 2] {
        super::strips::rows(strip as usize, self.height).map(|y| &table[y * count..][..count])
    }

    /// Returns the first column of the block at `u`, and the sum to look for.
    #[inline(always)]
    fn block(&self, strip: u32, h: f32, u: f32) -> (usize, f32) {
        let [above, below] = self.rows(&self.sums, self.width, strip);
        let target = u * mix(above[self.width - 1], below[self.width - 1], h);
        let first = BLOCK * first_above(target, self.rows(&self.blocks, self.width.div_ceil(BLOCK), strip), h);
        [above, below].iter().for_each(|row| prefetch(&row[first]));
        (first, target)
    }

    /// Returns the cell of the sum `target` in the block that begins at the column `first`, and the position in it.
    #[inline(always)]
    fn cell(&self, strip: u32, h: f32, target: f32, first: usize) -> (u32, f32) {
        let rows = self.rows(&self.sums, self.width, strip);
        let block = first..self.width.min(first + BLOCK);
        let cell = first + first_above(target, rows.map(|row| &row[block.clone()]), h);
        let sum = |i: usize| mix(rows[0][i], rows[1][i], h);
        let start = if cell == 0 { 0.0 } else { sum(cell - 1) };
        (cell as u32, into_unit((target - start) / (sum(cell) - start)))
    }
}

/// Appends the prefix sums of a row of texels and returns its mean. The share of a cell is the mean of its two ends; the
/// last cell lies across the seam.
fn add_row(row: &[[f32; 3]], share: impl Fn([f32; 3]) -> f64, sums: &mut Vec<f32>) -> f64 {
    let mut sum = 0.0;
    for x in 0..row.len() {
        sum += 0.5 * (share(row[x]) + share(row[next(x, row.len())]));
        sums.push(sum as f32);
    }
    sum / row.len() as f64
}

/// Returns the first index at which the interpolation of two increasing rows exceeds `target`, or the last index. A
/// linear count, not bisection: it compares eight values at once, without dependent memory accesses.
#[inline(always)]
fn first_above(target: f32, [above, below]: [&[f32]; 2], h: f32) -> usize {
    let passed: u32 = above.iter().zip(below).map(|(&a, &b)| u32::from(mix(a, b, h) <= target)).sum();
    (passed as usize).min(above.len() - 1)
}
