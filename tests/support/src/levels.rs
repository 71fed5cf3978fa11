//! Levels of several tests.

/// Returns the level of each of `tests` independent tests for a family-wise error of `level` [Sidak67].
pub fn sidak_level(level: f64, tests: u64) -> f64 {
    -((-level).ln_1p() / tests as f64).exp_m1()
}

#[test]
fn sidak_levels_multiply_to_the_family_level() {
    for (level, tests) in [(0.05, 1_u64), (0.01, 3), (1e-3, 1_000_000)] {
        let all_pass = tests as f64 * (-sidak_level(level, tests)).ln_1p();
        assert!((all_pass - (1.0 - level).ln()).abs() < 1e-12); // roundings of f64
    }
}
