//! Ideal diffuse reflection, the same on both sides.

use super::{Bsdf, BsdfSample, Lobes};
use crate::geometry::Local;
use crate::numeric::Scalar;
use crate::sampling::warp::{cosine_hemisphere, cosine_hemisphere_inverse};
use crate::sampling::{Density, Pdf};
use crate::spectrum::Spectrum;
use crate::transport::TransportMode;
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;

/// Constant reflection into the hemisphere of incidence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lambert {
    /// Reflected share of light, 0 to 1.
    pub albedo: Spectrum,
}

impl Bsdf for Lambert {
    #[inline]
    fn eval<T: Scalar>(&self, wi: Local<T>, wo: Local<T>, lobes: Lobes) -> Spectrum<T> {
        if wi.same_side(wo) && lobes.intersects(Lobes::REFLECT) {
            (self.albedo * FRAC_1_PI).cast()
        } else {
            Spectrum::ZERO
        }
    }

    #[inline]
    fn sample(&self, known: Local, _: TransportMode, u: [f32; 3]) -> Option<BsdfSample> {
        let direction = cosine_direction(known, [u[1], u[2]]);
        let density = cosine_pdf(known, direction);
        (density > 0.0).then(|| BsdfSample {
            direction,
            value: self.albedo * FRAC_1_PI,
            density: Density::Smooth(Pdf::new(density)),
            lobe: Lobes::REFLECT,
            eta: 1.0,
        })
    }

    #[inline]
    fn dirac(&self, _: Local, _: TransportMode, _: Lobes) -> Option<BsdfSample> {
        None
    }

    #[inline]
    fn pdf<T: Scalar>(&self, known: Local<T>, other: Local<T>, _: TransportMode, lobes: Lobes) -> T {
        if lobes.intersects(Lobes::REFLECT) { cosine_pdf(known, other) } else { T::ZERO }
    }

    fn invert(&self, known: Local, other: Local, _: TransportMode, aux: [f32; 2]) -> Option<([f32; 3], f64)> {
        let [a, b] = invert_cosine(other);
        known.same_side(other).then_some(([aux[1], a, b], 0.0))
    }

    #[inline]
    fn lobes(&self) -> Lobes {
        Lobes::REFLECT
    }
}

/// Samples a direction on the side of `known` with density |cos| / π.
#[inline]
pub(super) fn cosine_direction(known: Local, u: [f32; 2]) -> Local {
    let w = cosine_hemisphere(u);
    Local::new(w.x, w.y, w.z.copysign(known.z))
}

/// Returns the density of [`cosine_direction`].
#[inline]
pub(super) fn cosine_pdf<T: Scalar>(known: Local<T>, other: Local<T>) -> T {
    if known.same_side(other) { other.z.abs() * T::of(std::f64::consts::FRAC_1_PI) } else { T::ZERO }
}

/// Returns the random numbers that [`cosine_direction`] maps to `other`.
#[inline]
pub(super) fn invert_cosine(other: Local) -> [f32; 2] {
    cosine_hemisphere_inverse(Vec3::new(other.x, other.y, other.z.abs()))
}
