//! Interpolation between two keys [glTF20 appendix C].

use std::ops::{Add, Mul};

/// The curve between two keys. `way` is the relative time from one to the other, 0 to 1.
#[derive(Debug, Clone, Copy)]
pub(super) enum Piece<T> {
    /// Constant value.
    Constant(T),
    /// Linear interpolation; for rotations along the shortest arc.
    Line { from: T, to: T, way: f64 },
    /// Cubic with these end slopes per second, over `length` seconds.
    Cubic { from: T, leaving: T, arriving: T, to: T, way: f64, length: f64 },
}

impl<T> Piece<T> {
    /// Applies `f` to all values.
    pub(super) fn map<U>(self, f: impl Fn(T) -> U) -> Piece<U> {
        match self {
            Piece::Constant(value) => Piece::Constant(f(value)),
            Piece::Line { from, to, way } => Piece::Line { from: f(from), to: f(to), way },
            Piece::Cubic { from, leaving, arriving, to, way, length } => {
                Piece::Cubic { from: f(from), leaving: f(leaving), arriving: f(arriving), to: f(to), way, length }
            }
        }
    }
}

impl<T: Add<Output = T> + Mul<f64, Output = T>> Piece<T> {
    /// Evaluates the piece. `line` interpolates linearly and may fail.
    pub(super) fn blend(self, line: impl Fn(T, T, f64) -> Option<T>) -> Option<T> {
        match self {
            Piece::Constant(value) => Some(value),
            Piece::Line { from, to, way } => line(from, to, way),
            Piece::Cubic { from, leaving, arriving, to, way, length } => {
                let [a, b, c, d] = hermite(way);
                Some(from * a + leaving * (b * length) + arriving * (c * length) + to * d)
            }
        }
    }
}

/// Hermite basis: the weights of the first value, the first slope, the last slope and the last value.
fn hermite(t: f64) -> [f64; 4] {
    let to = t * t * (3.0 - 2.0 * t);
    [1.0 - to, t * (1.0 - t) * (1.0 - t), t * t * (t - 1.0), to]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each weight is a few products and sums of numbers up to 3.
    const ROUNDING: f64 = 16.0 * f64::EPSILON;

    fn cubic(ends: [f64; 2], slopes: [f64; 2], way: f64, length: f64) -> f64 {
        let piece = Piece::Cubic { from: ends[0], leaving: slopes[0], arriving: slopes[1], to: ends[1], way, length };
        piece.blend(|_, _, _| None).unwrap()
    }

    #[test]
    fn without_slopes_a_cubic_is_smoothstep() {
        for way in [0.0, 0.1, 0.25, 0.5, 0.8, 1.0] {
            let smooth = 3.0 * way * way - 2.0 * way * way * way;
            for length in [0.01, 1.0, 7.0] {
                assert!((cubic([2.0, 5.0], [0.0; 2], way, length) - (2.0 + 3.0 * smooth)).abs() <= 5.0 * ROUNDING);
            }
        }
    }

    /// A cubic is reproduced by its own spline: t³ − 2t² + 5 from 1 to 4 seconds, with slope 3t² − 4t.
    #[test]
    fn cubic_tangents_are_per_second() {
        let (value, slope) = (|t: f64| t * t * t - 2.0 * t * t + 5.0, |t: f64| 3.0 * t * t - 4.0 * t);
        for way in [0.0, 0.2, 0.5, 0.7, 1.0] {
            let got = cubic([1.0, 4.0].map(value), [1.0, 4.0].map(slope), way, 3.0);
            let want = value(1.0 + 3.0 * way);
            // The largest term is 37; a slope of 32 times 3 s has a weight of at most 4/27.
            assert!((got - want).abs() <= 100.0 * ROUNDING, "{way}: {got} is not {want}");
        }
    }

    #[test]
    fn linear_and_step_keys_interpolate_as_defined() {
        let line = |a: f64, b: f64, way: f64| Some(a + (b - a) * way);
        assert_eq!(Piece::Constant(3.0).blend(line), Some(3.0));
        assert_eq!(Piece::Line { from: 1.0, to: 5.0, way: 0.25 }.blend(line), Some(2.0));
        assert_eq!(Piece::Line { from: 1.0, to: 5.0, way: 0.25 }.map(|x| x * 2.0).blend(line), Some(4.0));
    }
}
