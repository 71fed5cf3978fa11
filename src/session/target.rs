//! Stopping at an error target: the schedule of looks at the film, and the confidence level of each.
//!
//! Repeated looks inflate the error rate: a render that stops at the first acceptable estimate stops at a favourable
//! fluctuation. Looks are therefore few (at each doubling of the number of passes) and share one level. Look i, from 1,
//! gets the fraction 6/(π² i²), so that the fractions of all possible looks sum to one. With confidence 1 − [`LEVEL`]
//! the error of an image that stopped at its target is below the target, as far as the tail of the samples is known.

use crate::film::{Film, Known};
use std::f64::consts::PI;

/// Probability that a render stops although its error is above the target.
pub const LEVEL: f64 = 0.05;

/// The first look is at 2 to this power passes of every replicate. Before that, denominators and tails are poorly
/// known.
const FIRST: u32 = 2;

/// Result of a look at a film.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Check {
    /// Target of the relative mean squared error.
    pub target: f64,
    /// Number of passes at the look.
    pub passes: u64,
    /// One-sided level of this look.
    pub level: f64,
    /// Upper confidence limit of the error at this level.
    pub upper_limit: f64,
    /// Whether the limit is below the target and the error is trusted.
    pub reached: bool,
}

impl Check {
    /// Whether the render ends here: the target is reached, or the image is black.
    pub fn ends_render(&self) -> bool {
        self.reached || self.upper_limit <= 0.0
    }
}

/// Looks at `film` if a look is due: when all replicates have the same power of two of passes. `known` is prior
/// knowledge about its samples.
pub fn check(film: &Film, known: impl Into<Known>, target: f64) -> Option<Check> {
    let (passes, level) = (film.passes().len(), level_at(film)?);
    let error = film.image_error(known)?;
    let upper_limit = error.upper_limit(level);
    Some(Check { target, passes, level, upper_limit, reached: upper_limit <= target && error.trust.trusted })
}

/// Predicts the number of passes at the first look that can reach the target, if the error falls as 1/n from `check`.
/// It serves progress display only.
pub(super) fn passes_needed(check: &Check) -> u64 {
    let doublings = (check.upper_limit / check.target).log2().ceil().clamp(1.0, 40.0);
    check.passes.saturating_mul(1 << doublings as u32)
}

/// Level of the look that is due at this state of the film; `None` if none is.
fn level_at(film: &Film) -> Option<f64> {
    let replicates = u64::from(film.replicates());
    let each = film.passes().len() / replicates;
    let is_due =
        each.is_power_of_two() && each.ilog2() >= FIRST && (0..film.replicates()).all(|r| film.passes_of(r) == each);
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
        // The remainder of the series after n terms is below 1/n.
        assert!(all < LEVEL && all > LEVEL - 1e-6, "{all}");
    }

    #[test]
    fn the_forecast_is_the_next_look_that_can_pass() {
        let check = |upper_limit| Check { target: 1e-3, passes: 32, level: 0.01, upper_limit, reached: false };
        assert_eq!(passes_needed(&check(1.1e-3)), 64);
        assert_eq!(passes_needed(&check(7.9e-3)), 256);
        assert!(passes_needed(&check(f64::INFINITY)) > 1 << 40);
    }

    /// More samples of a black image are likely to be black as well. Its error is unknown, not small.
    #[test]
    fn a_black_image_ends_the_render_and_misses_the_target() {
        let look = check(&film(16), Independent::Pixels, 1e-9).unwrap();
        assert!(look.ends_render() && !look.reached);
        assert!(check(&film(8), Independent::Pixels, 1e-9).is_none());
    }
}
