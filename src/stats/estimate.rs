//! An estimate with its standard error and the degrees of freedom of that error.

use super::student_quantile;

/// An estimate of an expectation.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Estimate {
    /// The estimated value.
    pub value: f64,
    /// Its estimated standard deviation.
    pub standard_error: f64,
    /// Degrees of freedom of `standard_error`; infinite where it is known.
    pub dof: f64,
}

impl Estimate {
    /// Returns the two-sided t interval, which covers the expectation with probability `level` if the estimate is
    /// normal [Student08].
    ///
    /// # Panics
    /// Unless 0 < level < 1 and `dof` is positive.
    pub fn interval(&self, level: f64) -> [f64; 2] {
        let half = student_quantile(0.5 + 0.5 * level, self.dof) * self.standard_error;
        [self.value - half, self.value + half]
    }

    /// Returns its distance from `expected` in standard errors.
    pub fn sigmas(&self, expected: f64) -> f64 {
        (self.value - expected) / self.standard_error
    }

    /// Returns the 95 % interval.
    pub fn interval95(&self) -> [f64; 2] {
        self.interval(0.95)
    }
}

#[cfg(test)]
mod tests {
    use crate::stats::Moments;
    use crate::stats::test_random::Random;

    /// Of 10⁴ intervals from 4 normal values 95 % cover the true value: two-sided binomial test at level 1e-6 (4.9 σ).
    #[test]
    fn t_interval_covers_at_its_level() {
        let mut random = Random::new(1);
        let trials = 10_000;
        let hits = (0..trials)
            .filter(|_| {
                let m: Moments = (0..4).map(|_| 3.0 + random.normal()).collect();
                let [low, high] = m.estimate().unwrap().interval95();
                (low..high).contains(&3.0)
            })
            .count();
        let (n, p) = (f64::from(trials), 0.95);
        assert!((hits as f64 - n * p).abs() < 4.9 * (n * p * (1.0 - p)).sqrt(), "{hits} of {trials}");
    }
}
