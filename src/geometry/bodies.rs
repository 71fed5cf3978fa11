//! The bodies that contain a point: the medium state of a ray, a function of the position and not of the path.

/// The set of bodies that contain a point. Bodies are numbered by precedence. Each body has a list of the bodies of
/// lower precedence that it may overlap. A set is its first body and a bit mask over the list of that body. Every ray
/// carries a set, so its size is small and fixed. Only the owner of the lists (the scene) can add or remove bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Bodies {
    first: u32,
    others: u32,
}

impl Bodies {
    /// Index of no body.
    pub const NOBODY: u32 = u32::MAX;
    /// Empty space.
    pub const NONE: Bodies = Bodies { first: Bodies::NOBODY, others: 0 };
    /// Largest number of overlapping bodies that a set distinguishes; further ones are ignored.
    pub const MOST_OTHERS: usize = u32::BITS as usize;

    /// Returns the set of the body `first` and the bodies of its list whose bits are set in `others`.
    #[inline]
    pub const fn new(first: u32, others: u32) -> Self {
        Bodies { first, others }
    }

    /// Returns whether the point lies in no body.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.first == Self::NOBODY
    }

    /// Returns the body whose medium fills the point.
    #[inline]
    pub fn first(&self) -> Option<u32> {
        (!self.is_empty()).then_some(self.first)
    }

    /// Returns the bit mask over the list of the first body.
    #[inline]
    pub fn others(&self) -> u32 {
        self.others
    }

    /// Returns whether the set contains a body other than `body`.
    #[inline]
    pub fn has_more_than(&self, body: u32) -> bool {
        self.others != 0 || self.first != body && !self.is_empty()
    }
}
