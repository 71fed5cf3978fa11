//! Neighbouring floating-point numbers (std's `next_up` and `next_down` are newer than the minimum supported Rust
//! version).

/// Returns the least f32 above the finite number `x`.
#[inline]
pub fn next_up(x: f32) -> f32 {
    if x == 0.0 {
        f32::from_bits(1)
    } else if x > 0.0 {
        f32::from_bits(x.to_bits() + 1)
    } else {
        f32::from_bits(x.to_bits() - 1)
    }
}

/// Returns the greatest f32 below the finite number `x`.
#[inline]
pub fn next_down(x: f32) -> f32 {
    -next_up(-x)
}

/// The greatest f32 below 1.
pub const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_are_one_step_apart_and_ordered() {
        for x in [0.0, 1.0, -1.0, 1e-40, -1e-40, 3.4e38, f32::MIN_POSITIVE] {
            assert!(next_down(x) < x && x < next_up(x), "{x}");
            assert_eq!(next_down(next_up(x)), x);
        }
        assert_eq!(next_up(1.0), 1.0 + f32::EPSILON);
        assert_eq!(next_down(1.0), BELOW_ONE);
    }
}
