//! Progress that a session reports to its observers.

use super::Provenance;
use crate::error::Error;
use crate::film::Film;
use std::time::Duration;

/// State of a session after a pass.
pub struct Progress<'a> {
    /// The film so far. Computing its error visits every pixel.
    pub film: &'a Film,
    /// Its provenance, with the work so far.
    pub provenance: &'a Provenance,
    /// Progress of the session.
    pub pace: Pace,
}

/// Progress of a session in passes and time.
#[derive(Debug, Clone, Copy)]
pub struct Pace {
    /// Passes rendered in this session.
    pub done: u64,
    /// Passes this session has to render, if their number is known.
    pub wanted: Option<u64>,
    /// Time since the session began.
    pub elapsed: Duration,
    /// Time limit of the session, if there is one.
    pub budget: Option<Duration>,
}

/// Observer of a session.
pub trait Observer {
    /// Called after each committed pass.
    fn pass(&mut self, progress: &Progress<'_>);

    /// Called when a checkpoint could not be saved. It will be tried again.
    fn unsaved(&mut self, error: &Error);
}

impl Pace {
    /// Returns the completed fraction, from 0 to 1.
    pub fn fraction(&self) -> f64 {
        let by_passes = self.wanted.map_or(0.0, |wanted| self.done as f64 / wanted.max(1) as f64);
        let by_time = self.budget.map_or(0.0, |budget| self.elapsed.as_secs_f64() / budget.as_secs_f64());
        by_passes.max(by_time).min(1.0)
    }

    /// Returns the completed fraction in whole per cent, rounded down, so that 100 means complete.
    pub fn percent(&self) -> u64 {
        (self.fraction() * 100.0).floor() as u64
    }

    /// Extrapolates the remaining time.
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
