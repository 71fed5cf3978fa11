//! Which bodies a point lies in: the medium state of a ray, a function of the place and never of the way to it.

/// The bodies that contain a point. Bodies are numbered by precedence; each has a list of those behind it that it shares places with, and
/// a set is its first body and a bit for each of that list. So it has a fixed and small size, since every ray carries one, and
/// only who has the lists (the scene) can add to it and take away.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Bodies {
    first: u32,
    others: u32,
}

impl Bodies {
    /// The number of no body.
    pub const NOBODY: u32 = u32::MAX;
    /// Empty space.
    pub const NONE: Bodies = Bodies { first: Bodies::NOBODY, others: 0 };
    /// Bodies that one shares places with and that are told apart; what is beyond is forgotten.
    pub const MOST_OTHERS: usize = u32::BITS as usize;

    /// The body `first`, and those of its list whose bits are set in `others`.
    #[inline]
    pub const fn new(first: u32, others: u32) -> Self {
        Bodies { first, others }
    }

    /// Whether the point lies in no body.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.first == Self::NOBODY
    }

    /// The body whose medium there is.
    #[inline]
    pub fn first(&self) -> Option<u32> {
        (!self.is_empty()).then_some(self.first)
    }

    /// Which of its first body's list it holds.
    #[inline]
    pub fn others(&self) -> u32 {
        self.others
    }

    /// Whether it holds any but `body`.
    #[inline]
    pub fn has_more_than(&self, body: u32) -> bool {
        self.others != 0 || self.first != body && !self.is_empty()
    }
}
