//! Null-collision methods: delta tracking, ratio tracking and residual ratio tracking with a majorant for each block.
//!
//! They estimate what regular tracking integrates, by lookups at tentative collisions, whose number is proportional to
//! the optical depth of the majorant and not to the number of cells. No method uses them: a flight by delta tracking
//! does not know its density, which MIS needs, and ratio tracking pays for its speed with variance
//! (docs/measurements.md). They test regular tracking.
//!
//! **Majorants.** Each block bounds all lookups in it: a lookup is a mean of eight of the corners whose extremes are
//! the bounds, positions are clamped to the block, and the result to the bounds. So no majorant is ever exceeded,
//! whatever the rounding, and no probability leaves [0, 1].
//!
//! Random numbers are uniform in [0, 1), from the caller, in an order that depends on the numbers before.

#[path = "tracking_tests.rs"]
mod tests;

use super::Grid;
use super::blocks::{Bounds, EDGE};
use super::track::{Track, Walk};
use glam::{Vec3, Vec3A};
use std::ops::ControlFlow::{self, Break, Continue};

/// Samples the collision of a flight from `origin` along the unit vector `w` in a medium of this `extinction` at
/// density 1, by delta tracking (Woodcock): returns its distance and the density there, or `None` if the flight passes
/// `length`.
pub(super) fn delta(
    grid: &Grid,
    [origin, w]: [Vec3; 2],
    length: f32,
    extinction: f32,
    mut random: impl FnMut() -> f32,
) -> Option<[f32; 2]> {
    let mut left = exponential(random());
    visit(grid, [origin, w], length, |part| {
        let majorant = extinction * part.bounds.most;
        let mut t = part.from;
        loop {
            let span = majorant * (part.to - t);
            if left >= span {
                // Exponential lengths have no memory: what is left goes on in the next block.
                left -= span;
                return Continue(());
            }
            t += left / majorant;
            let density = part.density(grid, t);
            left = exponential(random());
            if random() * part.bounds.most < density {
                return Break([part.track.start + t, density]);
            }
        }
    })
    .break_value()
}

/// Estimates the transmittance of the segment of `length` from `origin` along the unit vector `w` in a medium of this
/// `extinction` at density 1, by ratio tracking [Novák14]: without bias, between 0 and 1.
pub(super) fn ratio(grid: &Grid, ray: [Vec3; 2], length: f32, extinction: f32, random: impl FnMut() -> f32) -> f32 {
    estimate(grid, ray, length, extinction, |_| 0.0, random)
}

/// Estimates the same by residual ratio tracking [Novák14]: the least density of each block is integrated in closed
/// form, and only the rest is random. So it stays between 0 and 1, and blocks of one value add no variance.
pub(super) fn residual_ratio(
    grid: &Grid,
    ray: [Vec3; 2],
    length: f32,
    extinction: f32,
    random: impl FnMut() -> f32,
) -> f32 {
    estimate(grid, ray, length, extinction, |bounds| bounds.least, random)
}

/// Ratio tracking of the density above the control `base` of each block, which is at most its least density.
fn estimate(
    grid: &Grid,
    ray: [Vec3; 2],
    length: f32,
    extinction: f32,
    base: impl Fn(Bounds) -> f32,
    mut random: impl FnMut() -> f32,
) -> f32 {
    let (mut product, mut depth) = (1.0f32, 0.0f32);
    let mut left = exponential(random());
    let black = visit(grid, ray, length, |part| {
        let control = base(part.bounds);
        let range = part.bounds.most - control;
        depth += extinction * control * (part.to - part.from);
        let mut t = part.from;
        loop {
            let span = extinction * range * (part.to - t);
            if left >= span {
                left -= span;
                return Continue(());
            }
            t += left / (extinction * range);
            product *= (part.bounds.most - part.density(grid, t)) / range;
            if product <= 0.0 {
                return Break(());
            }
            left = exponential(random());
        }
    });
    if black.is_break() { 0.0 } else { product * (-depth).exp() }
}

/// The part of a track in a block.
struct Part {
    track: Track,
    /// The number of the block.
    number: usize,
    bounds: Bounds,
    /// The low corner of the block.
    low: Vec3A,
    /// Parameters of its ends.
    from: f32,
    to: f32,
}

impl Part {
    /// Returns the density at the parameter `t`, between the bounds of the block.
    #[inline]
    fn density(&self, grid: &Grid, t: f32) -> f32 {
        grid.blocks().lookup(self.number, self.bounds, self.track.at(t) - self.low)
    }
}

/// Visits the blocks on a segment that are not empty.
#[inline]
fn visit<B>(
    grid: &Grid,
    [origin, w]: [Vec3; 2],
    length: f32,
    mut each: impl FnMut(&Part) -> ControlFlow<B>,
) -> ControlFlow<B> {
    let Some(track) = grid.track(origin, w, length) else { return Continue(()) };
    let mut walk = Walk::<EDGE>::over(grid.blocks(), &track);
    let mut from = 0.0;
    while from < track.length {
        let to = walk.exit().min(track.length).max(from);
        let bounds = grid.blocks().bounds(walk.address);
        if bounds.most > 0.0 {
            each(&Part { track, number: walk.address, bounds, low: walk.low(&track), from, to })?;
        }
        walk.advance(&track, to);
        from = to;
    }
    Continue(())
}

/// Returns the exponential number of mean 1 for u in [0, 1).
#[inline]
fn exponential(u: f32) -> f32 {
    -(-u).ln_1p()
}
