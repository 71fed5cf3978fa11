//! Floating-point results judged by backward error: an f32 result is right if the exact function takes it, up to the
//! rounding of the result, for arguments within a few units of roundoff of the ones given.

use crate::random::Random;
use etendue::geometry::Local;

/// How far directions may be moved: known and other are rounded once when made and once when they are summed to a half
/// vector, in three components.
pub const ULPS: f64 = 4.0;
/// Roundings after that; each model does fewer than this many operations in a row.
const OPERATIONS: f64 = 64.0;
const NEIGHBOURS: u32 = 12;

/// The range of `f` over neighbours of two directions at relative distance [`ULPS`] `epsilon`, with as much again on
/// either side since few neighbours are tried, and the rounding of the result.
pub fn range(a: Local<f64>, b: Local<f64>, epsilon: f64, f: impl Fn(Local<f64>, Local<f64>) -> f64) -> [f64; 2] {
    let mut random = Random::new(a.x.to_bits() ^ b.y.to_bits());
    let mut moved = |w: Local<f64>| {
        let mut step = || ULPS * epsilon * if random.f64() < 0.5 { -1.0 } else { 1.0 };
        Local::new(w.x + step(), w.y + step(), w.z * (1.0 + step()))
    };
    let centre = f(a, b);
    let (mut low, mut high) = (centre, centre);
    for _ in 0..NEIGHBOURS {
        let value = f(moved(a), moved(b));
        (low, high) = (low.min(value), high.max(value));
    }
    let slack = (high - low) + OPERATIONS * epsilon * high.abs();
    [low - slack, high + slack]
}
