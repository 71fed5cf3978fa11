//! Multiple tests: control of the family-wise error, the probability that any true hypothesis is rejected.

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
