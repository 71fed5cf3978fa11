//! Where lights are and where they shine: boxes and cones.

use crate::geometry::Bounds;
use glam::DVec3;
use std::f64::consts::PI;

/// Bounds of one light or of several: their positions, the directions in which they shine, and how strongly.
#[derive(Debug, Clone, Copy)]
pub struct Reach {
    /// Box around all points.
    pub bounds: Bounds,
    /// All normals of emitters: see [`Cone`].
    pub normals: Cone,
    /// Angle to a normal up to which light leaves, at most π.
    pub spread: f64,
    /// Whether light also leaves along the opposite directions.
    pub two_sided: bool,
    /// Sum of the largest intensities, watts per steradian (mean over wavelengths).
    pub intensity: f64,
}

/// A cone of directions.
#[derive(Debug, Clone, Copy)]
pub struct Cone {
    /// Unit axis.
    pub axis: DVec3,
    /// Half the opening angle, up to π.
    pub angle: f64,
}

impl Cone {
    /// All directions.
    pub const ALL: Cone = Cone { axis: DVec3::Z, angle: PI };

    /// Returns a cone around both, the smallest one but for rounding.
    fn union(self, other: Cone) -> Cone {
        let (a, b) = if self.angle >= other.angle { (self, other) } else { (other, self) };
        let between = a.axis.dot(b.axis).clamp(-1.0, 1.0).acos();
        if (between + b.angle).min(PI) <= a.angle {
            return a;
        }
        let angle = 0.5 * (a.angle + between + b.angle);
        let across = a.axis.cross(b.axis);
        if angle >= PI || across.length_squared() <= 0.0 {
            return Cone::ALL;
        }
        // Turns the axis of the wider one toward the other.
        let aside = across.cross(a.axis).normalize();
        let turn = angle - a.angle;
        Cone { axis: (a.axis * turn.cos() + aside * turn.sin()).normalize(), angle }
    }
}

impl Reach {
    /// Bounds of no light.
    pub const NOTHING: Reach = Reach {
        bounds: Bounds::EMPTY,
        normals: Cone { axis: DVec3::Z, angle: 0.0 },
        spread: 0.0,
        two_sided: false,
        intensity: 0.0,
    };

    /// Returns bounds of both.
    pub fn union(&self, other: &Reach) -> Reach {
        if self.bounds.is_empty() {
            return *other;
        }
        if other.bounds.is_empty() {
            return *self;
        }
        Reach {
            bounds: self.bounds.union(other.bounds),
            normals: self.normals.union(other.normals),
            spread: self.spread.max(other.spread),
            two_sided: self.two_sided || other.two_sided,
            intensity: self.intensity + other.intensity,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_union_of_cones_contains_both() {
        let axes = [DVec3::X, DVec3::new(0.6, 0.8, 0.0), DVec3::NEG_X, DVec3::new(-1.0, 1e-9, 0.0).normalize()];
        let cones = axes.iter().flat_map(|&axis| [0.0, 0.1, 1.0, 2.0, PI].map(|angle| Cone { axis, angle }));
        let cones: Vec<Cone> = cones.collect();
        for a in &cones {
            for b in &cones {
                let both = a.union(*b);
                for part in [a, b] {
                    let farthest = both.axis.dot(part.axis).clamp(-1.0, 1.0).acos() + part.angle;
                    // Rounding of the arc cosine near 1 is 2e-8.
                    assert!(farthest.min(PI) <= both.angle + 1e-7, "{a:?} {b:?}: {both:?}");
                }
            }
        }
    }
}
