//! Four triangles side by side, and whether a ray meets them: the watertight test of [Woop13].
//!
//! Why no ray slips through an edge or a vertex: all triangles at a vertex see the same sheared coordinates, and the sign of
//! an edge function is exact for them. A difference of two rounded products has the sign of the exact difference unless the
//! rounded products are equal, because rounding is monotone; where they are equal the products are formed in f64, exactly.

use super::ray::Query;
use crate::geometry::Hit;
use glam::{DVec3, Vec3, Vec4};
use std::array::from_fn;
use std::ops::ControlFlow;

/// Triangles in a block.
pub(super) const LANES: usize = 4;

/// A triangle and its name.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corners {
    pub(super) vertices: [Vec3; 3],
    pub(super) hit: Hit,
}

/// Up to four triangles; where there are fewer the last is repeated.
pub(super) struct Block {
    /// By vertex and axis.
    vertices: [[Vec4; 3]; 3],
    objects: [u32; LANES],
    primitives: [u32; LANES],
}

impl Block {
    /// A block of one to four `triangles`.
    pub(super) fn new(triangles: &[Corners]) -> Self {
        let lanes: [Corners; LANES] = from_fn(|lane| triangles[lane.min(triangles.len() - 1)]);
        Block {
            vertices: from_fn(|v| from_fn(|k| Vec4::from_array(lanes.map(|c| c.vertices[v][k])))),
            objects: lanes.map(|c| c.hit.object),
            primitives: lanes.map(|c| c.hit.primitive),
        }
    }

    /// The triangle in `lane`, of the object `instance` if the block stands in several places.
    #[inline]
    pub(super) fn hit(&self, lane: usize, instance: Option<u32>) -> Hit {
        Hit { object: instance.unwrap_or(self.objects[lane]), primitive: self.primitives[lane] }
    }

    /// Calls `found(t, lane)` for each triangle that the ray meets at `t_min` < t ≤ `t_max`.
    #[inline]
    pub(super) fn meet(
        &self,
        query: &Query,
        t_max: f32,
        mut found: impl FnMut(f32, usize) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let [a, b, c] = from_fn(|v| self.sheared(query, v));
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let least = u.min(v).min(w);
        let most = u.max(v).max(w);
        let inside = (least.cmpge(Vec4::ZERO) | most.cmple(Vec4::ZERO)).bitmask();
        if inside == 0 {
            return ControlFlow::Continue(());
        }
        let on_edge = (u.cmpeq(Vec4::ZERO) | v.cmpeq(Vec4::ZERO) | w.cmpeq(Vec4::ZERO)).bitmask();
        let t = ((u * a[2] + v * b[2] + w * c[2]) / (u + v + w) * query.scale).to_array();
        let mut lanes = inside;
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let t = if on_edge >> lane & 1 == 0 { t[lane] } else { exactly([a, b, c], lane) * query.scale.x };
            if t > query.t_min && t <= t_max {
                found(t, lane)?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Vertex `v` of all lanes in coordinates where the ray is the z axis, z not yet scaled.
    #[inline]
    fn sheared(&self, query: &Query, v: usize) -> [Vec4; 3] {
        let [x, y, z] = from_fn(|k| self.vertices[v][query.axes[k]] - query.origin[k]);
        [x - query.shear[0] * z, y - query.shear[1] * z, z]
    }
}

/// The height at which the z axis meets one triangle whose edges are too close to it for f32; NaN if it does not.
#[cold]
fn exactly(vertices: [[Vec4; 3]; 3], lane: usize) -> f32 {
    let [a, b, c] = vertices.map(|v| DVec3::from_array(v.map(|x| f64::from(x[lane]))));
    let (u, v, w) = (c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x);
    let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
    if inside { ((u * a.z + v * b.z + w * c.z) / (u + v + w)) as f32 } else { f32::NAN }
}
