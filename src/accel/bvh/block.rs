//! Blocks of eight triangles, with the watertight intersection test of [Woop13].
//!
//! Watertightness: all triangles at a vertex share its sheared coordinates, and the signs of their edge functions are
//! exact. A difference of two rounded products has the sign of the exact difference unless the rounded products are
//! equal, because rounding is monotone. For equal products the computation is repeated in f64, which is exact.
//!
//! Edge functions do not give an accurate hit distance on slivers. Their rounding error, 6e-8 of the squared reach, is
//! a tenth of the area of a triangle of aspect ratio 10⁶, and a hit interpolated by them may lie anywhere along it.
//! Rays that left such triangles hit them again. If the area is small relative to reach times range of heights, the
//! plane is therefore intersected in f64. Always doing so would cost a quarter of the rendering speed.

use super::lanes::{Lanes, Row};
use super::ray::Query;
use crate::geometry::Hit;
use bytemuck::{Pod, Zeroable};
use etendue_lanes::{Float, Mask, Native};
use glam::{DVec3, Vec3};
use std::array::from_fn;
use std::ops::ControlFlow;

/// Number of triangles in a block.
pub(super) const LANES: usize = 8;

/// Edge functions determine the hit distance where reach × range of heights is at most this times their sum. Rounding
/// of a coordinate is then amplified along the ray by at most 64, as on an ordinary triangle 1 / 64 off edge-on.
const WELL_SHAPED: f32 = 64.0;

/// A triangle and its id.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corners {
    pub(super) vertices: [Vec3; 3],
    pub(super) hit: Hit,
}

/// Content of a lane without a triangle. It is never hit: comparisons with NaN are false.
const ABSENT: Corners = Corners { vertices: [Vec3::NAN; 3], hit: Hit::NONE };

/// Up to eight triangles.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Block {
    /// By vertex and axis.
    vertices: [[Row; 3]; 3],
    objects: [u32; LANES],
    primitives: [u32; LANES],
}

impl Block {
    /// Returns a block of one to eight `triangles`.
    pub(super) fn new(triangles: &[Corners]) -> Self {
        let lanes: [Corners; LANES] = from_fn(|lane| triangles.get(lane).copied().unwrap_or(ABSENT));
        Block {
            vertices: from_fn(|v| from_fn(|k| Row(lanes.map(|c| c.vertices[v][k])))),
            objects: lanes.map(|c| c.hit.object),
            primitives: lanes.map(|c| c.hit.primitive),
        }
    }

    /// Returns the id of the triangle in `lane`; `instance` is the object if the mesh is instanced.
    #[inline]
    pub(super) fn hit(&self, lane: usize, instance: Option<u32>) -> Hit {
        Hit { object: instance.unwrap_or(self.objects[lane]), primitive: self.primitives[lane] }
    }

    /// Calls `found(t, lane)` for each triangle that the ray hits at `t_min` < t ≤ `t_max`.
    #[inline]
    pub(super) fn meet(
        &self,
        query: &Query,
        t_max: f32,
        mut found: impl FnMut(f32, usize) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let [a, b, c] = from_fn(|v| self.sheared(query, v));
        let zero = Native::splat(0.0);
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let least = u.min(v).min(w);
        let most = u.max(v).max(w);
        let inside = zero.at_most(least) | most.at_most(zero);
        if !inside.any() {
            return ControlFlow::Continue(());
        }
        let on_edge = u.equals(zero) | v.equals(zero) | w.equals(zero);
        let sum = u + v + w;
        let t = (u * a[2] + v * b[2] + w * c[2]) / sum * query.scale;
        let reach = [b[0], b[1], c[0], c[1]].iter().fold(a[0].abs().max(a[1].abs()), |most, x| most.max(x.abs()));
        let range = a[2].max(b[2]).max(c[2]) - a[2].min(b[2]).min(c[2]);
        let doubtful = on_edge | (reach * range).above(sum.abs() * Native::splat(WELL_SHAPED));
        let within = t.above(Native::splat(query.t_min)) & t.at_most(Native::splat(t_max));
        let lanes = Lanes::of((inside & (doubtful | within)).bits());
        let (t, doubtful) = (Row::of(t).0, Lanes::of(doubtful.bits()));
        for lane in lanes {
            let mut at = t[lane];
            if doubtful.contains(lane) {
                match self.judge(query, [a, b, c], lane) {
                    Some(exact) if exact > query.t_min && exact <= t_max => at = exact,
                    _ => continue,
                }
            }
            found(at, lane)?;
        }
        ControlFlow::Continue(())
    }

    /// Returns the parameter of a hit whose edges or distance are in doubt in f32; `None` if the ray misses the
    /// triangle.
    #[cold]
    fn judge(&self, query: &Query, vertices: [[Native; 3]; 3], lane: usize) -> Option<f32> {
        is_inside(vertices, lane).then(|| self.parameter(query, lane))
    }

    /// Returns the parameter of the intersection with the plane of the triangle in `lane`, clamped to the range of its
    /// vertices; NaN for a ray in the plane and for a triangle without area.
    #[cold]
    fn parameter(&self, query: &Query, lane: usize) -> f32 {
        let vertex = |v: usize| {
            DVec3::from_array(from_fn(|k| {
                f64::from(self.vertices[v][query.axes[k]].0[lane]) - f64::from(query.origin[k].lane(lane))
            }))
        };
        let (a, b, c) = (vertex(0), vertex(1), vertex(2));
        let normal = (b - a).cross(c - a);
        let direction = query.direction.as_dvec3();
        let height = normal.dot(a) / normal.dot(direction) * direction.z;
        if !height.is_finite() {
            return f32::NAN;
        }
        let (least, most) = (a.z.min(b.z).min(c.z), a.z.max(b.z).max(c.z));
        (height.max(least).min(most) / direction.z) as f32
    }

    /// Returns vertex `v` of all lanes in coordinates with the ray as z axis, z not yet scaled.
    #[inline]
    fn sheared(&self, query: &Query, v: usize) -> [Native; 3] {
        let [x, y, z] = from_fn(|k| self.vertices[v][query.axes[k]].load() - query.origin[k]);
        [x - query.shear[0] * z, y - query.shear[1] * z, z]
    }
}

/// Returns whether the z axis intersects a triangle whose edges are too close to it for f32.
#[cold]
fn is_inside(vertices: [[Native; 3]; 3], lane: usize) -> bool {
    let [a, b, c] = vertices.map(|v| v.map(|x| f64::from(x.lane(lane))));
    let (u, v, w) = (c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0], b[0] * a[1] - b[1] * a[0]);
    if u == 0.0 && v == 0.0 && w == 0.0 {
        // From afar, rounding may reduce a triangle to a point, or to a segment on a line through the axis: test
        // whether it contains the axis itself.
        let spans_zero = |k: usize| a[k].min(b[k]).min(c[k]) <= 0.0 && a[k].max(b[k]).max(c[k]) >= 0.0;
        return spans_zero(0) && spans_zero(1);
    }
    (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0)
}
