//! Nodes of eight children, and the test of a ray with their boxes.

use super::lanes::{Lanes, Row};
use super::ray::Slabs;
use bytemuck::{Pod, Zeroable};
use etendue_lanes::{Float, Mask, Native};
use obvhs::aabb::Aabb;

/// Number of children of a node.
pub(super) const WIDTH: usize = 8;

/// Flag of a leaf child; the other bits are its index.
pub(super) const LEAF: u32 = 1 << 31;

/// Up to eight children and their boxes.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Node {
    /// By axis: the least and the greatest coordinates.
    planes: [[Row; 2]; 3],
    /// Index of a node, or of a leaf with [`LEAF`] set.
    children: [u32; WIDTH],
}

impl Node {
    /// A node without children. Only rays that are not finite enter its empty boxes. They test leaf 0 of the tree, and
    /// miss it.
    pub(super) const EMPTY: Node =
        Node { planes: [[Row([f32::INFINITY; WIDTH]), Row([f32::NEG_INFINITY; WIDTH])]; 3], children: [LEAF; WIDTH] };

    /// Sets the child in `lane`.
    pub(super) fn set(&mut self, lane: usize, bounds: &Aabb, child: u32) {
        for (k, [least, most]) in self.planes.iter_mut().enumerate() {
            least.0[lane] = bounds.min[k];
            most.0[lane] = bounds.max[k];
        }
        self.children[lane] = child;
    }

    /// Returns the children whose boxes the ray enters before `reach`, and the entry parameters of all.
    #[inline]
    pub(super) fn meet(&self, ray: &Slabs, reach: f32) -> (Lanes, [f32; WIDTH]) {
        // The mask spares a bounds check.
        let near = |k: usize| (self.planes[k][ray.near[k] & 1].load() - ray.near_origin[k]) * ray.inverse[k];
        let far = |k: usize| (self.planes[k][ray.near[k] & 1 ^ 1].load() - ray.far_origin[k]) * ray.inverse[k];
        let enter = near(0).max(near(1)).max(near(2).max(ray.t_min));
        let leave = far(0).min(far(1)).min(far(2).min(Native::splat(reach)));
        (Lanes::of(enter.at_most(leave).bits()), Row::of(enter).0)
    }

    /// Returns the child in `lane`.
    #[inline]
    pub(super) fn child(&self, lane: usize) -> u32 {
        self.children[lane]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Ray;
    use glam::{Vec3, Vec3A};

    /// A sequence of pseudo-random values in 0..1.
    fn noise() -> impl FnMut() -> f32 {
        let mut state = 1u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1 << 24) as f32
        }
    }

    /// The slab test of one box in f64, with boxes widened by `pad`.
    fn enters(ray: &Ray, bounds: &Aabb, pad: f64) -> bool {
        let (mut enter, mut leave) = (f64::from(ray.t_min), f64::from(ray.t_max));
        for k in 0..3 {
            let (origin, direction) = (f64::from(ray.origin[k]), f64::from(ray.direction[k]));
            let at = |plane: f64| (plane - origin) / direction;
            let (a, b) = (at(f64::from(bounds.min[k]) - pad), at(f64::from(bounds.max[k]) + pad));
            (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
        }
        enter <= leave
    }

    /// Full and partial nodes, rays of every octant: every box that the ray enters is found, and no box is found that
    /// the ray misses by more than the widening.
    #[test]
    fn node_test_matches_the_test_of_each_box() {
        let mut random = noise();
        let mut vector = move |least: f32, most: f32| Vec3::from([(); 3].map(|()| least + (most - least) * random()));
        let (mut found, mut missed) = (0, 0);
        for round in 0..4_000 {
            let count = 1 + round % WIDTH;
            let mut node = Node::EMPTY;
            let boxes: Vec<Aabb> = (0..count)
                .map(|_| (vector(-2.0, 0.0), vector(0.0, 2.0)))
                .map(|(min, size)| Aabb::new(Vec3A::from(min), Vec3A::from(min + size)))
                .collect();
            for (lane, bounds) in boxes.iter().enumerate() {
                node.set(lane, bounds, 10 + lane as u32);
            }
            let (origin, target, t_max) = (vector(-2.0, 2.0), vector(-1.0, 1.0), 4.0 * vector(0.0, 1.0).x);
            let ray = Ray { t_min: 0.01 * t_max, t_max, ..Ray::new(origin, target - origin) };
            let (lanes, _) = node.meet(&Slabs::new(&ray, 2.0), ray.t_max);
            let met: Vec<u32> = lanes.map(|lane| node.child(lane)).collect();
            for (child, bounds) in (10..).zip(&boxes) {
                let is_met = met.contains(&child);
                assert!(is_met || !enters(&ray, bounds, 0.0), "{ray:?} {bounds:?}");
                // Twice the widening of slabs: 16 half-ulps of the sum of the largest coordinates of origin and boxes.
                assert!(!is_met || enters(&ray, bounds, 2.0 * 4.0 * 16.0 * 6e-8), "{ray:?} {bounds:?}");
                *if is_met { &mut found } else { &mut missed } += 1;
            }
            assert!(met.iter().all(|child| (10..10 + count as u32).contains(child)), "{met:?} of {count}");
        }
        assert!(found > 1_000 && missed > 1_000, "{found} {missed}");
    }

    #[test]
    fn no_ray_enters_an_absent_child() {
        for direction in [Vec3::X, Vec3::NEG_X, Vec3::ONE, Vec3::ZERO] {
            let ray = Ray::new(Vec3::ZERO, direction);
            assert_eq!(Node::EMPTY.meet(&Slabs::new(&ray, 1.0), f32::INFINITY).0.count(), 0, "{direction}");
        }
    }
}
