//! Scattering at a receiver of light in outline: as much as the selection of lights uses.

use etendue_lanes::{Float, Vec3 as LaneVec3};
use glam::Vec3;

/// Least squared slope deviation of a lobe. It keeps its peak within f32.
const LEAST_ALPHA2: f32 = 1e-6;

/// Least squared length of the sum of two unit directions.
const LEAST_SUM2: f32 = 1e-6;

/// A diffuse part and one lobe of reflection, for light that leaves along a known direction.
#[derive(Debug, Clone, Copy)]
pub struct ScatteringOutline {
    /// Shading normal.
    pub n: Vec3,
    /// The known direction, away from the surface.
    pub wo: Vec3,
    /// Weight of the diffuse part, and of all that is neither diffuse nor a lobe of reflection.
    pub diffuse: f32,
    /// Weight of the lobe.
    pub glossy: f32,
    /// Squared slope deviation of the lobe's facets, α² of GGX.
    pub alpha2: f32,
    /// Whether light from the side away from `wo` is scattered.
    pub transmits: bool,
}

impl ScatteringOutline {
    /// Nothing is known: light from all directions counts.
    pub const UNKNOWN: ScatteringOutline =
        ScatteringOutline { n: Vec3::ZERO, wo: Vec3::ZERO, diffuse: 1.0, glossy: 0.0, alpha2: 1.0, transmits: true };

    /// Returns π times the density per solid angle of the lobe at the unit directions `wi`, averaged over groups of
    /// directions of angular radius arcsin `sin_seen` around them. The facets of a group's directions spread by their
    /// own deviation and by that of the half vectors, whose squares are added.
    #[inline(always)]
    pub fn reflected<F: Float>(&self, wi: LaneVec3<F>, sin_seen: F) -> F {
        let all = |v: Vec3| LaneVec3::new(F::splat(v.x), F::splat(v.y), F::splat(v.z));
        let one = F::splat(1.0);
        let sum = wi + all(self.wo);
        let inverse = sum.length_squared().max(F::splat(LEAST_SUM2)).sqrt().recip();
        let spread = sin_seen * inverse;
        let alpha2 = (F::splat(self.alpha2.max(LEAST_ALPHA2)) + spread * spread).min(one);
        let cos = (sum.dot(all(self.n)) * inverse).abs().min(one);
        let k = cos * cos * alpha2 + (one - cos * cos);
        // D(h) cos / (4 wo·h), of which the sum of the directions is 2 wo·h long.
        alpha2 / (k * k) * cos * (F::splat(0.5) * inverse)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    /// Returns the integral of the density of a lobe for `wo` = (sin `angle`, 0, cos `angle`) over all directions.
    fn integral(alpha2: f32, angle: f32) -> f64 {
        const RINGS: u32 = 2000;
        let wo = Vec3::new(angle.sin(), 0.0, angle.cos());
        let outline =
            ScatteringOutline { n: Vec3::Z, wo, diffuse: 0.0, glossy: 1.0, alpha2, ..ScatteringOutline::UNKNOWN };
        // Rings around the mirror direction, narrow near it.
        let axis = Vec3::new(-wo.x, 0.0, wo.z);
        let (s, t) = axis.any_orthonormal_pair();
        let mut sum = 0.0;
        for ring in 0..RINGS {
            let of = |k: u32| PI * (f64::from(k) / f64::from(RINGS)).powi(3);
            let (from, to) = (of(ring), of(ring + 1));
            let (height, solid_angle) = (0.5 * (from.cos() + to.cos()), TAU * (from.cos() - to.cos()));
            let radius = (1.0 - height * height).sqrt();
            let mean: f64 = (0..64)
                .map(|k| {
                    let (sin, cos) = (TAU * (f64::from(k) + 0.5) / 64.0).sin_cos();
                    let wi = axis * height as f32 + s * (radius * cos) as f32 + t * (radius * sin) as f32;
                    f64::from(outline.reflected(wi.into(), 0.0f32))
                })
                .sum();
            sum += mean / 64.0 * solid_angle / PI;
        }
        sum
    }

    /// Facets that face away from an oblique direction have no reflection: for small slopes there are few.
    #[test]
    fn the_density_of_a_lobe_integrates_to_one() {
        for alpha2 in [1e-4, 1e-2, 0.25, 1.0] {
            let whole = integral(alpha2, 0.0);
            assert!((whole - 1.0).abs() < 0.01, "{alpha2}: {whole}"); // error of the sum, by halving its steps
        }
        for angle in [0.3, 1.0, 1.3] {
            let whole = integral(1e-3, angle);
            assert!((0.95..1.01).contains(&whole), "{angle}: {whole}");
        }
    }
}
