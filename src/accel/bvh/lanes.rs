//! Lanes of a vector, as the bits of a mask.

/// An iterator over the indices of the set bits, in ascending order.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lanes(u32);

impl Lanes {
    /// Returns the lanes for which a comparison holds, by its `move_mask`.
    #[inline]
    pub(super) fn of(mask: i32) -> Self {
        Lanes(mask as u32)
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
