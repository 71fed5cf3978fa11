//! Fresnel reflectance by angle. [`Fresnel::Schlick`] is glTF's model of metals and dielectrics,
//! [`Fresnel::Dielectric`] is exact for clear media, and [`Fresnel::Constant`] is for ideal mirrors. Reference:
//! [Schlick94].

use crate::numeric::Scalar;
use crate::spectrum::Spectrum;

/// Reflectance of a facet as a function of the angle to its normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fresnel {
    /// f0 at normal incidence, growing as (1 − cos)⁵ to f90 at grazing incidence [Schlick94 (15)].
    Schlick {
        /// At normal incidence, 0 to 1.
        f0: Spectrum,
        /// At grazing incidence, 0 to 1.
        f90: Spectrum,
    },
    /// Constant reflectance.
    Constant(Spectrum),
    /// Boundary of two clear media, unpolarised light.
    Dielectric {
        /// Refractive index beyond the boundary over the one before it.
        eta: f32,
    },
}

impl Fresnel {
    /// Returns the reflectance at the angle of cosine `cos`, 0 to 1.
    #[inline]
    pub fn reflectance<T: Scalar>(&self, cos: T) -> Spectrum<T> {
        match *self {
            Fresnel::Schlick { f0, f90 } => schlick(f0, f90, cos),
            Fresnel::Constant(f) => f.cast(),
            Fresnel::Dielectric { eta } => Spectrum::splat(dielectric(cos, T::of(f64::from(eta)))),
        }
    }

    /// Returns the highest reflectance at any angle, the greatest lane.
    pub fn highest(&self) -> f32 {
        match self {
            Fresnel::Schlick { f0, f90 } => f0.max_lane().max(f90.max_lane()),
            Fresnel::Constant(f) => f.max_lane(),
            Fresnel::Dielectric { .. } => 1.0,
        }
    }
}

/// Returns f0 + (f90 − f0)(1 − cos)⁵ [Schlick94 (15)].
#[inline]
pub fn schlick<T: Scalar>(f0: Spectrum, f90: Spectrum, cos: T) -> Spectrum<T> {
    f0.cast().lerp(f90.cast(), schlick_weight(cos))
}

/// Returns (1 − cos)⁵, the weight of f90.
#[inline]
pub fn schlick_weight<T: Scalar>(cos: T) -> T {
    let m = (T::ONE - cos).max(T::ZERO);
    m.squared().squared() * m
}

/// Returns the exact reflectance of a boundary of index ratio `eta` (beyond over before) at incidence cosine `cos` ≥ 0;
/// 1 under total reflection [Walter07 (22)].
#[inline]
pub fn dielectric<T: Scalar>(cos: T, eta: T) -> T {
    let g2 = refracted(cos, eta);
    if g2.value() > 0.0 { dielectric_between(cos, g2.sqrt(), eta) } else { T::ONE }
}

/// Like [`dielectric`] for known g = η cosθₜ. Nothing cancels, neither for η = 1 at grazing angles nor near total
/// reflection.
#[inline]
pub fn dielectric_between<T: Scalar>(cos: T, g: T, eta: T) -> T {
    let e2 = eta.squared();
    let perpendicular = (cos - g) / (cos + g);
    let parallel = (e2 * cos - g) / (e2 * cos + g);
    T::of(0.5) * (perpendicular.squared() + parallel.squared())
}

/// Returns η² cos²θₜ: negative under total reflection.
#[inline]
pub fn refracted<T: Scalar>(cos: T, eta: T) -> T {
    (eta - T::ONE) * (eta + T::ONE) + cos.squared()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matched_media_reflect_nothing_at_any_angle() {
        for cos in [1.0f32, 0.5, 1e-4, 1e-18] {
            assert!(dielectric(cos, 1.0) <= 0.0);
        }
    }

    #[test]
    fn glass_reflects_its_textbook_values() {
        assert!((dielectric(1.0f64, 1.5) - 0.04).abs() < 1e-15);
        let brewster = 1.0 / (1.0f64 + 1.5 * 1.5).sqrt();
        let perpendicular = (1.0f64 - 2.25) / (1.0 + 2.25);
        assert!((dielectric(brewster, 1.5) - 0.5 * perpendicular * perpendicular).abs() < 1e-15);
        let critical = (1.0f64 - 1.0 / 2.25).sqrt();
        assert!((dielectric(critical * 0.999, 1.0 / 1.5) - 1.0).abs() <= 0.0);
        assert!(dielectric(critical * 1.001, 1.0 / 1.5) < 1.0);
    }
}
