//! Leaves of 8³ cells: single precision, or a code of 1 to 16 bits times a quantum plus a minimum.

use super::super::bytes::Bytes;
use super::region::Region;
use crate::error::{Error, Result};

/// Cells along an axis of a leaf, and all of them.
pub(super) const SIDE: i64 = 8;
pub(super) const CELLS: usize = 512;
/// Size of a leaf before its values.
pub(super) const HEADER: usize = 96;
/// Offsets in the header: the flags, the mask of active cells, the minimum and the quantum.
const FLAGS: usize = 15;
const MASK: usize = 16;
const MINIMUM: usize = 80;
const QUANTUM: usize = 84;
/// The three highest bits of the flags are the binary logarithm of the bits of a code, at most that of 16.
const BITS_LOG_SHIFT: u8 = 5;
const LARGEST_BITS_LOG: u8 = 4;

/// Encoding of the values of all leaves of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Encoding {
    /// Single precision.
    Float,
    /// Codes of so many bits (Fp4, Fp8, Fp16).
    Fixed(usize),
    /// Codes whose bits each leaf chooses (FpN).
    Variable,
}

impl Encoding {
    /// Returns the encoding of a grid type by its number.
    pub(super) fn of_type(kind: u32) -> Option<Self> {
        match kind {
            1 => Some(Encoding::Float),
            13 => Some(Encoding::Fixed(4)),
            14 => Some(Encoding::Fixed(8)),
            15 => Some(Encoding::Fixed(16)),
            16 => Some(Encoding::Variable),
            _ => None,
        }
    }

    /// Returns the bits of a value in the leaf with that header.
    pub(super) fn bits(self, header: Bytes<'_>) -> Result<usize> {
        match self {
            Encoding::Float => Ok(32),
            Encoding::Fixed(bits) => Ok(bits),
            Encoding::Variable => match header.0[FLAGS] >> BITS_LOG_SHIFT {
                log @ 0..=LARGEST_BITS_LOG => Ok(1 << log),
                log => Err(Error::scene(format!("a leaf of it has values of {} bits", 1 << log))),
            },
        }
    }
}

/// A leaf.
pub(super) struct Leaf<'a> {
    pub(super) encoding: Encoding,
    /// Bits of a value.
    pub(super) bits: usize,
    pub(super) header: Bytes<'a>,
    pub(super) values: Bytes<'a>,
}

/// Index in a leaf of the cell at a position of the grid; z is in the lowest bits.
pub(super) fn index(cell: [i64; 3]) -> usize {
    let [x, y, z] = cell.map(|at| (at & (SIDE - 1)) as usize);
    x << 6 | y << 3 | z
}

impl Leaf<'_> {
    /// Returns the bounding box of the active cells of a leaf whose first cell is `low`.
    pub(super) fn active(&self, low: [i64; 3]) -> Region {
        // A byte for each x and y, with a bit for each z.
        let mask = &self.header.0[MASK..MASK + CELLS / 8];
        let mut active = Region::EMPTY;
        for (xy, &z) in mask.iter().enumerate().filter(|&(_, &z)| z != 0) {
            let first = [xy as i64 / SIDE, xy as i64 % SIDE, i64::from(z.trailing_zeros())];
            let last = [first[0], first[1], i64::from(7 - z.leading_zeros())];
            active.extend(Region {
                low: [0, 1, 2].map(|axis| low[axis] + first[axis]),
                high: [0, 1, 2].map(|axis| low[axis] + last[axis] + 1),
            });
        }
        active
    }

    /// Returns the values of all cells, active or not.
    pub(super) fn values(&self) -> [f32; CELLS] {
        let bytes = self.values.0;
        if self.encoding == Encoding::Float {
            return std::array::from_fn(|i| f32::from_bits(word(bytes, i)));
        }
        let header = self.header.0;
        let [minimum, quantum] = [MINIMUM, QUANTUM].map(|at| f32::from_bits(word(&header[at..], 0)));
        std::array::from_fn(|i| {
            let bit = i * self.bits;
            let code = word(bytes, bit / 32) >> (bit % 32) & ((1 << self.bits) - 1);
            code as f32 * quantum + minimum
        })
    }
}

/// The 32-bit word `i`.
fn word(bytes: &[u8], i: usize) -> u32 {
    u32::from_le_bytes([bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2], bytes[4 * i + 3]])
}
