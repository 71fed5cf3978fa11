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

    /// Returns a cone around all of `cones`: around their mean direction, as wide as the farthest needs.
    fn around(cones: &[Cone]) -> Cone {
        let Some(axis) = cones.iter().map(|cone| cone.axis).sum::<DVec3>().try_normalize() else { return Cone::ALL };
        let reach = |cone: &Cone| axis.dot(cone.axis).clamp(-1.0, 1.0).acos() + cone.angle;
        Cone { axis, angle: cones.iter().map(reach).fold(0.0, f64::max).min(PI) }
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

    /// Returns bounds of all of `parts`.
    pub fn around(parts: &[Reach]) -> Reach {
        let cones: Vec<Cone> = parts.iter().map(|part| part.normals).collect();
        Reach {
            bounds: parts.iter().fold(Bounds::EMPTY, |all, part| all.union(part.bounds)),
            normals: Cone::around(&cones),
            spread: parts.iter().map(|part| part.spread).fold(0.0, f64::max),
            two_sided: parts.iter().any(|part| part.two_sided),
            intensity: parts.iter().map(|part| part.intensity).sum(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cone_around_others_contains_them() {
        let axes = [DVec3::X, DVec3::new(0.6, 0.8, 0.0), DVec3::NEG_X, DVec3::new(-1.0, 1e-9, 0.0).normalize()];
        let cones = axes.iter().flat_map(|&axis| [0.0, 0.1, 1.0, 2.0, PI].map(|angle| Cone { axis, angle }));
        let cones: Vec<Cone> = cones.collect();
        for a in &cones {
            for b in &cones {
                let both = Cone::around(&[*a, *b]);
                for part in [a, b] {
                    let farthest = both.axis.dot(part.axis).clamp(-1.0, 1.0).acos() + part.angle;
                    // Rounding of the arc cosine near 1 is 2e-8.
                    assert!(farthest.min(PI) <= both.angle + 1e-7, "{a:?} {b:?}: {both:?}");
                }
            }
        }
    }
}
