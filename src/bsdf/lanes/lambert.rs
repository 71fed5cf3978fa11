//! [`crate::bsdf::Lambert`] over lanes.

use super::{LanePoint, LaneScatter, LocalSample};
use crate::bsdf::Shares;
use crate::sampling::lanes::cosine_hemisphere;
use crate::spectrum::Spectrum;
use etendue_lanes::{Float, ROW, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Ideal diffuse reflection.
#[derive(Debug, Clone, Copy)]
pub struct LaneLambert<F> {
    albedo: Spectrum<F>,
}

/// Returns directions on the side of `known` with density |cos| / π.
#[inline(always)]
pub(super) fn cosine_direction<F: Float>(known: Vec3<F>, u: [F; 2]) -> Vec3<F> {
    let w = cosine_hemisphere(u);
    Vec3::new(w.x, w.y, w.z.copysign(known.z))
}

/// Returns the density of [`cosine_direction`].
#[inline(always)]
pub(super) fn cosine_pdf<F: Float>(w: Vec3<F>) -> F {
    w.z.abs() * F::splat(FRAC_1_PI)
}

impl<F: Float> LaneScatter<F> for LaneLambert<F> {
    #[inline(always)]
    fn new([[r, g, b, ..], ..]: [[F; ROW]; 3], _: &LanePoint<F>) -> Self {
        LaneLambert { albedo: Spectrum([r, g, b]) }
    }

    #[inline(always)]
    fn shares(&self) -> Shares<F> {
        let [zero, one] = [0.0, 1.0].map(F::splat);
        Shares { diffuse: one, glossy: zero, alpha2: one }
    }

    #[inline(always)]
    fn eval_and_pdf(&self, _: Vec3<F>, other: Vec3<F>) -> (Spectrum<F>, F) {
        (self.albedo * F::splat(FRAC_1_PI), cosine_pdf(other))
    }

    #[inline(always)]
    fn sample(&self, known: Vec3<F>, [_, u, v]: [F; 3]) -> LocalSample<F> {
        let w = cosine_direction(known, [u, v]);
        let (value, pdf) = self.eval_and_pdf(known, w);
        let zero = F::splat(0.0);
        LocalSample { w, value, pdf, valid: (known.z * w.z).above(zero) & pdf.above(zero) }
    }
}
