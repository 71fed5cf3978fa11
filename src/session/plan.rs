//! Pass plans: the total number of passes, and the share that this process renders. Pass k is one sample per pixel and
//! belongs to replicate k mod R. A total is R × a power of two, so that every replicate holds a whole block of its
//! low-discrepancy sequence.

use crate::film::PassSet;
use std::str::FromStr;
use std::time::Duration;

/// Stopping criteria of a render. It ends at the first one that is met.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct StopCriteria {
    /// Maximum samples per pixel.
    pub spp: Option<u64>,
    /// Time limit in seconds, in whole passes.
    pub seconds: Option<f64>,
    /// Target of the relative mean squared error, at the confidence that [`super::target`] states.
    pub target_error: Option<f64>,
}

impl StopCriteria {
    /// Stops after that many samples per pixel.
    pub fn after(spp: u64) -> Self {
        StopCriteria { spp: Some(spp), ..StopCriteria::default() }
    }

    /// Whether the number of passes is known in advance.
    fn is_known(&self) -> bool {
        self.seconds.is_none() && self.target_error.is_none()
    }
}

/// The share of the passes that this process renders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PassSelection {
    /// All of them.
    #[default]
    All,
    /// Those that are `index` modulo `count`.
    Shard {
        /// Index of the shard, from 0.
        index: u64,
        /// Number of shards.
        count: u64,
    },
    /// The passes `start` ≤ pass < `end`, whatever the samples per pixel.
    Range {
        /// The first pass.
        start: u64,
        /// One past the last pass.
        end: u64,
    },
}

/// Passes that a run renders.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PassPlan {
    /// Stopping criteria.
    pub stop: StopCriteria,
    /// Share of the passes that it renders.
    pub selection: PassSelection,
}

/// Returns the smallest `replicates` × 2ⁿ that is at least `spp`.
pub fn round_spp(spp: u64, replicates: u32) -> u64 {
    let replicates = u64::from(replicates.max(1));
    spp.div_ceil(replicates).next_power_of_two() * replicates
}

impl PassPlan {
    /// Returns the wanted passes in order, as an upper bound. The iterator is endless for a time budget alone, without
    /// a range.
    pub fn passes(&self) -> Box<dyn Iterator<Item = u64>> {
        let total = self.stop.spp.unwrap_or(u64::MAX);
        match self.selection {
            PassSelection::All => Box::new(0..total),
            PassSelection::Shard { index, count } => Box::new((index..total).step_by(count as usize)),
            PassSelection::Range { start, end } => Box::new(start..end),
        }
    }

    /// Returns the maximum number of wanted passes, if there is one.
    pub fn count(&self) -> Option<u64> {
        match (self.stop.spp, self.selection) {
            (_, PassSelection::Range { start, end }) => Some(end - start),
            (None, _) => None,
            (Some(n), PassSelection::All) => Some(n),
            (Some(n), PassSelection::Shard { index, count }) => Some(n.saturating_sub(index).div_ceil(count)),
        }
    }

    /// Whether `held` contains all wanted passes, if their number is known in advance.
    pub fn is_met_by(&self, held: &PassSet) -> bool {
        let is_known = self.stop.is_known() || matches!(self.selection, PassSelection::Range { .. });
        is_known && self.is_held(held)
    }

    /// Whether `held` contains the maximum of wanted passes. Numbers in films are untrusted, so that no loop runs over
    /// them.
    fn is_held(&self, held: &PassSet) -> bool {
        match (self.stop.spp, self.selection) {
            (_, PassSelection::Range { start, end }) => PassSet::from(start..end).minus(held).is_empty(),
            (None, _) => false,
            (Some(n), PassSelection::All) => PassSet::from(0..n).minus(held).is_empty(),
            (Some(n), PassSelection::Shard { index, count }) => {
                Some(held.minus(&(n..u64::MAX).into()).count_congruent(index, count)) == self.count()
            }
        }
    }

    /// Whether the plan is valid. Plans read from a file may not be.
    pub(super) fn is_sound(&self) -> bool {
        let most = u64::from(u32::MAX);
        let selects = match self.selection {
            PassSelection::All => true,
            PassSelection::Shard { index, count } => index < count && count <= most,
            PassSelection::Range { start, end } => start < end && end <= most,
        };
        let lasts = self.stop.seconds.is_none_or(|seconds| Duration::try_from_secs_f64(seconds).is_ok());
        selects && lasts && self.stop.target_error.is_none_or(f64::is_finite)
    }

    /// Whether `held` may be all wanted passes. If their number is not known in advance, any set may be.
    pub(super) fn may_be_met_by(&self, held: &PassSet) -> bool {
        !self.stop.is_known() || self.is_held(held)
    }

    /// Returns the time limit of the run, if there is one.
    pub fn budget(&self) -> Option<Duration> {
        self.stop.seconds.map(Duration::from_secs_f64)
    }

    /// Returns the number of passes of the whole picture that `held` belongs to. A time budget or an error target sets
    /// no number, so that the held passes determine it.
    pub(super) fn picture(&self, held: &PassSet, replicates: u32) -> u64 {
        let past_last = held.end();
        match (self.stop.spp, self.selection) {
            (_, PassSelection::Range { .. }) => round_spp(past_last.max(1), replicates),
            (Some(n), _) if self.stop.is_known() => n,
            _ => past_last,
        }
    }

    /// Returns the passes of the whole picture that `held` lacks. With a time budget or an error target, shards stop
    /// independently. Then every shard must have begun, and none may have gaps.
    pub(super) fn missing(&self, held: &PassSet, replicates: u32) -> PassSet {
        let mut wanted = PassSet::new();
        match self.selection {
            PassSelection::Shard { count, .. } if !self.stop.is_known() => {
                wanted.insert_range(0..count);
                let before = held
                    .ranges()
                    .iter()
                    .map(|range| range.start.saturating_sub(count)..range.end.saturating_sub(count));
                before.for_each(|range| wanted.insert_range(range));
            }
            _ => wanted.insert_range(0..self.picture(held, replicates)),
        }
        wanted.minus(held)
    }
}

impl FromStr for PassSelection {
    type Err = String;

    /// Parses a shard `i/n` or a range `a..b`.
    fn from_str(text: &str) -> Result<Self, String> {
        let pair = |separator: &str| {
            let (a, b) = text.split_once(separator)?;
            Some((a.trim().parse::<u64>().ok()?, b.trim().parse::<u64>().ok()?))
        };
        match (pair("/"), pair("..")) {
            (Some((index, count)), _) if index < count && count <= u64::from(u32::MAX) => {
                Ok(PassSelection::Shard { index, count })
            }
            (_, Some((start, end))) if start < end && end <= u64::from(u32::MAX) => {
                Ok(PassSelection::Range { start, end })
            }
            (Some(_), _) => Err(format!("'{text}' is not a shard: write I/N with I from 0 to N-1")),
            (_, Some(_)) => Err(format!("'{text}' is not a range of passes: write A..B with A < B")),
            _ => Err(format!("'{text}' is neither a shard I/N nor a range of passes A..B")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(stop: StopCriteria, selection: &str) -> PassPlan {
        let selection = if selection.is_empty() { PassSelection::All } else { selection.parse().unwrap() };
        PassPlan { stop, selection }
    }

    fn timed() -> StopCriteria {
        StopCriteria { seconds: Some(1.0), ..StopCriteria::default() }
    }

    #[test]
    fn spp_is_rounded_up_to_replicates_times_a_power_of_two() {
        let cases = [
            (1, 4, 4),
            (4, 4, 4),
            (5, 4, 8),
            (64, 4, 64),
            (65, 4, 128),
            (100, 4, 128),
            (7, 1, 8),
            (10, 3, 12),
            (13, 3, 24),
        ];
        for (spp, replicates, rounded) in cases {
            assert_eq!(round_spp(spp, replicates), rounded, "{spp} spp in {replicates} replicates");
        }
    }

    #[test]
    fn shards_partition_the_passes() {
        let mut all: Vec<u64> =
            (0..3).flat_map(|i| plan(StopCriteria::after(16), &format!("{i}/3")).passes()).collect();
        all.sort_unstable();
        assert_eq!(all, (0..16).collect::<Vec<_>>());
    }

    #[test]
    fn counts_agree_with_the_passes() {
        for text in ["", "0/3", "1/3", "2/3", "9/20", "19/20", "3..9"] {
            let plan = plan(StopCriteria::after(16), text);
            assert_eq!(plan.count(), Some(plan.passes().count() as u64), "{text}");
        }
        assert_eq!(plan(timed(), "").count(), None);
        assert_eq!(plan(timed(), "3..9").count(), Some(6));
    }

    /// The cost is independent of the numbers that a file claims.
    #[test]
    fn plans_are_met_by_all_their_passes_however_many() {
        for text in ["", "0/3", "2/3", "3..9"] {
            let plan = plan(StopCriteria::after(16), text);
            let all: PassSet = plan.passes().collect();
            assert!(plan.is_met_by(&all), "{text}");
            assert!(plan.passes().all(|pass| !plan.is_met_by(&all.minus(&(pass..pass + 1).into()))), "{text}");
        }
        let endless = PassSet::from(0..u64::MAX - 1);
        assert!(plan(StopCriteria::after(u64::MAX - 1), "").is_met_by(&endless));
        assert!(plan(StopCriteria::after(u64::MAX - 1), "1/3").is_met_by(&endless));
        assert!(plan(timed(), "1/3").missing(&endless, 4).is_empty());
        for (index, count) in [(0, 0), (3, 3), (0, 1 << 40)] {
            assert!(!PassPlan { stop: timed(), selection: PassSelection::Shard { index, count } }.is_sound());
        }
        assert!(
            !plan(StopCriteria { seconds: Some(-1.0), ..timed() }, "").is_sound() && plan(timed(), "1/3").is_sound()
        );
    }

    #[test]
    fn shards_and_ranges_are_read_strictly() {
        assert_eq!("0/4".parse(), Ok(PassSelection::Shard { index: 0, count: 4 }));
        assert_eq!("8..16".parse(), Ok(PassSelection::Range { start: 8, end: 16 }));
        for wrong in ["4/4", "0/0", "-1/4", "1", "", "16..8", "8..8", "a..b", "1/2/3", "0..99999999999"] {
            assert!(wrong.parse::<PassSelection>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn film_names_its_whole_image_for_any_shard() {
        let held = |passes: &[u64]| {
            let mut set = PassSet::default();
            passes.iter().for_each(|&p| {
                set.insert(p);
            });
            set
        };
        assert_eq!(plan(StopCriteria::after(64), "1/2").picture(&held(&[1, 3]), 4), 64);
        assert_eq!(plan(StopCriteria::after(64), "4..6").picture(&held(&[4, 5]), 4), 8);
        assert_eq!(plan(timed(), "").picture(&held(&[0, 1, 2, 3, 4]), 4), 5);
        let whichever_first = StopCriteria { target_error: Some(1e-3), ..StopCriteria::after(64) };
        assert_eq!(plan(whichever_first, "").picture(&held(&[0, 1, 2, 3]), 4), 4);
    }
}
