//! Rays through blocks of interpolation cells.

use super::blocks::{Blocks, EDGE};
use glam::{DAffine3, DVec3, Vec3, Vec3A};

/// Directions below this, in cells per unit of length, count as parallel to the planes of an axis.
const PARALLEL: f32 = 1e-30;

/// The part of a ray in the box of a grid, in interpolation cells; parameters are lengths in the scene from its start.
#[derive(Debug, Clone, Copy)]
pub(super) struct Track {
    /// Distance of its start from the origin of the ray.
    pub start: f32,
    /// Its length.
    pub length: f32,
    origin: Vec3A,
    direction: Vec3A,
    /// The parameter at the plane p of an axis is p · inverse + offset; infinite where the ray is parallel.
    inverse: Vec3A,
    offset: Vec3A,
    /// 1 where planes are crossed upwards, else 0.
    ahead: Vec3A,
    /// Sign of the direction.
    step: Vec3A,
}

impl Track {
    /// Returns the part in the box of the segment of `length` from `origin` along the unit vector `w`, if there is one.
    pub(super) fn new(cells: [usize; 3], to_cells: &DAffine3, origin: Vec3, w: Vec3, length: f32) -> Option<Self> {
        let p = to_cells.transform_point3(origin.as_dvec3());
        let d = to_cells.transform_vector3(w.as_dvec3());
        let [from, to] = clip(cells, p, d, f64::from(length))?;
        // From here on near the box, where f32 resolves cells however far the origin is.
        let origin = (p + d * from + 0.5).as_vec3a();
        let direction = d.as_vec3a();
        let parallel = direction.abs().cmplt(Vec3A::splat(PARALLEL));
        let direction = Vec3A::select(parallel, Vec3A::ZERO, direction);
        let inverse = Vec3A::select(parallel, Vec3A::ZERO, direction.recip());
        let offset = Vec3A::select(parallel, Vec3A::INFINITY, -origin * inverse);
        let up = direction.cmpgt(Vec3A::ZERO);
        let ahead = Vec3A::select(up, Vec3A::ONE, Vec3A::ZERO);
        let step = Vec3A::select(up, Vec3A::ONE, Vec3A::NEG_ONE);
        Some(Track { start: from as f32, length: (to - from) as f32, origin, direction, inverse, offset, ahead, step })
    }

    /// Returns the position at the parameter `t`.
    #[inline]
    pub(super) fn at(&self, t: f32) -> Vec3A {
        self.direction.mul_add(Vec3A::splat(t), self.origin)
    }

    /// Returns the way of the length `t`.
    #[inline]
    pub(super) fn along(&self, t: f32) -> Vec3A {
        self.direction * t
    }

    /// Returns the sums of these steps of an address on the axes for each set of axes that are crossed at once.
    #[inline]
    fn jumps(&self, [x, y, z]: [usize; 3]) -> [usize; 8] {
        let signed = |axis: usize, n: usize| if self.ahead[axis] > 0.0 { n } else { n.wrapping_neg() };
        let [x, y, z] = [signed(0, x), signed(1, y), signed(2, z)];
        let xy = x.wrapping_add(y);
        [0, x, y, xy, z, z.wrapping_add(x), z.wrapping_add(y), z.wrapping_add(xy)]
    }
}

/// Returns the parameters of the part up to `length` in the box of `cells`.
pub(super) fn clip(cells: [usize; 3], p: DVec3, d: DVec3, length: f64) -> Option<[f64; 2]> {
    let (mut from, mut to) = (0.0f64, length);
    for axis in 0..3 {
        let (p, d, n) = (p[axis], d[axis], cells[axis] as f64);
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

/// The cells that a track crosses, one after the other: cubes of `N` interpolation cells on each edge.
///
/// Parameters follow from the numbers of planes, so errors do not add up, and walks of all N agree on common planes.
#[derive(Debug)]
pub(super) struct Walk<const N: usize> {
    /// The next plane of each axis.
    planes: Vec3A,
    /// The parameter there.
    at: Vec3A,
    /// The number of the cell; see `jumps`.
    pub address: usize,
    /// What is added to it for each set of axes.
    jumps: [usize; 8],
}

impl<const N: usize> Walk<N> {
    /// Begins a walk in the cell with this low corner and address, where steps on the axes add `strides`.
    #[inline]
    pub(super) fn new(track: &Track, low: Vec3A, address: usize, strides: [usize; 3]) -> Self {
        let planes = track.ahead.mul_add(Vec3A::splat(N as f32), low);
        let at = planes.mul_add(track.inverse, track.offset);
        Walk { planes, at, address, jumps: track.jumps(strides) }
    }

    /// Returns the parameter where the track leaves the cell.
    #[inline]
    pub(super) fn exit(&self) -> f32 {
        self.at.min_element()
    }

    /// Returns the low corner of the cell.
    #[inline]
    pub(super) fn low(&self, track: &Track) -> Vec3A {
        self.planes - track.ahead * N as f32
    }

    /// Enters the cell that begins at the parameter `exit`.
    #[inline]
    pub(super) fn advance(&mut self, track: &Track, exit: f32) {
        let crossed = self.at.cmple(Vec3A::splat(exit));
        self.planes += Vec3A::select(crossed, track.step * N as f32, Vec3A::ZERO);
        self.at = self.planes.mul_add(track.inverse, track.offset);
        self.address = self.address.wrapping_add(self.jumps[crossed.bitmask() as usize & 7]);
    }
}

impl Walk<EDGE> {
    /// Begins a walk over blocks at the start of the track.
    #[inline]
    pub(super) fn over(blocks: &Blocks, track: &Track) -> Self {
        let (at, number) = blocks.around(track.at(0.0));
        let size = blocks.size();
        Walk::new(track, at * EDGE as f32, number, [1, size[0], size[0] * size[1]])
    }
}
