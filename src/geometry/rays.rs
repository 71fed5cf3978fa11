//! Rays and hits of a batch, as arrays of coordinates. Kernels load and store groups of lanes, and backends packets.

use super::{Hit, Ray};
use etendue_lanes::MOST_LANES;
use glam::Vec3;

/// Places beyond the capacity that a group of lanes or a packet may read and overwrite.
pub const PADDING: usize = MOST_LANES;

/// A growing list of rays from `t_min` 0, outside all bodies, at time 0.
#[derive(Debug, Clone)]
pub struct Rays {
    /// Origins by axis.
    pub origin: [Vec<f32>; 3],
    /// Directions by axis.
    pub direction: [Vec<f32>; 3],
    /// Greatest parameters.
    pub t_max: Vec<f32>,
    len: usize,
}

impl Rays {
    /// Returns an empty list with room for `capacity` rays.
    pub fn new(capacity: usize) -> Self {
        let column = || vec![0.0; capacity + PADDING];
        Rays { origin: [(); 3].map(|()| column()), direction: [(); 3].map(|()| column()), t_max: column(), len: 0 }
    }

    /// Returns the number of rays.
    #[inline]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Returns whether there are no rays.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Sets the number of rays, which are in the arrays already.
    ///
    /// # Panics
    /// Beyond the capacity.
    #[inline]
    pub fn set_len(&mut self, len: usize) {
        assert!(len + PADDING <= self.t_max.len(), "a batch of rays is over its capacity");
        self.len = len;
    }

    /// Appends a ray.
    ///
    /// # Panics
    /// Beyond the capacity.
    #[inline]
    pub fn push(&mut self, ray: &Ray) {
        let at = self.len;
        for axis in 0..3 {
            self.origin[axis][at] = ray.origin[axis];
            self.direction[axis][at] = ray.direction[axis];
        }
        self.t_max[at] = ray.t_max;
        self.set_len(at + 1);
    }

    /// Returns ray number `at`.
    #[inline]
    pub fn ray(&self, at: usize) -> Ray {
        let vector = |columns: &[Vec<f32>; 3]| Vec3::new(columns[0][at], columns[1][at], columns[2][at]);
        Ray { t_max: self.t_max[at], ..Ray::new(vector(&self.origin), vector(&self.direction)) }
    }
}

/// Hits of [`Rays`], in their order.
#[derive(Debug, Clone)]
pub struct Hits {
    /// See [`Hit::object`].
    pub objects: Vec<u32>,
    /// See [`Hit::primitive`].
    pub primitives: Vec<u32>,
}

impl Hits {
    /// Returns room for the hits of `capacity` rays.
    pub fn new(capacity: usize) -> Self {
        let none = vec![Hit::NONE.object; capacity + PADDING];
        Hits { objects: none.clone(), primitives: none }
    }

    /// Returns the hit of ray number `at`; [`Hit::NONE`] where there is none.
    #[inline]
    pub fn hit(&self, at: usize) -> Hit {
        Hit { object: self.objects[at], primitive: self.primitives[at] }
    }

    /// Returns the hit of ray number `at`, if there is one.
    #[inline]
    pub fn get(&self, at: usize) -> Option<Hit> {
        Some(self.hit(at)).filter(|&hit| hit != Hit::NONE)
    }

    /// Stores the hit of ray number `at`.
    #[inline]
    pub fn set(&mut self, at: usize, hit: Option<Hit>) {
        let hit = hit.unwrap_or(Hit::NONE);
        (self.objects[at], self.primitives[at]) = (hit.object, hit.primitive);
    }
}
