//! Rebasing of a scene to the origin and to radius 1, in f64, so that f32 precision does not depend on its position and
//! size.
//!
//! - The scale is 1 / radius and not the nearest power of two, which would be free of rounding. A scene scaled by any
//!   factor then has the same f32 coordinates, except where f64 itself rounds, and the same seed gives the same paths.
//!   With powers of two, the scenes in scenes/ scaled by 1e-4 had all coordinates rounded differently, and one path in
//!   10⁵ through glass changed.
//! - The origin is at the centre of detail. f32 resolves 6e-8 of the distance to the origin. Halfway between a 1 m
//!   object and a sun at 1e8 m it would resolve 3 m; near the object it resolves the object.
//!
//! Limits: with two distant regions of similar detail the origin lies between them. Triangles smaller than 6e-6 of
//! their distance from it are degraded; the scene's warnings give their number. The depth plane resolves 6e-8 of the
//! radius.

use glam::{DAffine3, DMat3, DVec3};

/// Largest scale and radius: beyond them the scale or its square would exceed the range of f32.
pub(super) const MOST: f64 = 1e18;

/// x ↦ (x − centre) · scale.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Rebase {
    /// The point of the file that becomes the origin.
    pub centre: DVec3,
    /// Scene units per file unit.
    pub scale: f64,
}

impl Rebase {
    /// Returns the transform that takes `centre` to the origin and lengths of `radius` to 1.
    pub fn new(centre: DVec3, radius: f64) -> Self {
        let scale = if radius > 0.0 { radius.recip() } else { 1.0 };
        Rebase { centre, scale: scale.clamp(MOST.recip(), MOST) }
    }

    /// Transforms a point from file to scene coordinates.
    #[inline]
    pub fn point(&self, p: DVec3) -> DVec3 {
        (p - self.centre) * self.scale
    }

    /// Transforms a point from scene to file coordinates.
    #[inline]
    pub fn point_in_file(&self, p: DVec3) -> DVec3 {
        p / self.scale + self.centre
    }

    /// Composes a transform to the file's world with this one.
    pub fn transform(&self, m: &DAffine3) -> DAffine3 {
        DAffine3 {
            matrix3: m.matrix3 * DMat3::from_diagonal(DVec3::splat(self.scale)),
            translation: self.point(m.translation),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scaled_scene_has_the_same_coordinates() {
        let p = DVec3::new(0.1, -0.7, 0.3);
        let here = Rebase::new(DVec3::new(0.2, 0.1, 0.0), 1.7).point(p);
        for s in [1e-12, 1e-4, 3.3, 1e6] {
            let there = Rebase::new(DVec3::new(0.2, 0.1, 0.0) * s, 1.7 * s).point(p * s);
            assert!((here - there).abs().max_element() < 8.0 * f64::EPSILON, "{s}"); // eight roundings
        }
    }

    #[test]
    fn a_point_and_a_galaxy_stay_in_range() {
        for radius in [0.0, 1e-300, 1e300] {
            let scale = Rebase::new(DVec3::ZERO, radius).scale as f32;
            assert!((scale * scale).is_normal(), "{radius}: {scale}");
        }
    }

    #[test]
    fn transforms_and_points_agree() {
        let r = Rebase { centre: DVec3::new(1.0, 2.0, 3.0), scale: 0.25 };
        let m = DAffine3::from_rotation_y(0.3) * DAffine3::from_translation(DVec3::new(5.0, 6.0, 7.0));
        let p = DVec3::new(0.1, 0.2, 0.3);
        let (a, b) = (r.point(m.transform_point3(p)), r.transform(&m).transform_point3(p));
        assert!((a - b).length() < 1e-15 * 16.0, "{a} {b}");
        assert!((r.point_in_file(r.point(p)) - p).length() < 1e-15);
    }
}
