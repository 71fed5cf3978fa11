//! Vectors of three coordinates, one vector a lane. Operations round as those of glam's `Vec3` do.

use crate::{Double, Float};
use std::ops::{Add, Mul, Neg, Sub};

/// Three coordinates of [`Float`] or [`Double`] lanes.
#[derive(Debug, Clone, Copy)]
pub struct Vec3<F> {
    /// First coordinate.
    pub x: F,
    /// Second coordinate.
    pub y: F,
    /// Third coordinate.
    pub z: F,
}

impl<F: Copy> Vec3<F> {
    /// Returns the vector (x, y, z).
    #[inline(always)]
    pub fn new(x: F, y: F, z: F) -> Self {
        Vec3 { x, y, z }
    }

    /// Returns the vector of these coordinates.
    #[inline(always)]
    pub fn from_array([x, y, z]: [F; 3]) -> Self {
        Vec3 { x, y, z }
    }

    /// Returns the coordinates.
    #[inline(always)]
    pub fn to_array(self) -> [F; 3] {
        [self.x, self.y, self.z]
    }

    /// Applies `f` to each coordinate.
    #[inline(always)]
    pub fn map(self, mut f: impl FnMut(F) -> F) -> Self {
        Vec3 { x: f(self.x), y: f(self.y), z: f(self.z) }
    }

    /// Applies `f` to the coordinates of two vectors.
    #[inline(always)]
    pub fn zip(self, other: Self, mut f: impl FnMut(F, F) -> F) -> Self {
        Vec3 { x: f(self.x, other.x), y: f(self.y, other.y), z: f(self.z, other.z) }
    }
}

impl<F: Copy + Add<Output = F> + Mul<Output = F> + Sub<Output = F>> Vec3<F> {
    /// Returns the dot product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> F {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Returns the cross product.
    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Vec3 { x: self.y * o.z - o.y * self.z, y: self.z * o.x - o.z * self.x, z: self.x * o.y - o.x * self.y }
    }

    /// Returns the squared length.
    #[inline(always)]
    pub fn length_squared(self) -> F {
        self.dot(self)
    }
}

impl<F: Float> Vec3<F> {
    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat([x, y, z]: [f32; 3]) -> Self {
        Vec3 { x: F::splat(x), y: F::splat(y), z: F::splat(z) }
    }

    /// Returns the vector of `lane`.
    #[inline(always)]
    pub fn lane(self, lane: usize) -> [f32; 3] {
        [self.x.lane(lane), self.y.lane(lane), self.z.lane(lane)]
    }

    /// Loads consecutive vectors from `at` on.
    #[inline(always)]
    pub fn load(from: &[Vec<f32>; 3], at: usize) -> Self {
        Vec3 { x: F::load(&from[0], at), y: F::load(&from[1], at), z: F::load(&from[2], at) }
    }

    /// See [`crate::Int::pack`].
    #[inline(always)]
    pub fn pack(self, mask: F::Mask, to: &mut [Vec<f32>; 3], at: usize) {
        self.x.pack(mask, &mut to[0], at);
        self.y.pack(mask, &mut to[1], at);
        self.z.pack(mask, &mut to[2], at);
    }

    /// Returns `yes` in the lanes of `mask`, else `no`.
    #[inline(always)]
    pub fn select(mask: F::Mask, yes: Self, no: Self) -> Self {
        yes.zip(no, |yes, no| F::select(mask, yes, no))
    }

    /// The magnitudes.
    #[inline(always)]
    pub fn abs(self) -> Self {
        self.map(F::abs)
    }

    /// The largest coordinate.
    #[inline(always)]
    pub fn max_element(self) -> F {
        self.x.max(self.y.max(self.z))
    }

    /// The sum of the coordinates.
    #[inline(always)]
    pub fn element_sum(self) -> F {
        self.x + self.y + self.z
    }

    /// Returns the vector of length 1.
    #[inline(always)]
    pub fn normalize(self) -> Self {
        self * self.length_squared().sqrt().recip()
    }
}

impl<D: Double> Vec3<D> {
    /// Returns the length.
    #[inline(always)]
    pub fn length(self) -> D {
        self.dot(self).sqrt()
    }
}

impl From<glam::Vec3> for Vec3<f32> {
    #[inline(always)]
    fn from(v: glam::Vec3) -> Self {
        Vec3::from_array(v.to_array())
    }
}

impl From<Vec3<f32>> for glam::Vec3 {
    #[inline(always)]
    fn from(v: Vec3<f32>) -> Self {
        v.to_array().into()
    }
}

impl From<glam::DVec3> for Vec3<f64> {
    #[inline(always)]
    fn from(v: glam::DVec3) -> Self {
        Vec3::from_array(v.to_array())
    }
}

impl From<Vec3<f64>> for glam::DVec3 {
    #[inline(always)]
    fn from(v: Vec3<f64>) -> Self {
        v.to_array().into()
    }
}

impl<F: Copy + Add<Output = F>> Add for Vec3<F> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl<F: Copy + Sub<Output = F>> Sub for Vec3<F> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl<F: Copy + Mul<Output = F>> Mul<F> for Vec3<F> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: F) -> Self {
        self.map(|a| a * factor)
    }
}

impl<F: Copy + Neg<Output = F>> Neg for Vec3<F> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}
