//! Sets of passes. Checkpoint, resume, shard and merge are operations on these sets.

use std::fmt;
use std::ops::Range;

/// A set of pass indices, kept as sorted, disjoint, non-adjacent half-open ranges. It cannot hold the index `u64::MAX`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "Vec<(u64, u64)>", into = "Vec<(u64, u64)>")]
pub struct PassSet {
    ranges: Vec<Range<u64>>,
}

impl PassSet {
    /// Returns the empty set.
    pub fn new() -> Self {
        Self::default()
    }

    /// Inserts a pass. Returns whether it is new.
    ///
    /// # Panics
    /// If `pass` is `u64::MAX`.
    pub fn insert(&mut self, pass: u64) -> bool {
        assert!(pass < u64::MAX, "pass index out of range");
        let is_new = !self.contains(pass);
        if is_new {
            self.insert_range(pass..pass + 1);
        }
        is_new
    }

    /// Inserts all passes of a range; some may be present already.
    pub fn insert_range(&mut self, range: Range<u64>) {
        if range.is_empty() {
            return;
        }
        let first = self.ranges.partition_point(|r| r.end < range.start);
        let last = self.ranges.partition_point(|r| r.start <= range.end);
        let touched = &self.ranges[first..last];
        let start = touched.first().map_or(range.start, |r| r.start.min(range.start));
        let end = touched.last().map_or(range.end, |r| r.end.max(range.end));
        self.ranges.splice(first..last, std::iter::once(start..end));
    }

    /// Inserts all passes of another set.
    pub fn union(&mut self, other: &PassSet) {
        other.ranges.iter().cloned().for_each(|range| self.insert_range(range));
    }

    /// Returns the passes that are not in `other`.
    pub fn minus(&self, other: &PassSet) -> PassSet {
        let (mut left, mut holes) = (PassSet::new(), other.ranges.iter().peekable());
        for range in &self.ranges {
            let mut start = range.start;
            while holes.next_if(|hole| hole.end <= start).is_some() {}
            while let Some(hole) = holes.peek().filter(|hole| hole.start < range.end) {
                left.insert_range(start..hole.start.max(start));
                start = hole.end;
                if start >= range.end {
                    break;
                }
                holes.next();
            }
            left.insert_range(start..range.end.max(start));
        }
        left
    }

    /// Returns one past the last pass, 0 for the empty set.
    pub fn end(&self) -> u64 {
        self.ranges.last().map_or(0, |range| range.end)
    }

    /// Returns the first pass that is in both sets.
    pub fn first_common(&self, other: &PassSet) -> Option<u64> {
        let (mut a, mut b) = (self.ranges.iter().peekable(), other.ranges.iter().peekable());
        while let (Some(x), Some(y)) = (a.peek(), b.peek()) {
            let start = x.start.max(y.start);
            if start < x.end.min(y.end) {
                return Some(start);
            }
            if x.end <= y.end {
                a.next()
            } else {
                b.next()
            };
        }
        None
    }

    /// Returns whether the sets share a pass.
    pub fn overlaps(&self, other: &PassSet) -> bool {
        self.first_common(other).is_some()
    }

    /// Returns whether a pass is in the set.
    pub fn contains(&self, pass: u64) -> bool {
        let after = self.ranges.partition_point(|r| r.start <= pass);
        after > 0 && pass < self.ranges[after - 1].end
    }

    /// Returns the number of passes.
    pub fn len(&self) -> u64 {
        self.ranges.iter().map(|r| r.end - r.start).sum()
    }

    /// Returns whether the set is empty.
    pub fn is_empty(&self) -> bool {
        self.ranges.is_empty()
    }

    /// Returns the number of passes k with k mod `modulus` = `residue`.
    ///
    /// # Panics
    /// If `modulus` is 0.
    pub fn count_congruent(&self, residue: u64, modulus: u64) -> u64 {
        let below = |end: u64| end / modulus + u64::from(end % modulus > residue);
        if residue >= modulus { 0 } else { self.ranges.iter().map(|r| below(r.end) - below(r.start)).sum() }
    }

    /// Returns the passes in ascending order.
    pub fn iter(&self) -> impl Iterator<Item = u64> + '_ {
        self.ranges.iter().cloned().flatten()
    }

    /// Returns the ranges in ascending order.
    pub fn ranges(&self) -> &[Range<u64>] {
        &self.ranges
    }
}

impl fmt::Display for PassSet {
    /// Formats the ranges as "0-63,70"; the empty set as "none".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_empty() {
            return f.write_str("none");
        }
        for (i, range) in self.ranges.iter().enumerate() {
            let separator = if i == 0 { "" } else { "," };
            let (first, last) = (range.start, range.end - 1);
            if first == last {
                write!(f, "{separator}{first}")?
            } else {
                write!(f, "{separator}{first}-{last}")?
            };
        }
        Ok(())
    }
}

impl FromIterator<u64> for PassSet {
    fn from_iter<I: IntoIterator<Item = u64>>(passes: I) -> Self {
        let mut set = PassSet::new();
        passes.into_iter().for_each(|pass| {
            set.insert(pass);
        });
        set
    }
}

impl From<Range<u64>> for PassSet {
    fn from(range: Range<u64>) -> Self {
        let mut set = PassSet::new();
        set.insert_range(range);
        set
    }
}

impl From<PassSet> for Vec<(u64, u64)> {
    fn from(set: PassSet) -> Self {
        set.ranges.into_iter().map(|r| (r.start, r.end)).collect()
    }
}

impl TryFrom<Vec<(u64, u64)>> for PassSet {
    type Error = String;

    /// Reads half-open ranges as written to files. Fails if a range is empty, out of order or adjacent to its
    /// predecessor.
    fn try_from(pairs: Vec<(u64, u64)>) -> Result<Self, String> {
        let ranges: Vec<Range<u64>> = pairs.into_iter().map(|(start, end)| start..end).collect();
        let ordered = ranges.windows(2).all(|pair| pair[0].end < pair[1].start);
        if !ordered || ranges.iter().any(Range::is_empty) {
            return Err("pass ranges are not in ascending order".into());
        }
        Ok(PassSet { ranges })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    proptest! {
        /// Equivalence with a plain set of integers.
        #[test]
        fn behaves_as_a_set(
            spans in prop::collection::vec((0_u64..60, 0_u64..9), 0..12),
            others in prop::collection::vec(0_u64..80, 0..6),
            modulus in 1_u64..7,
        ) {
            let (mut set, mut model) = (PassSet::new(), BTreeSet::new());
            for (start, length) in spans {
                set.insert_range(start..start + length);
                model.extend(start..start + length);
            }
            for &pass in &others {
                prop_assert_eq!(set.contains(pass), model.contains(&pass));
            }
            let other: PassSet = others.iter().copied().collect();
            prop_assert_eq!(set.first_common(&other), others.iter().copied().filter(|p| model.contains(p)).min());
            let left: PassSet = model.iter().copied().filter(|p| !others.contains(p)).collect();
            prop_assert_eq!(set.minus(&other), left);
            prop_assert_eq!(set.end(), model.last().map_or(0, |last| last + 1));
            for residue in 0..=modulus {
                let count = model.iter().filter(|&&p| p % modulus == residue).count() as u64;
                prop_assert_eq!(set.count_congruent(residue, modulus), count);
            }
            set.union(&other);
            model.extend(others);
            prop_assert_eq!(set.len(), model.len() as u64);
            prop_assert!(set.iter().eq(model.iter().copied()));
            prop_assert_eq!(&model.into_iter().rev().collect::<PassSet>(), &set);
            let text = serde_json::to_string(&set).unwrap();
            prop_assert_eq!(serde_json::from_str::<PassSet>(&text).unwrap(), set);
        }
    }

    #[test]
    fn pass_set_is_printed_as_ranges() {
        let mut set: PassSet = (0..64).collect();
        assert!(set.insert(70) && !set.insert(70));
        assert_eq!(set.to_string(), "0-63,70");
        assert_eq!(PassSet::new().to_string(), "none");
    }

    #[test]
    fn refuses_disordered_ranges() {
        for text in ["[[3,2]]", "[[2,2]]", "[[0,4],[2,6]]", "[[0,4],[4,6]]", "[[5,6],[0,1]]"] {
            assert!(serde_json::from_str::<PassSet>(text).is_err(), "{text}");
        }
    }
}
