//! What a session tells those who watch it.

use super::Provenance;
use crate::error::Error;
use crate::film::Film;
use std::time::Duration;

/// Where a session is after a pass.
pub struct Progress<'a> {
    /// The film so far; watchers may ask it for its error, which costs a look at every pixel.
    pub film: &'a Film,
    /// Where it comes from, with the work so far.
    pub provenance: &'a Provenance,
    /// How far it is.
    pub pace: Pace,
}

/// How far a session is.
#[derive(Debug, Clone, Copy)]
pub struct Pace {
    /// Passes rendered in this session.
    pub done: u64,
    /// Passes this session wants, unless time decides.
    pub wanted: Option<u64>,
    /// Time since the session began.
    pub elapsed: Duration,
    /// Time the session may take, if time decides.
    pub budget: Option<Duration>,
}

/// Watches a session.
pub trait Observer {
    /// A pass was committed.
    fn pass(&mut self, progress: &Progress<'_>);

    /// The film could not be saved meanwhile; it will be tried again.
    fn unsaved(&mut self, error: &Error);
}

impl Pace {
    /// How much is done, from 0 to 1.
    pub fn fraction(&self) -> f64 {
        let by_passes = self.wanted.map_or(0.0, |wanted| self.done as f64 / wanted.max(1) as f64);
        let by_time = self.budget.map_or(0.0, |budget| self.elapsed.as_secs_f64() / budget.as_secs_f64());
        by_passes.max(by_time).min(1.0)
    }

    /// The whole per cent done: floored, so that 100 means done.
    pub fn percent(&self) -> u64 {
        (self.fraction() * 100.0).floor() as u64
    }

    /// The time that is left at this pace.
    pub fn remaining(&self) -> Duration {
        let done = self.fraction();
        if done > 0.0 { self.elapsed.mul_f64((1.0 - done) / done) } else { Duration::ZERO }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percent_is_floored_and_the_rest_extrapolated() {
        let mut progress = Pace { done: 199, wanted: Some(200), elapsed: Duration::from_secs(199), budget: None };
        assert_eq!(progress.percent(), 99);
        assert!((progress.remaining().as_secs_f64() - 1.0).abs() < 1e-6);
        progress.done = 200;
        assert_eq!((progress.percent(), progress.remaining()), (100, Duration::ZERO));
        let timed = Pace { wanted: None, budget: Some(Duration::from_secs(400)), ..progress };
        assert_eq!(timed.percent(), 49);
    }
}
