//! Stopping at an error: when the film is looked at, and at which confidence each look must speak.
//!
//! Each look at the film is a chance to be wrong, and a render that is looked at until it looks good enough stops at its
//! luckiest moment. So looks are few (whenever the number of passes has doubled) and share one level: look i, from 1, has
//! the part 6/(π² i²) of it, so that all looks there can ever be have the whole. With confidence 1 − [`LEVEL`] the error of
//! an image that stopped at its target is then below the target, as far as the tail of the samples lets anybody tell.

use crate::film::{Film, Known};
use std::f64::consts::PI;

/// Probability that a render stops although its error is above the target.
pub const LEVEL: f64 = 0.05;

/// The first look is at 2 to this many passes of every replicate: before that, denominators and tails are guesses.
const FIRST: u32 = 2;

/// What the last look at a film said.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Check {
    /// The relative mean squared error wanted.
    pub target: f64,
    /// Number of passes at the look.
    pub passes: u64,
    /// One-sided level of this look.
    pub level: f64,
    /// What the error is below, at that level.
    pub upper_limit: f64,
    /// Whether that was below the target, and the tail light enough to be believed.
    pub reached: bool,
}

/// Looks at `film`, of whose samples that is `known`, if it is time: when all replicates have the same power of two of passes.
pub fn check(film: &Film, known: impl Into<Known>, target: f64) -> Option<Check> {
    let (passes, level) = (film.passes().len(), level_at(film)?);
    let error = film.image_error(known)?;
    let upper_limit = error.upper_limit(level);
    Some(Check { target, passes, level, upper_limit, reached: upper_limit <= target && error.trust.trusted })
}

/// How many passes will do, going by `check`: the next number of a look at which the error, falling as 1/n, is below the
/// target. Good for a progress bar and nothing else.
pub(super) fn passes_needed(check: &Check) -> u64 {
    let doublings = (check.upper_limit / check.target).log2().ceil().clamp(1.0, 40.0);
    check.passes.saturating_mul(1 << doublings as u32)
}

/// The level of the look that is due at this state of the film; `None` if none is.
fn level_at(film: &Film) -> Option<f64> {
    let replicates = u64::from(film.replicates());
    let each = film.passes().len() / replicates;
    let is_due = each.is_power_of_two() && each.ilog2() >= FIRST && (0..film.replicates()).all(|r| film.passes_of(r) == each);
    is_due.then(|| level_of(u64::from(each.ilog2() - FIRST + 1)))
}

/// The level of look `i`, from 1.
fn level_of(i: u64) -> f64 {
    LEVEL * 6.0 / (PI * PI * (i * i) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Independent, Layout, PassFilm, Units};

    fn film(passes: u64) -> Film {
        let layout = Layout::new(2, 2, None, &[]);
        let mut film = Film::new(layout.clone(), 4, 0, Units { radiance: 1.0, length: 1.0 });
        (0..passes).for_each(|pass| film.commit(pass, &PassFilm::new(&layout)));
        film
    }

    #[test]
    fn looks_double_and_share_the_level() {
        let looked: Vec<u64> = (1..=128).filter(|&n| level_at(&film(n)).is_some()).collect();
        assert_eq!(looked, [16, 32, 64, 128]);
        let all: f64 = (1..1_000_000).map(level_of).sum();
        // What is left of the series after n terms is below 1/n.
        assert!(all < LEVEL && all > LEVEL - 1e-6, "{all}");
    }

    #[test]
    fn the_forecast_is_the_next_look_that_can_pass() {
        let check = |upper_limit| Check { target: 1e-3, passes: 32, level: 0.01, upper_limit, reached: false };
        assert_eq!(passes_needed(&check(1.1e-3)), 64);
        assert_eq!(passes_needed(&check(7.9e-3)), 256);
        assert!(passes_needed(&check(f64::INFINITY)) > 1 << 40);
    }

    /// Black everywhere: no error at all, which is below any target.
    #[test]
    fn an_image_without_error_is_good_enough_at_the_first_look() {
        assert!(check(&film(16), Independent::Pixels, 1e-9).unwrap().reached);
        assert!(check(&film(8), Independent::Pixels, 1e-9).is_none());
    }
}
