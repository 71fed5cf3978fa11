//! Boxes of cells of a grid.

/// A box of cells, from `low` up to but without `high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Region {
    pub(super) low: [i64; 3],
    pub(super) high: [i64; 3],
}

impl Region {
    pub(super) const EMPTY: Region = Region { low: [i64::MAX; 3], high: [i64::MIN; 3] };

    pub(super) fn cube(low: [i64; 3], side: i64) -> Self {
        Region { low, high: low.map(|low| low + side) }
    }

    pub(super) fn is_empty(self) -> bool {
        (0..3).any(|axis| self.low[axis] >= self.high[axis])
    }

    /// Returns the numbers of cells along the axes.
    pub(super) fn size(self) -> [u64; 3] {
        [0, 1, 2].map(|axis| self.high[axis].abs_diff(self.low[axis]))
    }

    pub(super) fn intersection(self, other: Region) -> Region {
        Region {
            low: [0, 1, 2].map(|axis| self.low[axis].max(other.low[axis])),
            high: [0, 1, 2].map(|axis| self.high[axis].min(other.high[axis])),
        }
    }

    /// Grows to contain `other` as well.
    pub(super) fn extend(&mut self, other: Region) {
        self.low = [0, 1, 2].map(|axis| self.low[axis].min(other.low[axis]));
        self.high = [0, 1, 2].map(|axis| self.high[axis].max(other.high[axis]));
    }
}
