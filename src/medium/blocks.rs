//! Blocks of cells: the bounds of the density in each, and its values where they are not all the same.
//!
//! The density is linear between centres of cells, so blocks consist of *interpolation cells*, whose corners are eight
//! centres. Interpolation cell i reaches from centre i − 1 to centre i on its axis, and n cells have n + 1 of them. The
//! first and the last reach over the border of the box, where the outer values continue.
//!
//! A block of 8³ interpolation cells has 9³ corners. A lookup in it is a weighted mean of eight of these, so the least
//! and the largest corner bound all lookups in the block. Each block whose corners differ stores all of them in a
//! *brick*, and shares none with its neighbours: strides are constant and a lookup touches one short stretch of memory.
//! This takes 729/512 of the memory of its cells. Blocks of one value, mostly empty space, store no brick.

#[cfg(test)]
#[path = "blocks_tests.rs"]
mod tests;

use crate::huge_vec::HugeVec;
use glam::Vec3A;

/// Interpolation cells on each edge of a block.
pub(super) const EDGE: usize = 8;

/// Steps in a brick to the next corner in y and in z; in x it is 1.
pub(super) const ROW: usize = EDGE + 1;
pub(super) const LAYER: usize = ROW * ROW;

/// Corners of a block.
const BRICK: usize = LAYER * ROW;

/// Numbers from the first corner of an interpolation cell to its last, both included.
const WINDOW: usize = LAYER + ROW + 2;

/// The code of a block of one value is that value, whose sign bit is 0; of other blocks it is this bit and the number
/// of the brick.
const BRICK_BIT: u32 = 1 << 31;

/// A density on a grid of cells, in blocks; without a place in the scene.
#[derive(Debug)]
pub struct Blocks {
    /// Number of cells on each axis.
    cells: [usize; 3],
    /// Number of blocks on each axis.
    size: [usize; 3],
    /// What walks read of each block: see `Content`. Four bytes, so that most of them stay in the cache.
    codes: HugeVec<u32>,
    bounds: HugeVec<Bounds>,
    bricks: HugeVec<f32>,
}

/// Bounds of all lookups in a block.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Bounds {
    /// The least density in it.
    pub least: f32,
    /// The largest density in it.
    pub most: f32,
}

/// What is in a block.
#[derive(Debug, Clone, Copy)]
pub(super) enum Content<'a> {
    /// The same density everywhere.
    One(f32),
    /// The corners of its interpolation cells.
    Brick(&'a [f32]),
}

/// The eight corners of an interpolation cell, x first, then y, then z.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corners(pub [f32; 8]);

impl Blocks {
    /// Sorts `values`, finite and not negative, x first, then y, then z, into blocks.
    ///
    /// # Panics
    /// If the number of values is not the number of cells, if there are none, or if there are 2³¹ bricks.
    pub fn new(cells: [usize; 3], values: &[f32]) -> Self {
        Blocks::build(cells, values, |bounds| bounds.least < bounds.most)
    }

    /// Sorts values into blocks, and stores bricks of those whose bounds fulfil `stored`.
    fn build(cells: [usize; 3], values: &[f32], stored: impl Fn(Bounds) -> bool) -> Self {
        assert!(
            !values.is_empty() && values.len() == cells.iter().product::<usize>(),
            "{} values for {cells:?}",
            values.len()
        );
        let size = cells.map(|n| (n + 1).div_ceil(EDGE));
        let count = size.iter().product();
        let (mut codes, mut bounds) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let (mut bricks, mut brick) = (Vec::new(), Vec::with_capacity(BRICK));
        for at in positions(size) {
            brick.clear();
            collect_corners(cells, values, at, &mut brick);
            let found = Bounds::of(&brick);
            bounds.push(found);
            if stored(found) {
                let number = bricks.len() / BRICK;
                assert!(number < BRICK_BIT as usize, "{number} bricks");
                codes.push(BRICK_BIT | number as u32);
                bricks.extend_from_slice(&brick);
            } else {
                // The absolute value of −0 is 0.
                codes.push(found.most.abs().to_bits());
            }
        }
        Blocks { cells, size, codes: codes.into(), bounds: bounds.into(), bricks: bricks.into() }
    }

    /// Returns the number of cells on each axis.
    pub fn cells(&self) -> [usize; 3] {
        self.cells
    }

    /// Returns the number of blocks on each axis.
    pub(super) fn size(&self) -> [usize; 3] {
        self.size
    }

    /// Returns the largest density.
    pub fn most(&self) -> f32 {
        self.bounds.iter().fold(0.0, |most, bounds| most.max(bounds.most))
    }

    /// Returns the bytes that tell one content from another of as many cells.
    pub(crate) fn content_bytes(&self) -> [&[u8]; 2] {
        [bytemuck::cast_slice(&self.codes), bytemuck::cast_slice(&self.bricks)]
    }

    /// Returns the memory of it all in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.codes[..]) + size_of_val(&self.bounds[..]) + size_of_val(&self.bricks[..])
    }

    /// Returns the content of the block of a number, x first, then y, then z; empty beyond the last.
    #[inline]
    pub(super) fn content(&self, number: usize) -> Content<'_> {
        let code = self.codes.get(number).copied().unwrap_or(0);
        if code & BRICK_BIT == 0 {
            return Content::One(f32::from_bits(code));
        }
        let start = (code & !BRICK_BIT) as usize * BRICK;
        Content::Brick(&self.bricks[start..start + BRICK])
    }

    /// Returns the bounds of the density in the block of a number; 0 beyond the last.
    #[inline]
    pub(super) fn bounds(&self, number: usize) -> Bounds {
        self.bounds.get(number).copied().unwrap_or(Bounds { least: 0.0, most: 0.0 })
    }

    /// Returns the density in the block of a number, with these `bounds`, at the position in interpolation cells from
    /// its low corner.
    #[inline]
    pub(super) fn lookup(&self, number: usize, bounds: Bounds, local: Vec3A) -> f32 {
        let brick = match self.content(number) {
            Content::One(value) => return value,
            Content::Brick(brick) => brick,
        };
        let local = local.clamp(Vec3A::ZERO, Vec3A::splat(EDGE as f32));
        let cell = local.floor().min(Vec3A::splat((EDGE - 1) as f32));
        // The mean of eight numbers lies between them, but for rounding.
        Corners::of(brick, address(cell)).at(local - cell).clamp(bounds.least, bounds.most)
    }

    /// Returns the density at the position `s` in interpolation cells; beyond the outer centres it is that of the
    /// border.
    pub(super) fn density(&self, s: Vec3A) -> f32 {
        let (at, number) = self.around(s);
        self.lookup(number, self.bounds(number), s - at * EDGE as f32)
    }

    /// Returns the block around the position `s` in interpolation cells, or the nearest: its place on each axis, and
    /// its number.
    pub(super) fn around(&self, s: Vec3A) -> (Vec3A, usize) {
        let last = Vec3A::from_array(self.size.map(|n| (n - 1) as f32));
        let at = (s * (1.0 / EDGE as f32)).floor().clamp(Vec3A::ZERO, last);
        let [x, y, z] = at.to_array().map(|i| i as usize);
        (at, (z * self.size[1] + y) * self.size[0] + x)
    }
}

impl Bounds {
    /// Returns the least and the largest of these numbers, which are not negative.
    fn of(numbers: &[f32]) -> Self {
        let start = Bounds { least: f32::INFINITY, most: 0.0 };
        numbers.iter().fold(start, |found, &v| Bounds { least: found.least.min(v), most: found.most.max(v) })
    }
}

/// Returns the place in a brick of the first corner of an interpolation cell of whole coordinates from 0 to 7.
#[inline]
pub(super) fn address(cell: Vec3A) -> usize {
    cell.dot(Vec3A::new(1.0, ROW as f32, LAYER as f32)) as usize
}

impl Corners {
    /// Returns the corners of the interpolation cell whose first corner is at `address` in the brick.
    ///
    /// # Panics
    /// If the cell is not in the brick.
    #[inline]
    pub(super) fn of(brick: &[f32], address: usize) -> Self {
        let window = &brick[address..address + WINDOW];
        let rows = [0, ROW, LAYER, LAYER + ROW];
        Corners(std::array::from_fn(|k| window[rows[k / 2] + k % 2]))
    }

    /// Returns the density at the position `p` in the unit cube of the cell.
    #[inline]
    pub(super) fn at(&self, p: Vec3A) -> f32 {
        let c = &self.0;
        let row = |k: usize| mix(c[k], c[k + 4], p.z);
        mix(mix(row(0), row(2), p.y), mix(row(1), row(3), p.y), p.x)
    }
}

#[inline]
fn mix(a: f32, b: f32, t: f32) -> f32 {
    (b - a).mul_add(t, a)
}

/// Returns all places in a box of this size, x first, then y, then z.
fn positions([a, b, c]: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..c).flat_map(move |z| (0..b).flat_map(move |y| (0..a).map(move |x| [x, y, z])))
}

/// Appends the corners of the block at the place `at`.
fn collect_corners(cells: [usize; 3], values: &[f32], at: [usize; 3], to: &mut Vec<f32>) {
    // Corner i of all corners is centre i − 1, or the nearest.
    let centre = |axis: usize, k: usize| (at[axis] * EDGE + k).saturating_sub(1).min(cells[axis] - 1);
    for z in 0..ROW {
        for y in 0..ROW {
            let start = (centre(2, z) * cells[1] + centre(1, y)) * cells[0];
            to.extend((0..ROW).map(|x| values[start + centre(0, x)]));
        }
    }
}
