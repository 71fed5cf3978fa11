//! Densities on a grid of cells, linear between their centres, and optical depths along rays.
//!
//! **Regular tracking.** Between two planes through centres of cells the density along a ray is a cubic polynomial, whose
//! integral is that of Simpson's rule. So optical depths are exact up to rounding, and deterministic: transmittances need
//! no random numbers, flights no majorant, and their densities are known. The price is two lookups for each plane that a
//! ray crosses. Rows of empty cells cost the planes alone.
//!
//! Limits: rays cross all planes of empty space; values are f32.

#[cfg(test)]
#[path = "grid_tests.rs"]
mod tests;

use super::varying::Reach;
use crate::huge_vec::HugeVec;
use glam::{DAffine3, Vec3};
use std::sync::Arc;

/// Steps by which a flight finds its end in an interval; bisection halves what Newton's method does not.
const STEPS: usize = 24;

/// Relative accuracy of the end of a flight in its interval: a few roundings of f32.
const ACCURACY: f32 = 1e-6;

/// Densities in cells that fill a box.
#[derive(Debug)]
pub struct Grid {
    size: [usize; 3],
    values: Arc<HugeVec<f32>>,
    /// From the scene to cells: the centre of cell (x, y, z) is at (x + ½, y + ½, z + ½).
    to_cells: DAffine3,
    /// The largest value.
    most: f32,
}

/// A ray in cells, with parameters in scene units.
#[derive(Debug, Clone, Copy)]
struct Track {
    origin: Vec3,
    direction: Vec3,
}

impl Grid {
    /// Creates the grid of `values`, finite and not negative, x first, then y, then z; `to_scene` maps the unit cube that
    /// its cells fill to the scene and has an inverse.
    ///
    /// # Panics
    /// If the number of values is not the number of cells, or there are none.
    pub fn new(size: [usize; 3], values: Arc<HugeVec<f32>>, to_scene: &DAffine3) -> Self {
        assert!(
            !values.is_empty() && values.len() == size.iter().product::<usize>(),
            "{} values for {size:?}",
            values.len()
        );
        let most = values.iter().copied().fold(0.0, f32::max);
        let to_cells = DAffine3::from_scale(glam::DVec3::from(size.map(|n| n as f64))) * to_scene.inverse();
        Grid { size, values, to_cells, most }
    }

    /// Returns the largest density.
    pub fn most(&self) -> f32 {
        self.most
    }

    /// Returns the memory of the values, which copies share, in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.values[..])
    }

    /// Returns the density at the point `p`; 0 outside of the box.
    pub fn density(&self, p: Vec3) -> f32 {
        let q = self.to_cells.transform_point3(p.as_dvec3()).as_vec3();
        let inside = q.min_element() >= 0.0 && (0..3).all(|axis| q[axis] <= self.size[axis] as f32);
        if inside { self.lookup(q) } else { 0.0 }
    }

    /// Returns the integral of the density over the segment of `length` from `origin` along the unit vector `w`.
    pub fn depth(&self, origin: Vec3, w: Vec3, length: f32) -> f32 {
        match self.fly(origin, w, length, f32::INFINITY) {
            Reach::Passes(depth) => depth,
            Reach::Ends(..) => f32::INFINITY,
        }
    }

    /// Flies from `origin` along the unit vector `w` for at most `length`, until the integral of the density is `depth`.
    pub(super) fn fly(&self, origin: Vec3, w: Vec3, length: f32, depth: f32) -> Reach {
        let track = Track {
            origin: self.to_cells.transform_point3(origin.as_dvec3()).as_vec3(),
            direction: self.to_cells.transform_vector3(w.as_dvec3()).as_vec3(),
        };
        let Some([mut from, end]) = self.clip(&track, length) else { return Reach::Passes(0.0) };
        let (mut passed, mut before) = (0.0f32, self.lookup(track.at(from)));
        let mut planes = Planes::new(&track, from);
        while from < end {
            let to = planes.next(&track).min(end);
            let (middle, after) = (self.lookup(track.at(0.5 * (from + to))), self.lookup(track.at(to)));
            let part = simpson(to - from, [before, middle, after]);
            if passed + part > depth {
                let t = self.end(&track, [from, to], before, depth - passed);
                // Rounding may lead to where there is nothing.
                return Reach::Ends(t, self.lookup(track.at(t)).max(f32::MIN_POSITIVE));
            }
            (passed, before, from) = (passed + part, after, to);
        }
        Reach::Passes(passed)
    }

    /// Returns the part of `track` up to `length` in the box.
    fn clip(&self, track: &Track, length: f32) -> Option<[f32; 2]> {
        let (mut from, mut to) = (0.0f32, length);
        for axis in 0..3 {
            let (p, d, n) = (track.origin[axis], track.direction[axis], self.size[axis] as f32);
            if d == 0.0 {
                if !(0.0..=n).contains(&p) {
                    return None;
                }
                continue;
            }
            let (a, b) = (-p / d, (n - p) / d);
            (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
        }
        (from < to).then_some([from, to])
    }

    /// Returns the density at the position `q` in cells; beyond the outer centres it is that of the border.
    fn lookup(&self, q: Vec3) -> f32 {
        let mut low = [0; 3];
        let mut high = [0; 3];
        let mut part = [0.0; 3];
        for axis in 0..3 {
            let last = self.size[axis] - 1;
            let x = (q[axis] - 0.5).clamp(0.0, last as f32);
            low[axis] = (x as usize).min(last);
            high[axis] = (low[axis] + 1).min(last);
            part[axis] = x - low[axis] as f32;
        }
        let row = |y: usize, z: usize| {
            let start = (z * self.size[1] + y) * self.size[0];
            mix(self.values[start + low[0]], self.values[start + high[0]], part[0])
        };
        let plane = |z: usize| mix(row(low[1], z), row(high[1], z), part[1]);
        mix(plane(low[2]), plane(high[2]), part[2])
    }

    /// Returns where in an interval that begins with the density `before` its integral is `depth`, which is less than
    /// that of the whole interval.
    fn end(&self, track: &Track, [from, to]: [f32; 2], before: f32, depth: f32) -> f32 {
        let (mut low, mut high) = (from, to);
        let mut t = 0.5 * (from + to);
        for _ in 0..STEPS {
            let here = self.lookup(track.at(t));
            let over = simpson(t - from, [before, self.lookup(track.at(0.5 * (from + t))), here]) - depth;
            if over > 0.0 {
                high = t;
            } else {
                low = t;
            }
            let next = t - over / here;
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            if (next - t).abs() <= ACCURACY * (to - from) {
                return next;
            }
            t = next;
        }
        t
    }
}

impl Track {
    #[inline]
    fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}

/// The planes through centres of cells that a track crosses, one after the other.
struct Planes {
    /// Number of the next plane on each axis; plane i is at i + ½.
    next: [f32; 3],
    /// Parameter at the next plane of each axis.
    at: [f32; 3],
}

impl Planes {
    fn new(track: &Track, from: f32) -> Self {
        let p = track.at(from);
        let mut planes = Planes { next: [0.0; 3], at: [f32::INFINITY; 3] };
        for axis in 0..3 {
            let d = track.direction[axis];
            planes.next[axis] = if d > 0.0 { (p[axis] - 0.5).floor() + 1.0 } else { (p[axis] - 0.5).ceil() - 1.0 };
            planes.place(track, axis);
        }
        planes
    }

    /// Returns the parameter at the next plane.
    fn next(&mut self, track: &Track) -> f32 {
        let axis = (0..3).min_by(|&a, &b| self.at[a].total_cmp(&self.at[b])).unwrap_or(0);
        let at = self.at[axis];
        self.next[axis] += track.direction[axis].signum();
        self.place(track, axis);
        at
    }

    /// Computes the parameter from the number of the plane, so that errors do not add up.
    fn place(&mut self, track: &Track, axis: usize) {
        let d = track.direction[axis];
        self.at[axis] = if d == 0.0 { f32::INFINITY } else { (self.next[axis] + 0.5 - track.origin[axis]) / d };
    }
}

#[inline]
fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// Returns the integral over `width` of the cubic polynomial with these values at its start, middle and end.
#[inline]
fn simpson(width: f32, [a, b, c]: [f32; 3]) -> f32 {
    width * (a + 4.0 * b + c) * (1.0 / 6.0)
}
