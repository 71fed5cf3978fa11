//! Isotropic GGX microfacets with Smith's masking: the distribution, its visible normals as a sampler with inverse, and
//! the factors that reflection and refraction share.
//!
//! Everything is written in sines (x² + y² of a local direction). The usual cosine form, cos²θ (α² − 1) + 1, cancels:
//! in f32 it loses 3 % of the density at α = 1e-3 and all of it at 1e-4, this one 2e-8 / α. Limits: one bounce between
//! facets only, so rough surfaces lose energy. References: [Walter07], [Heitz14], [Dupuy23].

use crate::defects::{Defect, planted};
use crate::geometry::Local;
use crate::numeric::Scalar;
use crate::sampling::warp::{into_unit, turn};
use std::f32::consts::TAU;

/// Below this α a surface is a perfect mirror: a change of model, made because directions in f32 (rounded to 6e-8)
/// resolve the lobe to 0.2 % there and no better below.
pub const DIRAC_ALPHA: f32 = 3e-5;

/// A GGX distribution of facet normals with slope deviation α, between 0 (mirror) and 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ggx {
    alpha: f32,
}

impl Ggx {
    /// The distribution of slope deviation `alpha`, limited to 0 to 1. glTF's perceptual roughness is its root.
    #[inline]
    pub fn new(alpha: f32) -> Self {
        Ggx { alpha: alpha.clamp(0.0, 1.0) }
    }

    /// α.
    #[inline]
    pub fn alpha(self) -> f32 {
        self.alpha
    }

    /// Whether the surface counts as perfectly smooth: see [`DIRAC_ALPHA`].
    #[inline]
    pub fn is_dirac(self) -> bool {
        self.alpha < DIRAC_ALPHA
    }

    /// D(h): the density of facet area by normal, for unit `h` [Walter07 (33)].
    #[inline]
    pub fn d<T: Scalar>(self, h: Local<T>) -> T {
        let a2 = self.alpha_squared::<T>();
        let k = h.z.squared() + h.sin2() / a2;
        (T::of(std::f64::consts::PI) * a2 * k.squared()).recip()
    }

    /// G₁(w) / |w.z|: the share of facets that `w` sees, over its cosine; finite at grazing angles [Heitz14 (72)].
    #[inline]
    pub fn g1_over_cos<T: Scalar>(self, w: Local<T>) -> T {
        T::of(2.0) / (w.z.abs() + self.root(w))
    }

    /// D G₂ / (4 |cos cos|) of a reflection by facets of normal `h`, heights correlated [Heitz14 (99)].
    #[inline]
    pub fn reflection<T: Scalar>(self, wi: Local<T>, wo: Local<T>, h: Local<T>) -> T {
        if planted(Defect::GgxOneMasking) {
            return T::of(0.25) * self.d(h) * self.g1_over_cos(wo) / wi.z.abs();
        }
        if planted(Defect::GgxUncorrelated) {
            return T::of(0.25) * self.d(h) * self.g1_over_cos(wo) * self.g1_over_cos(wi);
        }
        let masking = wo.z.abs() * self.root(wi) + wi.z.abs() * self.root(wo);
        self.d(h) / (T::of(2.0) * masking)
    }

    /// Density per solid angle of the reflection of `known` in a normal `h` that `known` sees.
    #[inline]
    pub fn reflection_pdf<T: Scalar>(self, known: Local<T>, h: Local<T>) -> T {
        if planted(Defect::GgxPdfOfNormal) {
            return self.visible_normal_pdf(known, h);
        }
        let quarter = if planted(Defect::GgxPdf2Percent) { 0.255 } else { 0.25 };
        T::of(quarter) * self.g1_over_cos(known) * self.d(h)
    }

    /// Density of the normals that `w` sees, per solid angle of the normal [Heitz14 (16)].
    #[inline]
    pub fn visible_normal_pdf<T: Scalar>(self, w: Local<T>, h: Local<T>) -> T {
        self.g1_over_cos(w) * w.dot(h).abs() * self.d(h)
    }

    /// A unit normal that `w` (above the surface) sees, from two numbers [Dupuy23].
    #[inline]
    pub fn sample_normal(self, w: Local, u: [f32; 2]) -> Local {
        let (sin, cos) = (TAU * u[0]).sin_cos();
        self.cap_normal(w, [cos, sin], u[1])
    }

    /// The numbers that [`Ggx::sample_normal`] maps to the unit normal `h`.
    #[inline]
    pub fn invert_normal(self, w: Local, h: Local) -> [f32; 2] {
        let view = self.stretch(w);
        let normal = Local::new(h.x, h.y, h.z * self.alpha).normalized();
        let cap = normal.scale(2.0 * view.dot(normal));
        [turn(cap.y - view.y, cap.x - view.x), into_unit(1.0 - cap.z / (1.0 + view.z))]
    }

    /// The normal that `w` sees for a point `circle` of the unit circle and a height `v` of the spherical cap, both
    /// uniform. The cap's sine is a product of differences known exactly, so that nothing cancels.
    #[inline]
    pub fn cap_normal<T: Scalar>(self, w: Local<T>, circle: [T; 2], v: T) -> Local<T> {
        let view = self.stretch(w);
        let top = T::ONE + view.z;
        let z = (T::ONE - v) * top;
        let sine = (top * v * (view.sin2() / top + z)).max(T::ZERO).sqrt();
        let alpha = T::of(f64::from(self.alpha));
        Local::new(alpha * (sine * circle[0] + view.x), alpha * (sine * circle[1] + view.y), z).normalized()
    }

    /// `w` in the space where the facets form a hemisphere.
    #[inline]
    fn stretch<T: Scalar>(self, w: Local<T>) -> Local<T> {
        let alpha = T::of(f64::from(self.alpha));
        Local::new(alpha * w.x, alpha * w.y, w.z).normalized()
    }

    /// |cos| (1 + 2 Λ): Smith's masking without the tangent.
    #[inline]
    fn root<T: Scalar>(self, w: Local<T>) -> T {
        (w.z.squared() + self.alpha_squared::<T>() * w.sin2()).sqrt()
    }

    #[inline]
    fn alpha_squared<T: Scalar>(self) -> T {
        T::of(f64::from(self.alpha)).squared()
    }
}

/// The unit vector midway between two directions of one side.
#[inline]
pub fn half<T: Scalar>(a: Local<T>, b: Local<T>) -> Local<T> {
    a.plus(b).normalized()
}

/// `w` mirrored in the unit normal `h`.
#[inline]
pub fn reflect<T: Scalar>(w: Local<T>, h: Local<T>) -> Local<T> {
    h.scale(T::of(2.0) * w.dot(h)).plus(w.reversed())
}

/// `w` mirrored through the surface.
#[inline]
pub fn through<T: Scalar>(w: Local<T>) -> Local<T> {
    Local::new(w.x, w.y, -w.z)
}

/// `w` as seen with `reference` above the surface: models that look alike from both sides work there.
#[inline]
pub fn facing<T: Scalar>(w: Local<T>, reference: Local<T>) -> Local<T> {
    if reference.z.value() < 0.0 { through(w) } else { w }
}
