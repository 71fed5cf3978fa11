//! Groups of paths, and the points where they meet triangles, over lanes.

use super::objects::ObjectRow;
use crate::geometry::Hits;
use crate::geometry::lanes::{Meeting, clamped, point_at, rounding_at};
use crate::spectrum::Spectrum;
use etendue_lanes::{Double, Float, MOST_LANES, ROW, Vec3, for_each_bit};

/// A group of consecutive paths.
pub(super) struct Group<F: Float> {
    /// Number of the first.
    pub(super) at: usize,
    pub(super) direction: Vec3<F>,
    pub(super) beta: Spectrum<F>,
    pub(super) keys: F::Long,
    pub(super) pixels: F::Int,
}

/// Points where the paths of a group meet triangles.
pub(super) struct Points<F: Float> {
    pub(super) p: Vec3<F>,
    /// See [`crate::geometry::SurfacePoint::error`].
    pub(super) error: F,
    pub(super) ng: Vec3<F>,
    pub(super) barycentric: [F; 2],
    /// Lanes with a point; without one a triangle has no area, or lies in the plane of the ray.
    pub(super) valid: F::Mask,
    /// Lanes in which the ray passes beside the triangle, so that the backend's hit must be judged.
    pub(super) outside: F::Mask,
}

impl<F: Float> Points<F> {
    /// Recomputes the hits of a group from the triangles, as [`crate::geometry::SurfacePoint::new`] does. Lanes that have not `met`
    /// any get any values.
    #[inline(always)]
    pub(super) fn new(objects: &[ObjectRow], hits: &Hits, origin: Vec3<F>, group: &Group<F>, met: u32) -> Self {
        let corners = |lane: usize| {
            let at = group.at + lane;
            &objects[hits.objects[at] as usize].corners[hits.primitives[at] as usize]
        };
        let corners = in_lanes(met, corners);
        let [ax, ay, az, bx, by, bz, cx, cy] = F::rows(|lane| first_row(corners[lane]));
        let cz = F::from_fn(|lane| corners[lane][8]);
        let vertices = [Vec3::new(ax, ay, az), Vec3::new(bx, by, bz), Vec3::new(cx, cy, cz)];
        let (o, d) = (origin, group.direction);
        let inputs = [ax, ay, az, bx, by, bz, cx, cy, cz, o.x, o.y, o.z, d.x, d.y, d.z];
        let [u, v, nx, ny, nz, outside, finite] = F::in_double(inputs, meet);
        let zero = F::splat(0.0);
        let p = point_at(vertices, [u, v]);
        Points {
            p,
            error: rounding_at(vertices, p),
            ng: Vec3::new(nx, ny, nz),
            barycentric: [u, v],
            valid: finite.above(zero),
            outside: outside.above(zero),
        }
    }

    /// Returns the barycentric weights of `lane`.
    #[inline(always)]
    pub(super) fn weights(&self, lane: usize) -> [f32; 2] {
        [self.barycentric[0].lane(lane), self.barycentric[1].lane(lane)]
    }
}

/// Returns `of(lane)` in each of the given `lanes`, and that of the first of them in the others. Kernels read memory by
/// such tables, since calls of closures that search are not inlined into them.
#[inline(always)]
pub(super) fn in_lanes<T: Copy>(lanes: u32, of: impl Fn(usize) -> T) -> [T; MOST_LANES] {
    let mut all = [of(lanes.trailing_zeros() as usize); MOST_LANES];
    for_each_bit(lanes & (lanes - 1), |lane| all[lane] = of(lane));
    all
}

#[inline(always)]
fn first_row(corners: &[f32; 9]) -> &[f32; ROW] {
    match corners.first_chunk() {
        Some(row) => row,
        None => unreachable!("nine numbers begin with eight"),
    }
}

/// Returns barycentric weights, unit normal, whether the intersection lies outside the triangle, and whether there is
/// one.
#[inline(always)]
fn meet<D: Double>([ax, ay, az, bx, by, bz, cx, cy, cz, ox, oy, oz, dx, dy, dz]: [D; 15]) -> [D; 7] {
    let vertices = [Vec3::new(ax, ay, az), Vec3::new(bx, by, bz), Vec3::new(cx, cy, cz)];
    let meeting = Meeting::new(vertices, Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz));
    let ng = meeting.normal * (D::splat(1.0) / meeting.normal.length());
    let [u, v] = clamped([meeting.u, meeting.v]);
    let inside = meeting.outside_by().at_most(D::splat(0.0));
    let finite = meeting.inverse.abs().at_most(D::splat(f64::MAX));
    [u, v, ng.x, ng.y, ng.z, D::splat(1.0) - inside, finite]
}
