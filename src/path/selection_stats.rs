//! Statistics of the selection of lights.

use crate::light::Lights;
use std::time::Instant;

/// One call in this many is timed: reading the clock takes as long as a level of the light tree.
const TIMED: u64 = 64;

/// Time of the selection of lights by receiver, and sizes of cuts through light trees.
#[derive(Debug, Clone, Copy, Default)]
pub struct SelectionStats {
    calls: u64,
    timed: u64,
    /// Of the timed calls.
    seconds: f64,
    /// Number of cuts.
    pub cuts: u64,
    /// Number of groups in all of them.
    pub groups: u64,
}

impl SelectionStats {
    /// Returns the result of `select`, which is timed now and then.
    #[inline]
    pub fn time<T>(&mut self, select: impl FnOnce() -> T) -> T {
        self.calls += 1;
        if self.calls % TIMED != 1 {
            return select();
        }
        let begin = Instant::now();
        let selected = select();
        self.timed += 1;
        self.seconds += begin.elapsed().as_secs_f64();
        selected
    }

    /// Returns the result of `select`, which selects among `lights`; it is timed now and then if that is by receiver.
    #[inline]
    pub fn time_of<T>(&mut self, lights: &Lights, select: impl FnOnce() -> T) -> T {
        if lights.is_by_receiver() { self.time(select) } else { select() }
    }

    /// Counts a cut of `groups` groups.
    #[inline]
    pub fn cut(&mut self, groups: usize) {
        self.cuts += 1;
        self.groups += groups as u64;
    }

    /// Returns an estimate of the time of all calls.
    pub fn seconds(&self) -> f64 {
        if self.timed == 0 { 0.0 } else { self.seconds * (self.calls as f64 / self.timed as f64) }
    }

    /// Adds the statistics of other walks.
    pub fn absorb(&mut self, other: &SelectionStats) {
        self.calls += other.calls;
        self.timed += other.timed;
        self.seconds += other.seconds;
        self.cuts += other.cuts;
        self.groups += other.groups;
    }
}
