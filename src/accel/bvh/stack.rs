//! The stack of a traversal: children yet to be visited, with the parameters at which the ray enters their boxes.

use super::lanes::Lanes;
use super::node::WIDTH;
use arrayvec::ArrayVec;

/// Entries kept off the heap: enough for typical trees.
const SHALLOW: usize = 96;

/// A child and the parameter at which the ray enters its box. The nearer entry is the smaller one.
///
/// The bits of the parameter come first: those of floats that are not negative are ordered like the floats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Entry(u64);

impl Entry {
    #[inline]
    pub(super) fn new(enter: f32, child: u32) -> Self {
        Entry(u64::from(enter.to_bits()) << 32 | u64::from(child))
    }

    #[inline]
    pub(super) fn child(self) -> u32 {
        self.0 as u32
    }

    #[inline]
    fn enter(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }
}

/// Entries by the time of their arrival.
pub(super) struct Stack {
    /// The last ones. Not an array: its zero-initialisation takes a sixth of the time of a ray in a small scene.
    top: ArrayVec<Entry, SHALLOW>,
    /// Earlier ones, in deep trees.
    below: Vec<Entry>,
}

impl Stack {
    #[inline]
    pub(super) fn new() -> Self {
        Stack { top: ArrayVec::new(), below: Vec::new() }
    }

    /// Removes all entries.
    #[inline]
    pub(super) fn clear(&mut self) {
        self.top.clear();
        self.below.clear();
    }

    /// Pushes the entries of all `lanes`, the nearest last, except for the nearest, and returns that child.
    #[inline(always)] // a call would copy the entries through memory: a fifth of the time of a ray in a small scene
    pub(super) fn push_but_nearest(&mut self, mut lanes: Lanes, entry: impl Fn(usize) -> Entry) -> Option<u32> {
        let mut nearest = entry(lanes.next()?);
        if lanes.is_empty() {
            return Some(nearest.child());
        }
        self.make_room();
        let base = self.top.len();
        for lane in lanes {
            let other = entry(lane);
            self.insert(base, nearest.max(other));
            nearest = nearest.min(other);
        }
        Some(nearest.child())
    }

    /// Pushes the entries of all `lanes` in any order, except for one, and returns that child.
    #[inline(always)] // see push_but_nearest
    pub(super) fn push_but_one(&mut self, mut lanes: Lanes, entry: impl Fn(usize) -> Entry) -> Option<u32> {
        let first = entry(lanes.next()?);
        self.make_room();
        self.top.extend(lanes.map(entry));
        Some(first.child())
    }

    /// Inserts an entry into those from `base` on, which descend.
    #[inline]
    fn insert(&mut self, base: usize, entry: Entry) {
        let mut place = self.top.len();
        self.top.push(entry);
        while place > base && self.top[place - 1] < entry {
            self.top[place] = self.top[place - 1];
            self.top[place - 1] = entry;
            place -= 1;
        }
    }

    /// Makes room for the children of a node.
    #[inline]
    fn make_room(&mut self) {
        if self.top.remaining_capacity() < WIDTH {
            self.below.extend(self.top.drain(..));
        }
    }

    /// Returns the last child whose box the ray enters before `reach`, and removes it and the later ones.
    #[inline]
    pub(super) fn pop(&mut self, reach: f32) -> Option<u32> {
        while let Some(entry) = self.top.pop().or_else(|| self.below.pop()) {
            if entry.enter() <= reach {
                return Some(entry.child());
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// More entries than fit beside the heap, in nodes of one to eight: they return node by node, the last node first,
    /// and within a node by distance.
    #[test]
    fn entries_return_nearest_first_and_last_node_first() {
        let mut stack = Stack::new();
        let mut expected = Vec::new();
        for node in 0..100 {
            let count = 1 + node % WIDTH;
            // Distances that differ, in no order: a child is named by its own.
            let distance = |lane: usize| (5 * lane + node) % WIDTH;
            let entry = |lane| Entry::new(distance(lane) as f32, (10 * node + distance(lane)) as u32);
            let mut sorted: Vec<u32> = (0..count).map(|lane| entry(lane).child()).collect();
            sorted.sort_unstable();
            assert_eq!(stack.push_but_nearest(Lanes::of((1 << count) - 1), entry), Some(sorted[0]));
            expected.splice(0..0, sorted.into_iter().skip(1));
        }
        assert!(expected.len() > 3 * SHALLOW);
        let popped: Vec<u32> = std::iter::from_fn(|| stack.pop(f32::INFINITY)).collect();
        assert_eq!(popped, expected);
    }

    #[test]
    fn entries_beyond_the_reach_are_dropped() {
        let mut stack = Stack::new();
        let entry = |lane: usize| Entry::new(lane as f32, lane as u32);
        assert_eq!(stack.push_but_one(Lanes::of(0b1111), entry), Some(0));
        assert_eq!([2.5, 2.5, 2.5].map(|reach| stack.pop(reach)), [Some(2), Some(1), None]);
        assert_eq!(stack.push_but_one(Lanes::of(0), entry), None);
        assert_eq!(stack.push_but_nearest(Lanes::of(0), entry), None);
    }
}
