//! The tree of a grid: a root, upper nodes of 32³ children, lower nodes of 16³ children, and leaves of 8³ cells.
//!
//! Positions follow from the keys of the root and from the places of children, not from the nodes' own boxes. A tree
//! whose visited nodes have more bytes than the grid has nodes in common and is an error; so is a root with equal keys.
//! Both bound the time of a walk.

use super::super::bytes::Bytes;
use super::leaf::{self, Encoding, Leaf};
use super::region::Region;
use crate::error::{Error, Result};

/// Offset of the tree in a grid.
const TREE: usize = 672;
/// Size of the root and of one of its tiles.
const ROOT: usize = 64;
const ROOT_TILE: usize = 32;
/// Binary logarithm of the cells along a tile of the root.
const ROOT_TILE_LOG: u32 = 12;
/// Bits of an axis in a key of the root, and those of them that are used.
const KEY_BITS: u32 = 21;
const USED_KEY_BITS: u32 = 32 - ROOT_TILE_LOG;
/// Offset of the mask of active tiles in an inner node.
const VALUE_MASK: usize = 32;

/// Layout of an inner node.
struct Level {
    /// Binary logarithm of the children along an axis.
    log: u32,
    /// Binary logarithm of the cells along a child.
    child_log: u32,
    size: usize,
    /// Offset of the table of tiles and children.
    table: usize,
    /// The level of the children, unless they are leaves.
    below: Option<&'static Level>,
}

const LOWER: Level = Level { log: 4, child_log: 3, size: 33_856, table: 1_088, below: None };
const UPPER: Level = Level { log: 5, child_log: 7, size: 270_400, table: 8_256, below: Some(&LOWER) };

/// What fills a region.
pub(super) enum Content<'a> {
    /// One value.
    Tile { value: f32, is_active: bool },
    /// A value for each cell.
    Leaf(Leaf<'a>),
}

/// The tree of a grid.
pub(super) struct Tree<'a> {
    grid: Bytes<'a>,
    /// Offset of the root.
    root: usize,
    /// The number of the root's tiles, which follow it.
    tiles: usize,
    encoding: Encoding,
    /// The value of cells that are in no node.
    pub(super) background: f32,
}

impl<'a> Tree<'a> {
    pub(super) fn new(grid: Bytes<'a>, encoding: Encoding) -> Result<Self> {
        let root = TREE.checked_add(grid.length(TREE + 24)?).ok_or_else(misplaced)?;
        let header = grid.part(root, ROOT)?;
        let tiles = header.u32(24)? as usize;
        grid.part(root + ROOT, tiles.saturating_mul(ROOT_TILE))?;
        let tree = Tree { grid, root, tiles, encoding, background: header.f32(28)? };
        let mut keys = tree.root_tiles().map(|at| grid.u64(at)).collect::<Result<Vec<_>>>()?;
        keys.sort_unstable();
        if keys.windows(2).any(|pair| pair[0] == pair[1]) {
            return Err(Error::scene("its root has two tiles at one place"));
        }
        Ok(tree)
    }

    /// Calls `each` with all leaves and tiles, but not with inactive tiles of the background. Regions do not overlap.
    pub(super) fn visit(&self, each: &mut dyn FnMut(Region, Content<'a>)) -> Result<()> {
        let mut walk = Walk { tree: self, left: self.grid.len(), each };
        for tile in self.root_tiles() {
            let low = position(self.grid.u64(tile)?)?;
            match self.grid.i64(tile + 8)? {
                0 => {
                    let (value, is_active) = (self.grid.f32(tile + 20)?, self.grid.u32(tile + 16)? != 0);
                    walk.tile(Region::cube(low, 1 << ROOT_TILE_LOG), value, is_active);
                }
                child => walk.node(displaced(self.root, child)?, &UPPER, low)?,
            }
        }
        Ok(())
    }

    /// The offsets of the root's tiles.
    fn root_tiles(&self) -> impl Iterator<Item = usize> + use<> {
        let first = self.root + ROOT;
        (0..self.tiles).map(move |i| first + i * ROOT_TILE)
    }
}

/// The first cell of a root tile by its key, which has x in the highest bits.
fn position(key: u64) -> Result<[i64; 3]> {
    let axes = [key >> (2 * KEY_BITS), key >> KEY_BITS & ((1 << KEY_BITS) - 1), key & ((1 << KEY_BITS) - 1)];
    if axes.iter().any(|&axis| axis >> USED_KEY_BITS != 0) {
        return Err(Error::scene(format!("its root has the invalid key {key:#x}")));
    }
    Ok(axes.map(|axis| i64::from(((axis as u32) << ROOT_TILE_LOG) as i32)))
}

/// The offset of a node that is `by` bytes after the one at `at`.
fn displaced(at: usize, by: i64) -> Result<usize> {
    i64::try_from(at).ok().and_then(|at| at.checked_add(by)).and_then(|at| at.try_into().ok()).ok_or_else(misplaced)
}

fn misplaced() -> Error {
    Error::scene("a node of its tree is outside of the grid")
}

/// A walk through the tree.
struct Walk<'t, 'a, 'f> {
    tree: &'t Tree<'a>,
    /// Bytes that nodes not yet visited may have.
    left: usize,
    each: &'f mut dyn FnMut(Region, Content<'a>),
}

impl<'a> Walk<'_, 'a, '_> {
    /// Visits the inner node at an offset.
    fn node(&mut self, at: usize, level: &Level, low: [i64; 3]) -> Result<()> {
        let node = self.part(at, level.size)?;
        let children = 1 << (3 * level.log);
        let bit = |mask: usize, n: usize| node.0[mask + n / 8] >> (n % 8) & 1 != 0;
        for n in 0..children {
            let place = child_place(level, low, n);
            let entry = level.table + n * 8;
            if bit(VALUE_MASK + children / 8, n) {
                let child = displaced(at, node.i64(entry)?)?;
                match level.below {
                    Some(below) => self.node(child, below, place)?,
                    None => self.leaf(child, place)?,
                }
            } else {
                self.tile(Region::cube(place, 1 << level.child_log), node.f32(entry)?, bit(VALUE_MASK, n));
            }
        }
        Ok(())
    }

    fn leaf(&mut self, at: usize, low: [i64; 3]) -> Result<()> {
        let (encoding, header) = (self.tree.encoding, self.part(at, leaf::HEADER)?);
        let bits = encoding.bits(header)?;
        let values = self.part(at + leaf::HEADER, leaf::CELLS * bits / 8)?;
        (self.each)(Region::cube(low, leaf::SIDE), Content::Leaf(Leaf { encoding, bits, header, values }));
        Ok(())
    }

    fn tile(&mut self, region: Region, value: f32, is_active: bool) {
        if is_active || value.to_bits() != self.tree.background.to_bits() {
            (self.each)(region, Content::Tile { value, is_active });
        }
    }

    /// Returns a part of the grid, at most as often as there are bytes.
    fn part(&mut self, at: usize, size: usize) -> Result<Bytes<'a>> {
        let part = self.tree.grid.part(at, size).map_err(|_| misplaced())?;
        let left = self.left.checked_sub(size);
        self.left = left.ok_or_else(|| Error::scene("nodes of its tree have bytes in common"))?;
        Ok(part)
    }
}

/// The first cell of child `n`; z is in the lowest bits of `n`.
fn child_place(level: &Level, low: [i64; 3], n: usize) -> [i64; 3] {
    let along = |axis: u32| (n >> ((2 - axis) * level.log) & ((1 << level.log) - 1)) as i64;
    [0, 1, 2].map(|axis| low[axis as usize] + (along(axis) << level.child_log))
}
