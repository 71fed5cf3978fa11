//! Moving a scene to the origin and to radius about 1, in f64, so that f32 renders it with the same precision wherever and
//! however large it is.

use glam::{DAffine3, DMat3, DVec3};

/// x ↦ (x − centre) · scale. The scale is a power of two: it adds no rounding.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Rebase {
    /// The file's point that becomes the origin.
    pub centre: DVec3,
    /// Scene units per file unit.
    pub scale: f64,
}

impl Rebase {
    /// The transform that brings the box `min`..`max` to the origin and its bounding radius between 0.7 and 1.4.
    pub fn of_box(min: DVec3, max: DVec3) -> Self {
        let radius = (max - min).length() * 0.5;
        let exponent = if radius > 0.0 { -radius.log2().round() } else { 0.0 };
        // Beyond this the scale itself or its square would leave the range of f32.
        const MOST: f64 = 60.0;
        Rebase { centre: (min + max) * 0.5, scale: exponent.clamp(-MOST, MOST).exp2() }
    }

    /// A point of the file in scene coordinates.
    #[inline]
    pub fn point(&self, p: DVec3) -> DVec3 {
        (p - self.centre) * self.scale
    }

    /// A point of the scene in the file's coordinates.
    #[inline]
    pub fn point_in_file(&self, p: DVec3) -> DVec3 {
        p / self.scale + self.centre
    }

    /// A transform to the file's world, followed by this.
    pub fn transform(&self, m: &DAffine3) -> DAffine3 {
        DAffine3 { matrix3: m.matrix3 * DMat3::from_diagonal(DVec3::splat(self.scale)), translation: self.point(m.translation) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_far_box_comes_to_the_origin_with_radius_about_one() {
        for s in [1e-4, 1.0, 3.3, 1e6] {
            let c = DVec3::new(1e6, -2e6, 5.0);
            let r = Rebase::of_box(c - s, c + s);
            let radius = (r.point(c + s) - r.point(c - s)).length() * 0.5;
            assert!((0.7..=1.42).contains(&radius), "{radius}");
            assert_eq!(r.point(c), DVec3::ZERO);
            assert_eq!(r.scale.log2().fract(), 0.0);
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
