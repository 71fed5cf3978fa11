//! Multiple tests: control of the family-wise error, the probability that any true hypothesis is rejected.

/// Returns the level of each of `tests` independent tests for a family-wise error of `level` [Sidak67].
pub fn sidak_level(level: f64, tests: u64) -> f64 {
    -((-level).ln_1p() / tests as f64).exp_m1()
}

/// Returns the family-wise p-value of the smallest of `tests` independent p-values [Sidak67].
pub fn sidak_p_value(smallest: f64, tests: u64) -> f64 {
    -((-smallest).ln_1p() * tests as f64).exp_m1()
}

/// Returns Holm's adjusted p-values, in the order given: reject those below the family-wise level. Valid under any
/// dependence; NaN counts as 1 [Holm79].
pub fn holm(p_values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|&a, &b| p_values[a].total_cmp(&p_values[b]));
    let mut adjusted = vec![1.0; p_values.len()];
    let mut so_far: f64 = 0.0;
    for (rank, &i) in order.iter().enumerate() {
        let p = if p_values[i].is_nan() { 1.0 } else { p_values[i] };
        let left = p_values.len() - rank;
        so_far = so_far.max(p * left as f64).min(1.0);
        adjusted[i] = so_far;
    }
    adjusted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sidak_levels_multiply_out() {
        for (level, tests) in [(0.05, 1_u64), (0.01, 3), (1e-3, 1_000_000)] {
            let each = sidak_level(level, tests);
            assert!((sidak_p_value(each, tests) / level - 1.0).abs() < 1e-12);
            let all_pass = tests as f64 * (-each).ln_1p();
            assert!((all_pass - (1.0 - level).ln()).abs() < 1e-12);
        }
    }

    /// Holm's own procedure on four p-values at level 0.05: two are rejected.
    #[test]
    fn holm_steps_down() {
        let adjusted = holm(&[0.01, 0.04, 0.03, 0.005]);
        for (a, b) in adjusted.iter().zip([0.03, 0.06, 0.06, 0.02]) {
            assert!((a - b).abs() < 4.0 * f64::EPSILON, "{adjusted:?}");
        }
        assert!((holm(&[f64::NAN, 0.01])[0] - 1.0).abs() < f64::EPSILON);
        assert!(holm(&[]).is_empty());
    }
}
