//! Isotropic GGX microfacets with Smith masking: the distribution, an invertible sampler of visible normals, and the
//! common factors of reflection and refraction.
//!
//! Everything is expressed in sines (x² + y² of a local direction). The usual cosine form, cos²θ (α² − 1) + 1, suffers
//! from cancellation. In f32 it loses 3 % of the density at α = 1e-3 and all of it at 1e-4; the sine form loses
//! 2e-8 / α. Limits: single scattering between facets only, so that rough surfaces lose energy. References: [Walter07],
//! [Heitz14], [Dupuy23].

use crate::geometry::Local;
use crate::numeric::Scalar;
use crate::sampling::lanes;
use crate::sampling::warp::{into_unit, turn};

/// Below this α a surface is treated as a perfect mirror. Directions in f32 (rounded to 6e-8) resolve the lobe to 0.2 %
/// at this α, and no better below.
pub const DIRAC_ALPHA: f32 = 3e-5;

/// GGX distribution of facet normals with slope deviation α, between 0 (mirror) and 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ggx {
    alpha: f32,
}

impl Ggx {
    /// Creates the distribution of slope deviation `alpha`, clamped to [0, 1]. glTF's perceptual roughness is its
    /// square root.
    #[inline]
    pub fn new(alpha: f32) -> Self {
        Ggx { alpha: alpha.clamp(0.0, 1.0) }
    }

    /// Slope deviation α.
    #[inline]
    pub fn alpha(self) -> f32 {
        self.alpha
    }

    /// Whether the surface counts as perfectly smooth: see [`DIRAC_ALPHA`].
    #[inline]
    pub fn is_dirac(self) -> bool {
        self.alpha < DIRAC_ALPHA
    }

    /// Returns D(h), the density of facet area by normal, for unit `h` [Walter07 (33)].
    #[inline]
    pub fn d<T: Scalar>(self, h: Local<T>) -> T {
        let a2 = self.alpha_squared::<T>();
        let k = h.z.squared() + h.sin2() / a2;
        (T::of(std::f64::consts::PI) * a2 * k.squared()).recip()
    }

    /// Returns G₁(w) / |w.z|: the share of facets visible from `w`, over its cosine; finite at grazing angles
    /// [Heitz14 (72)].
    #[inline]
    pub fn g1_over_cos<T: Scalar>(self, w: Local<T>) -> T {
        T::of(2.0) / (w.z.abs() + self.root(w))
    }

    /// Returns D G₂ / (4 |cos cos|) of a reflection by facets of normal `h`, with height-correlated masking
    /// [Heitz14 (99)].
    #[inline]
    pub fn reflection<T: Scalar>(self, wi: Local<T>, wo: Local<T>, h: Local<T>) -> T {
        let masking = wo.z.abs() * self.root(wi) + wi.z.abs() * self.root(wo);
        self.d(h) / (T::of(2.0) * masking)
    }

    /// Returns an upper bound of [`Ggx::reflection`] times the cosine of the other direction, for `known`.
    #[inline]
    pub fn most_reflection(self, known: Local) -> f32 {
        // The masking is at least |cos| of the other direction times the root of this one, and D is highest at the normal.
        self.d(Local::new(0.0, 0.0, 1.0)) / (2.0 * self.root(known))
    }

    /// Returns the density per solid angle of the reflection of `known` at a visible normal `h`.
    #[inline]
    pub fn reflection_pdf<T: Scalar>(self, known: Local<T>, h: Local<T>) -> T {
        T::of(0.25) * self.g1_over_cos(known) * self.d(h)
    }

    /// Returns the density of normals visible from `w`, per solid angle of the normal [Heitz14 (16)].
    #[inline]
    pub fn visible_normal_pdf<T: Scalar>(self, w: Local<T>, h: Local<T>) -> T {
        self.g1_over_cos(w) * w.dot(h).abs() * self.d(h)
    }

    /// Samples a unit normal visible from `w` (above the surface) with two random numbers [Dupuy23].
    #[inline]
    pub fn sample_normal(self, w: Local, u: [f32; 2]) -> Local {
        self.cap_normal(w, lanes::circle(u[0]), u[1])
    }

    /// Returns the random numbers that [`Ggx::sample_normal`] maps to the unit normal `h`.
    #[inline]
    pub fn invert_normal(self, w: Local, h: Local) -> [f32; 2] {
        let view = self.stretch(w);
        let normal = Local::new(h.x, h.y, h.z * self.alpha).normalized();
        let cap = normal.scale(2.0 * view.dot(normal));
        [turn(cap.y - view.y, cap.x - view.x), into_unit(1.0 - cap.z / (1.0 + view.z))]
    }

    /// Returns the visible normal from `w` for a uniform point `circle` of the unit circle and a uniform height `v` of
    /// the spherical cap. The sine of the cap is a product of exact differences, so that nothing cancels.
    #[inline]
    pub fn cap_normal<T: Scalar>(self, w: Local<T>, circle: [T; 2], v: T) -> Local<T> {
        let view = self.stretch(w);
        let top = T::ONE + view.z;
        let z = (T::ONE - v) * top;
        let sine = (top * v * (view.sin2() / top + z)).max(T::ZERO).sqrt();
        let alpha = T::of(f64::from(self.alpha));
        Local::new(alpha * (sine * circle[0] + view.x), alpha * (sine * circle[1] + view.y), z).normalized()
    }

    /// Transforms `w` to the space in which the facets form a hemisphere.
    #[inline]
    fn stretch<T: Scalar>(self, w: Local<T>) -> Local<T> {
        let alpha = T::of(f64::from(self.alpha));
        Local::new(alpha * w.x, alpha * w.y, w.z).normalized()
    }

    /// Returns |cos| (1 + 2 Λ): Smith masking without the tangent.
    #[inline]
    fn root<T: Scalar>(self, w: Local<T>) -> T {
        (w.z.squared() + self.alpha_squared::<T>() * w.sin2()).sqrt()
    }

    #[inline]
    pub(super) fn alpha_squared<T: Scalar>(self) -> T {
        T::of(f64::from(self.alpha)).squared()
    }
}

/// Returns the half vector of two directions on the same side.
#[inline]
pub fn half<T: Scalar>(a: Local<T>, b: Local<T>) -> Local<T> {
    a.plus(b).normalized()
}

/// Reflects `w` about the unit normal `h`.
#[inline]
pub fn reflect<T: Scalar>(w: Local<T>, h: Local<T>) -> Local<T> {
    h.scale(T::of(2.0) * w.dot(h)).plus(w.reversed())
}

/// Mirrors `w` through the surface plane.
#[inline]
pub fn through<T: Scalar>(w: Local<T>) -> Local<T> {
    Local::new(w.x, w.y, -w.z)
}

/// Returns `w` in the frame with `reference` above the surface, for models that are the same from both sides.
#[inline]
pub fn facing<T: Scalar>(w: Local<T>, reference: Local<T>) -> Local<T> {
    if reference.z.value() < 0.0 { through(w) } else { w }
}
