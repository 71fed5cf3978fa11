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
    /// The empty box.
    pub const EMPTY: Bounds = Bounds { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// Returns the smallest box around `points`.
    pub fn around(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Bounds::EMPTY, Bounds::include)
    }

    /// Extends the box to contain `point`.
    #[inline]
    pub fn include(self, point: Vec3) -> Self {
        Bounds { min: self.min.min(point), max: self.max.max(point) }
    }

    /// Returns the smallest box around both.
    #[inline]
    pub fn union(self, other: Bounds) -> Self {
        Bounds { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Returns whether `point` lies in the box.
    #[inline]
    pub fn contains(&self, point: Vec3) -> bool {
        self.min.cmple(point).all() && self.max.cmpge(point).all()
    }

    /// Returns whether the boxes intersect.
    #[inline]
    pub fn meets(&self, other: &Bounds) -> bool {
        self.min.cmple(other.max).all() && self.max.cmpge(other.min).all()
    }

    /// Returns the volume; 0 for an empty box.
    pub fn volume(&self) -> f32 {
        (self.max - self.min).max(Vec3::ZERO).to_array().into_iter().product()
    }

    /// Returns whether the box is empty.
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// Returns the midpoint.
    pub fn center(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// Returns half the diagonal: the radius of the circumscribed sphere.
    pub fn radius(&self) -> f32 {
        if self.is_empty() { 0.0 } else { (self.max - self.min).length() * 0.5 }
    }
}
