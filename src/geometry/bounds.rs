//! Axis-aligned boxes.

use glam::Vec3;

/// An axis-aligned box; empty when `min` exceeds `max`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

impl Bounds {
    /// The box that holds nothing.
    pub const EMPTY: Bounds = Bounds { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box around `points`.
    pub fn around(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Bounds::EMPTY, Bounds::include)
    }

    /// This box grown to hold `point`.
    #[inline]
    pub fn include(self, point: Vec3) -> Self {
        Bounds { min: self.min.min(point), max: self.max.max(point) }
    }

    /// The smallest box around both.
    #[inline]
    pub fn union(self, other: Bounds) -> Self {
        Bounds { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether `point` lies in it.
    #[inline]
    pub fn contains(&self, point: Vec3) -> bool {
        self.min.cmple(point).all() && self.max.cmpge(point).all()
    }

    /// Whether both share a point.
    #[inline]
    pub fn meets(&self, other: &Bounds) -> bool {
        self.min.cmple(other.max).all() && self.max.cmpge(other.min).all()
    }

    /// What it holds, as a volume; 0 if it is empty.
    pub fn volume(&self) -> f32 {
        (self.max - self.min).max(Vec3::ZERO).to_array().into_iter().product()
    }

    /// Whether it holds nothing.
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// The midpoint.
    pub fn center(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// Half the diagonal: the radius of the sphere around the box.
    pub fn radius(&self) -> f32 {
        if self.is_empty() { 0.0 } else { (self.max - self.min).length() * 0.5 }
    }
}
