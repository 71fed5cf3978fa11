//! GGX reflection over lanes: [`crate::bsdf::ggx`] and [`crate::bsdf::Conductor`].

use super::{LanePoint, LaneScatter, LocalSample};
use crate::bsdf::Shares;
use crate::sampling::lanes::circle;
use crate::spectrum::Spectrum;
use etendue_lanes::{Float, ROW, Vec3};
use std::f32::consts::PI;

/// Rough reflection with Schlick's Fresnel.
#[derive(Debug, Clone, Copy)]
pub struct LaneConductor<F> {
    f0: Spectrum<F>,
    f90: Spectrum<F>,
    alpha: F,
}

#[inline(always)]
fn sin2<F: Float>(w: Vec3<F>) -> F {
    w.x * w.x + w.y * w.y
}

impl<F: Float> LaneConductor<F> {
    /// Returns the reflection of slope deviation `alpha` between the reflectances `f0` and `f90`.
    #[inline(always)]
    pub(super) fn of(f0: Spectrum<F>, f90: Spectrum<F>, alpha: F) -> Self {
        LaneConductor { f0, f90, alpha }
    }

    #[inline(always)]
    fn d(&self, h: Vec3<F>) -> F {
        let a2 = self.alpha * self.alpha;
        let k = h.z * h.z + sin2(h) / a2;
        (F::splat(PI) * a2 * (k * k)).recip()
    }

    #[inline(always)]
    fn root(&self, w: Vec3<F>) -> F {
        (w.z * w.z + self.alpha * self.alpha * sin2(w)).sqrt()
    }

    #[inline(always)]
    fn fresnel(&self, cos: F) -> Spectrum<F> {
        let one = F::splat(1.0);
        let m = (one - cos).max(F::splat(0.0));
        let weight = (m * m) * (m * m) * m;
        self.f0 * (one - weight) + self.f90 * weight
    }

    /// Returns value and density of `other` for light that leaves along `known`, by facets of normal `h`, which makes
    /// the cosine `cos` with the light.
    #[inline(always)]
    fn reflected(&self, known: Vec3<F>, other: Vec3<F>, h: Vec3<F>, cos: F) -> (Spectrum<F>, F) {
        let (d, root) = (self.d(h), self.root(known));
        let masking = known.z.abs() * self.root(other) + other.z.abs() * root;
        let pdf = F::splat(0.25) * (F::splat(2.0) / (known.z.abs() + root)) * d;
        (self.fresnel(cos) * (d / (F::splat(2.0) * masking)), pdf)
    }

    #[inline(always)]
    fn stretched(&self, w: Vec3<F>) -> Vec3<F> {
        Vec3::new(self.alpha * w.x, self.alpha * w.y, w.z).normalize()
    }

    /// Returns `known` above the surface, the visible normals sampled for it, and its reflections at them: see
    /// [`crate::bsdf::ggx::Ggx::sample_normal`].
    #[inline(always)]
    fn reflections(&self, known: Vec3<F>, [u, v]: [F; 2]) -> [Vec3<F>; 3] {
        let one = F::splat(1.0);
        let above = Vec3::new(known.x, known.y, known.z.abs());
        let view = self.stretched(above);
        let top = one + view.z;
        let z = (one - v) * top;
        let sine = (top * v * (sin2(view) / top + z)).max(F::splat(0.0)).sqrt();
        let [cos, sin] = circle(u);
        let h = Vec3::new(self.alpha * (sine * cos + view.x), self.alpha * (sine * sin + view.y), z).normalize();
        [above, h, h * (F::splat(2.0) * above.dot(h)) + -above]
    }

    /// Returns `w` with the surface's back upward where `known` is behind it.
    #[inline(always)]
    fn facing(known: Vec3<F>, w: Vec3<F>) -> Vec3<F> {
        Vec3::new(w.x, w.y, F::select(known.z.below(F::splat(0.0)), -w.z, w.z))
    }

    /// Samples a direction alone, and the lanes in which there is one.
    #[inline(always)]
    pub(super) fn direction(&self, known: Vec3<F>, u: [F; 2]) -> (Vec3<F>, F::Mask) {
        let [above, _, other] = self.reflections(known, u);
        (Self::facing(known, other), (above.z * other.z).above(F::splat(0.0)))
    }
}

impl<F: Float> LaneScatter<F> for LaneConductor<F> {
    #[inline(always)]
    fn new([[r, g, b, r90, g90, b90, alpha, _], ..]: [[F; ROW]; 3], _: &LanePoint<F>) -> Self {
        LaneConductor { f0: Spectrum([r, g, b]), f90: Spectrum([r90, g90, b90]), alpha }
    }

    #[inline(always)]
    fn shares(&self) -> Shares<F> {
        let [zero, one] = [0.0, 1.0].map(F::splat);
        Shares { diffuse: zero, glossy: one, alpha2: self.alpha * self.alpha }
    }

    #[inline(always)]
    fn eval_and_pdf(&self, known: Vec3<F>, other: Vec3<F>) -> (Spectrum<F>, F) {
        let h = (other + known).normalize();
        self.reflected(known, other, h, other.dot(h))
    }

    #[inline(always)]
    fn sample(&self, known: Vec3<F>, [_, u, v]: [F; 3]) -> LocalSample<F> {
        let [above, h, other] = self.reflections(known, [u, v]);
        let (value, pdf) = self.reflected(above, other, h, above.dot(h));
        let valid = (above.z * other.z).above(F::splat(0.0));
        LocalSample { w: Self::facing(known, other), value, pdf, valid }
    }
}
