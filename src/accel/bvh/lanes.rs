//! Eight numbers in memory, and lanes as the bits of a mask.

use bytemuck::{Pod, Zeroable};
use etendue_lanes::{Float, Native};

/// Eight numbers in memory, aligned for one instruction.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C, align(32))]
pub(super) struct Row(pub(super) [f32; 8]);

impl Row {
    /// Returns the numbers as lanes.
    #[inline(always)]
    pub(super) fn load(&self) -> Native {
        Native::load(&self.0, 0)
    }

    /// Returns the numbers in `lanes`.
    #[inline(always)]
    pub(super) fn of(lanes: Native) -> Self {
        let mut row = Row([0.0; 8]);
        lanes.store(&mut row.0, 0);
        row
    }
}

/// An iterator over the indices of the set bits, in ascending order.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lanes(u32);

impl Lanes {
    /// Returns the lanes for which a comparison holds, by the bits of its mask.
    #[inline]
    pub(super) fn of(mask: u32) -> Self {
        Lanes(mask)
    }

    #[inline]
    pub(super) fn is_empty(self) -> bool {
        self.0 == 0
    }

    #[inline]
    pub(super) fn contains(self, lane: usize) -> bool {
        self.0 >> lane & 1 != 0
    }
}

impl Iterator for Lanes {
    type Item = usize;

    #[inline]
    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros();
        (self.0 != 0).then(|| {
            self.0 &= self.0 - 1;
            lane as usize
        })
    }
}
