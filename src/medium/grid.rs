//! Densities on a grid of cells, linear between their centres, and optical depths along rays.
//!
//! **Regular tracking.** Between two planes through centres of cells the density along a ray is a cubic polynomial,
//! whose integral is that of the Gauss rule of two points. So optical depths are exact up to rounding, and
//! deterministic: transmittances need no random numbers, flights no majorant, and their densities are known. Blocks of
//! one value, such as empty space, take one step; the other blocks take one step for each interpolation cell that the
//! ray crosses, which reads its eight corners once.
//!
//! Limits: values are f32.

#[cfg(test)]
#[path = "grid_tests.rs"]
mod tests;

use super::blocks::{Blocks, Content, Corners, EDGE, LAYER, ROW, address};
use super::reach::Reach;
use super::track::{Track, Walk};
use glam::{DAffine3, DVec3, Vec3, Vec3A};
use std::sync::Arc;

/// Steps by which a flight finds its end in an interval; bisection halves what Newton's method does not.
const STEPS: usize = 24;

/// Relative accuracy of the end of a flight in its interval: a few roundings of f32.
const ACCURACY: f32 = 1e-6;

/// Distance of the points of the Gauss rule from the middle of an interval, over its width: 1/√12.
const GAUSS: f32 = 0.288_675_13;

/// Densities in cells that fill a box.
#[derive(Debug)]
pub struct Grid {
    blocks: Arc<Blocks>,
    /// From the scene to cells: the centre of cell (x, y, z) is at (x + ½, y + ½, z + ½).
    to_cells: DAffine3,
    /// The largest value.
    most: f32,
}

impl Grid {
    /// Places `blocks`, which several grids may share: `to_scene` maps the unit cube that their cells fill to the scene
    /// and has an inverse.
    pub fn new(blocks: Arc<Blocks>, to_scene: &DAffine3) -> Self {
        let to_cells = DAffine3::from_scale(DVec3::from(blocks.cells().map(|n| n as f64))) * to_scene.inverse();
        let most = blocks.most();
        Grid { blocks, to_cells, most }
    }

    /// Returns the largest density.
    pub fn most(&self) -> f32 {
        self.most
    }

    /// Returns the density at the point `p`; 0 outside of the box.
    pub fn density(&self, p: Vec3) -> f32 {
        let q = self.to_cells.transform_point3(p.as_dvec3());
        let inside = (0..3).all(|axis| (0.0..=self.blocks.cells()[axis] as f64).contains(&q[axis]));
        if inside { self.blocks.density((q + 0.5).as_vec3a()) } else { 0.0 }
    }

    /// Returns the integral of the density over the segment of `length` from `origin` along the unit vector `w`.
    pub fn depth(&self, origin: Vec3, w: Vec3, length: f32) -> f32 {
        match self.fly(origin, w, length, f32::INFINITY) {
            Reach::Passes(depth) => depth,
            Reach::Ends(..) => f32::INFINITY,
        }
    }

    /// Flies from `origin` along the unit vector `w` for at most `length`, until the integral of the density is
    /// `depth`.
    pub(super) fn fly(&self, origin: Vec3, w: Vec3, length: f32, depth: f32) -> Reach {
        let Some(track) = self.track(origin, w, length) else { return Reach::Passes(0.0) };
        let mut walk = Walk::over(&self.blocks, &track);
        let (mut passed, mut from) = (0.0f32, 0.0f32);
        while from < track.length {
            // Rounding may put the first plane before the start, here and in `cross`.
            let to = walk.exit().min(track.length).max(from);
            match self.blocks.content(walk.address) {
                Content::One(value) => {
                    let sum = passed + value * (to - from);
                    if sum > depth {
                        return Reach::Ends(track.start + (from + (depth - passed) / value).min(to), value);
                    }
                    passed = sum;
                }
                Content::Brick(brick) => match cross(brick, &track, walk.low(&track), [from, to], [passed, depth]) {
                    Reach::Passes(sum) => passed = sum,
                    Reach::Ends(t, density) => return Reach::Ends(track.start + t, density),
                },
            }
            walk.advance(&track, to);
            from = to;
        }
        Reach::Passes(passed)
    }

    /// Returns the part of a segment in the box.
    #[inline]
    pub(super) fn track(&self, origin: Vec3, w: Vec3, length: f32) -> Option<Track> {
        Track::new(self.blocks.cells(), &self.to_cells, origin, w, length)
    }

    /// Returns the values.
    #[inline]
    pub fn blocks(&self) -> &Arc<Blocks> {
        &self.blocks
    }
}

/// Crosses the block with this brick and low corner between two parameters, having `passed` a part of `depth`; returns
/// what it has passed then, or the parameter of the end.
#[inline]
fn cross(brick: &[f32], track: &Track, low: Vec3A, [mut from, exit]: [f32; 2], [mut passed, depth]: [f32; 2]) -> Reach {
    let first = (track.at(from) - low).floor().clamp(Vec3A::ZERO, Vec3A::splat((EDGE - 1) as f32));
    let mut walk = Walk::<1>::new(track, low + first, address(first), [1, ROW, LAYER]);
    loop {
        let to = walk.exit().min(exit).max(from);
        let corners = Corners::of(brick, walk.address);
        let width = to - from;
        let middle = track.at(0.5 * (from + to)) - walk.low(track);
        let aside = track.along(GAUSS * width);
        let sum = passed + (0.5 * width * (corners.at(middle - aside) + corners.at(middle + aside))).max(0.0);
        if sum > depth {
            let low = walk.low(track);
            let (u, density) = end(&corners, [track.at(from) - low, track.at(to) - low], (depth - passed) / width);
            return Reach::Ends(from + u * width, density);
        }
        passed = sum;
        if to >= exit {
            return Reach::Passes(passed);
        }
        walk.advance(track, to);
        from = to;
    }
}

/// Returns where on the way between two positions in the cell the mean density so far, times the share of the way, is
/// `depth`, which is less than the mean of the whole way; and the density there.
fn end(corners: &Corners, ends: [Vec3A; 2], depth: f32) -> (f32, f32) {
    let cubic = bernstein(corners, ends.map(|p| p.clamp(Vec3A::ZERO, Vec3A::ONE)));
    let (mut low, mut high, mut u) = (0.0f32, 1.0f32, 0.5f32);
    for _ in 0..STEPS {
        let [integral, here] = evaluate(cubic, u);
        let over = integral - depth;
        if over > 0.0 {
            high = u;
        } else {
            low = u;
        }
        let next = u - over / here;
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        let found = (next - u).abs() <= ACCURACY;
        u = next;
        if found {
            break;
        }
    }
    // Rounding may lead to where there is nothing.
    (u, evaluate(cubic, u)[1].max(f32::MIN_POSITIVE))
}

/// Returns the Bernstein coefficients of the density along the segment between two positions in the cell: means of
/// densities at corners of the box around it, so none is negative.
fn bernstein(corners: &Corners, [a, b]: [Vec3A; 2]) -> [f32; 4] {
    let one = |axis: usize, p: Vec3A, q: Vec3A| {
        let mut p = p;
        p[axis] = q[axis];
        corners.at(p)
    };
    let mean = |p: Vec3A, q: Vec3A| (one(0, p, q) + one(1, p, q) + one(2, p, q)) * (1.0 / 3.0);
    [corners.at(a), mean(a, b), mean(b, a), corners.at(b)]
}

/// Returns the integral from 0 to u of the cubic polynomial with these Bernstein coefficients, and its value at u.
#[inline]
fn evaluate([a, b, c, d]: [f32; 4], u: f32) -> [f32; 2] {
    let v = 1.0 - u;
    let value = v * v * v * a + 3.0 * u * v * (v * b + u * c) + u * u * u * d;
    // The integral has the coefficients 0, a, a + b, a + b + c and a + b + c + d over 4.
    let sums = [a, a + b, a + b + c, a + b + c + d];
    let integral = u * (v * v * v * sums[0] + u * (1.5 * v * v * sums[1] + u * (v * sums[2] + 0.25 * u * sums[3])));
    [integral, value]
}
