//! Floating-point results judged by backward error: an f32 result is right if the exact function takes it, up to the
//! rounding of the result, for arguments within a few units of roundoff of the ones given.

use crate::random::Random;
use etendue::geometry::Local;

/// How far directions may be moved: known and other are rounded once when made and once when they are summed to a half
/// vector, in three components.
const ULPS: f64 = 4.0;
/// Roundings after that; each model does fewer than this many operations in a row.
const OPERATIONS: f64 = 64.0;
const NEIGHBOURS: u32 = 16;

/// The range of `f` over neighbours of two directions at relative distance 4 `epsilon`, with as much again on either
/// side since few neighbours are tried, and the roundings of the result and of terms of size `terms` that cancel in it.
/// `None` where the neighbours differ by a factor of two: directions of this precision do not resolve the lobe there.
pub fn range(
    directions: [Local<f64>; 2],
    epsilon: f64,
    terms: f64,
    f: impl Fn(Local<f64>, Local<f64>) -> f64,
) -> Option<[f64; 2]> {
    let [a, b] = directions;
    let mut random = Random::new(a.x.to_bits() ^ b.y.to_bits());
    let mut step = || ULPS * epsilon * (2.0 * random.f64() - 1.0);
    let mut moved = |w: Local<f64>| {
        let z = w.z + step();
        Local::new(w.x + step(), w.y + step(), if z * w.z > 0.0 { z } else { w.z })
    };
    let centre = f(a, b);
    let (mut low, mut high) = (centre, centre);
    for _ in 0..NEIGHBOURS {
        let value = f(moved(a), moved(b));
        (low, high) = (low.min(value), high.max(value));
    }
    let slack = (high - low) + OPERATIONS * epsilon * (high.abs() + terms);
    (high <= 2.0 * low).then_some([low - slack, high + slack])
}
