//! Orthonormal frames and directions expressed in them.

use crate::numeric::Scalar;
use etendue_lanes::{self as lanes, Float};
use glam::Vec3;

/// A direction in a local frame whose z axis is the shading normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Local<T = f32> {
    /// Along the tangent.
    pub x: T,
    /// Along the bitangent.
    pub y: T,
    /// Along the normal: the cosine, for a unit direction.
    pub z: T,
}

impl<T: Scalar> Local<T> {
    /// Returns the direction (x, y, z).
    #[inline]
    pub fn new(x: T, y: T, z: T) -> Self {
        Local { x, y, z }
    }

    /// Returns the dot product.
    #[inline]
    pub fn dot(self, o: Self) -> T {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    /// Multiplies by `k`.
    #[inline]
    pub fn scale(self, k: T) -> Self {
        Local::new(self.x * k, self.y * k, self.z * k)
    }

    /// Returns the sum.
    #[inline]
    pub fn plus(self, o: Self) -> Self {
        Local::new(self.x + o.x, self.y + o.y, self.z + o.z)
    }

    /// Returns the opposite direction.
    #[inline]
    pub fn reversed(self) -> Self {
        Local::new(-self.x, -self.y, -self.z)
    }

    /// Normalises the vector.
    #[inline]
    pub fn normalized(self) -> Self {
        self.scale(self.dot(self).sqrt().recip())
    }

    /// Returns sin² of the angle to the normal, from x and y: accurate near the pole, where 1 − z² cancels.
    #[inline]
    pub fn sin2(self) -> T {
        self.x * self.x + self.y * self.y
    }

    /// Returns whether both directions are on the same side of the surface.
    #[inline]
    pub fn same_side(self, o: Self) -> bool {
        (self.z * o.z).value() > 0.0
    }
}

impl Local {
    /// Converts to another scalar type.
    pub fn cast<U: Scalar>(self) -> Local<U> {
        Local::new(U::of(f64::from(self.x)), U::of(f64::from(self.y)), U::of(f64::from(self.z)))
    }
}

impl From<Vec3> for Local {
    #[inline]
    fn from(v: Vec3) -> Self {
        Local::new(v.x, v.y, v.z)
    }
}

/// An orthonormal, right-handed basis around a normal.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    /// Tangent.
    pub s: Vec3,
    /// Bitangent.
    pub t: Vec3,
    /// Normal.
    pub n: Vec3,
}

impl Frame {
    /// Returns an arbitrary frame around the unit normal `n` [Duff17].
    #[inline]
    pub fn around(n: Vec3) -> Self {
        let [s, t] = tangents(lanes::Vec3::from(n)).map(Vec3::from);
        Frame { s, t, n }
    }

    /// Converts `w` to this frame.
    #[inline]
    pub fn to_local(&self, w: Vec3) -> Local {
        Local::new(w.dot(self.s), w.dot(self.t), w.dot(self.n))
    }

    /// Converts `l` to world space.
    #[inline]
    pub fn to_world(&self, l: Local) -> Vec3 {
        self.s * l.x + self.t * l.y + self.n * l.z
    }
}

/// Returns two unit vectors that make a right-handed basis with the unit normals `n` [Duff17].
#[inline(always)]
pub fn tangents<F: Float>(n: lanes::Vec3<F>) -> [lanes::Vec3<F>; 2] {
    let one = F::splat(1.0);
    let sign = one.copysign(n.z);
    let a = -one / (sign + n.z);
    let b = n.x * n.y * a;
    [
        lanes::Vec3::new(one + sign * n.x * n.x * a, sign * b, -sign * n.x),
        lanes::Vec3::new(b, sign + n.y * n.y * a, -n.y),
    ]
}
