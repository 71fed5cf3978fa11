//! A ray prepared for the two tests: slabs for boxes, a shear for triangles.
//!
//! The triangle test transforms vertices so that the ray is the z axis. With u = 2⁻²⁴, M the largest |vertex − origin|
//! of any coordinate and shear factors of at most 1, a sheared coordinate has an error of at most 6uM: u·M for each of
//! the two differences, 2u·M for the product, 2u·M for the last difference. A box test rounds a difference, a
//! reciprocal and a product, 3uM, and the widened origin, uM. Widening every slab by 16uM is therefore conservative: no
//! box is missed that contains a triangle accepted by the triangle test. The widening is applied to the ray's origin
//! instead of the boxes, at no cost.

use crate::geometry::Ray;
use etendue_lanes::{Float, Native};
use glam::Vec3;

/// Lower bound of direction components in magnitude, so that no reciprocal overflows.
const LEAST: f32 = 1e-37;

/// Widening of slabs, in half-ulps: see the module documentation.
const WIDENING: f32 = 16.0 * 0.5 * f32::EPSILON;

/// A ray prepared for box tests.
pub(super) struct Slabs {
    /// By axis: index in `Node::planes[k]` of the near plane of a box.
    pub(super) near: [usize; 3],
    pub(super) near_origin: [Native; 3],
    pub(super) far_origin: [Native; 3],
    pub(super) inverse: [Native; 3],
    pub(super) t_min: Native,
}

impl Slabs {
    /// Prepares a ray for boxes with coordinates of at most `extent`.
    #[inline]
    pub(super) fn new(ray: &Ray, extent: f32) -> Self {
        let pad = (ray.origin.abs().max_element() + extent) * WIDENING;
        let d = ray.direction.to_array().map(|d: f32| if d.abs() < LEAST { LEAST.copysign(d) } else { d });
        let origin = ray.origin.to_array();
        let shifted = |sign: f32| [0, 1, 2].map(|k| Native::splat(origin[k] + pad.copysign(sign * d[k])));
        Slabs {
            near: [0, 1, 2].map(|k| usize::from(d[k] < 0.0)),
            near_origin: shifted(1.0),
            far_origin: shifted(-1.0),
            inverse: d.map(|d| Native::splat(d.recip())),
            t_min: Native::splat(ray.t_min),
        }
    }
}

/// A ray prepared for triangle tests [Woop13].
pub(super) struct Query {
    /// Permutation of the axes that keeps handedness, with the direction's largest component last.
    pub(super) axes: [usize; 3],
    /// Permuted origin.
    pub(super) origin: [Native; 3],
    /// d_x / d_z and d_y / d_z.
    pub(super) shear: [Native; 2],
    /// 1 / d_z.
    pub(super) scale: Native,
    /// Permuted direction.
    pub(super) direction: Vec3,
    pub(super) t_min: f32,
}

impl Query {
    #[inline]
    pub(super) fn new(ray: &Ray) -> Self {
        let z = largest(ray.direction.abs());
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        let [dx, dy, dz] = axes.map(|k| ray.direction[k]);
        let origin = axes.map(|k| Native::splat(ray.origin[k]));
        Query {
            axes,
            origin,
            shear: [Native::splat(dx / dz), Native::splat(dy / dz)],
            scale: Native::splat(dz.recip()),
            direction: Vec3::new(dx, dy, dz),
            t_min: ray.t_min,
        }
    }
}

#[inline]
fn largest(v: Vec3) -> usize {
    if v.x >= v.y && v.x >= v.z {
        0
    } else if v.y >= v.z {
        1
    } else {
        2
    }
}
