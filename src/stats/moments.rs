//! Running mean and variance by Welford's recurrence [Welford62], mergeable [Chan79]. For values that arrive one by
//! one. The last bits depend on the order of merges; use the film's integer sums where the order must not matter.

use super::Estimate;

/// Count, mean and sum of squared deviations of a series.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Moments {
    count: u64,
    mean: f64,
    squares: f64,
}

impl Moments {
    /// Returns moments of no values.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds one value.
    pub fn push(&mut self, x: f64) {
        self.count += 1;
        let delta = x - self.mean;
        self.mean += delta / self.count as f64;
        self.squares += delta * (x - self.mean);
    }

    /// Merges the moments of another series [Chan79 (2.1)].
    pub fn merge(&mut self, other: &Moments) {
        if other.count == 0 {
            return;
        }
        let (n, m) = (self.count as f64, other.count as f64);
        let delta = other.mean - self.mean;
        self.mean += delta * (m / (n + m));
        self.squares += other.squares + delta * delta * (n * m / (n + m));
        self.count += other.count;
    }

    /// Returns the number of values.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Returns the mean; 0 without values.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Returns the unbiased sample variance; `None` below two values.
    pub fn variance(&self) -> Option<f64> {
        (self.count >= 2).then(|| self.squares / (self.count - 1) as f64)
    }

    /// Returns the mean with its standard error and n − 1 degrees of freedom; `None` below two values.
    pub fn estimate(&self) -> Option<Estimate> {
        let variance = self.variance()?;
        let n = self.count as f64;
        Some(Estimate { value: self.mean, standard_error: (variance / n).sqrt(), dof: n - 1.0 })
    }
}

impl Extend<f64> for Moments {
    fn extend<I: IntoIterator<Item = f64>>(&mut self, values: I) {
        values.into_iter().for_each(|x| self.push(x));
    }
}

impl FromIterator<f64> for Moments {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut moments = Moments::new();
        moments.extend(values);
        moments
    }
}

/// Returns an unbiased estimate of the third cumulant of the mean of `values` (Fisher's k₃ over n²); 0 below three
/// values.
pub fn third_cumulant_of_mean(values: &[f64], mean: f64) -> f64 {
    let n = values.len() as f64;
    if n < 3.0 {
        return 0.0;
    }
    values.iter().map(|v| (v - mean).powi(3)).sum::<f64>() / (n * (n - 1.0) * (n - 2.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative rounding error of n Welford steps is at most about n ε κ; here n κ < 100 [Chan79 table 1].
    const ROUNDING: f64 = 100.0 * f64::EPSILON;

    #[test]
    fn mean_and_variance_of_known_values() {
        let m: Moments = [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0].into_iter().collect();
        assert!((m.mean() - 5.0).abs() < 5.0 * ROUNDING);
        assert!((m.variance().unwrap() - 32.0 / 7.0).abs() < 5.0 * ROUNDING);
        assert_eq!(Moments::new().variance(), None);
    }

    #[test]
    fn merging_equals_pushing() {
        let values: Vec<f64> = (0..20).map(|i| f64::from(i * i % 7) + 1e3).collect();
        let whole: Moments = values.iter().copied().collect();
        let mut parts: Moments = values[..6].iter().copied().collect();
        parts.merge(&Moments::new());
        parts.merge(&values[6..].iter().copied().collect());
        assert_eq!(parts.count(), whole.count());
        assert!((parts.mean() - whole.mean()).abs() < 1e3 * ROUNDING);
        assert!((parts.variance().unwrap() - whole.variance().unwrap()).abs() < 1e3 * ROUNDING);
        let mut empty = Moments::new();
        empty.merge(&whole);
        assert_eq!(empty.count(), whole.count());
    }

    /// Values 0, 0, 0, 4: k₃ = 4 Σd³ / (3 · 2) = 16, over n² = 16.
    #[test]
    fn the_third_cumulant_is_fishers() {
        assert!((third_cumulant_of_mean(&[0.0, 0.0, 0.0, 4.0], 1.0) - 1.0).abs() < 1e-12);
        assert!(third_cumulant_of_mean(&[1.0, 2.0, 3.0], 2.0).abs() < 1e-12);
    }
}
