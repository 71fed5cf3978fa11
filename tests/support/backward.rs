//! Floating-point results judged by backward error: an f32 result is right if the exact function takes it, up to the
//! rounding of the result, for arguments within a few units of roundoff of the ones given.

use etendue::geometry::Local;

/// How far directions may be moved: known and other are rounded once when made and once when they are summed to a half
/// vector, in three components.
pub(crate) const ULPS: f64 = 4.0;
/// Roundings after that; each model does fewer than this many operations in a row.
const OPERATIONS: f64 = 64.0;
/// Corners of the box of neighbours in six components.
const CORNERS: u32 = 64;

/// The range of `f` over neighbours of two directions at relative distance [`ULPS`] `epsilon`, with as much again on
/// either side since only the corners of the box of neighbours are tried, and the rounding of the result.
pub(crate) fn range(a: Local<f64>, b: Local<f64>, epsilon: f64, f: impl Fn(Local<f64>, Local<f64>) -> f64) -> [f64; 2] {
    let moved = |w: Local<f64>, corner: u32| {
        let step = |bit: u32| ULPS * epsilon * if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
        Local::new(w.x + step(0), w.y + step(1), w.z * (1.0 + step(2)))
    };
    let centre = f(a, b);
    let (mut low, mut high) = (centre, centre);
    for corner in 0..CORNERS {
        let value = f(moved(a, corner), moved(b, corner >> 3));
        (low, high) = (low.min(value), high.max(value));
    }
    let slack = (high - low) + OPERATIONS * epsilon * high.abs();
    [low - slack, high + slack]
}
