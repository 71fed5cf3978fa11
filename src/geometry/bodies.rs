//! Which bodies a point lies in: the medium state of a ray, a function of the place and never of the way to it.

/// Indices of the bodies that contain a point, in their order of precedence: the first has its medium there. A value of fixed size, since
/// every ray carries one; of more than [`Bodies::MOST`] bodies in one place those of the lowest precedence are forgotten.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Bodies([u32; Bodies::MOST]);

impl Bodies {
    /// How many it holds.
    pub const MOST: usize = 8;
    /// The index of no body.
    pub const NOBODY: u32 = u32::MAX;
    /// Empty space.
    pub const NONE: Bodies = Bodies([Bodies::NOBODY; Bodies::MOST]);

    /// Whether the point lies in no body.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.0[0] == Self::NOBODY
    }

    /// The body whose medium there is.
    #[inline]
    pub fn first(&self) -> Option<u32> {
        (!self.is_empty()).then_some(self.0[0])
    }

    /// Whether another body would push one out.
    pub fn is_full(&self) -> bool {
        self.0[Self::MOST - 1] != Self::NOBODY
    }

    /// On the inner side of the boundary of `body`.
    #[inline]
    #[must_use]
    pub fn with(mut self, body: u32) -> Self {
        if self.0.contains(&body) {
            return self;
        }
        let mut carried = body;
        for slot in &mut self.0 {
            if carried < *slot {
                std::mem::swap(&mut carried, slot);
            }
        }
        self
    }

    /// On the outer side of the boundary of `body`. Leaving a body that is not there (an open mesh) changes nothing.
    #[inline]
    #[must_use]
    pub fn without(mut self, body: u32) -> Self {
        if let Some(at) = self.0.iter().position(|&b| b == body) {
            self.0.copy_within(at + 1.., at);
            self.0[Self::MOST - 1] = Self::NOBODY;
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neither_order_nor_repetition_of_crossings_matters() {
        let a = Bodies::NONE.with(7).with(2).with(5).with(2);
        assert_eq!(a, Bodies::NONE.with(5).with(7).with(2));
        assert_eq!(a.first(), Some(2));
        assert_eq!(a.without(2).without(9).first(), Some(5));
        assert_eq!(a.without(5).without(2).without(7), Bodies::NONE);
    }

    #[test]
    fn the_last_in_precedence_are_forgotten_where_there_are_too_many() {
        let full = (0..8).fold(Bodies::NONE, |bodies, b| bodies.with(10 + b));
        assert!(full.is_full());
        assert_eq!(full.with(99), full);
        assert_eq!(full.with(1).without(1), full.without(17));
    }
}
