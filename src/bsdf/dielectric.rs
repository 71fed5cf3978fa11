//! Boundary of a clear solid: reflection and refraction by GGX facets or a smooth face, with exact Fresnel. Inside is
//! z < 0. For closed glass bodies; for single sheets see [`super::Thin`].
//!
//! Values are for radiance transport: F(wi, wo) / η²_o = F(wo, wi) / η²_i. A camera subpath that enters glass gains
//! 1 / η², and a light subpath does not. Refraction uses independent Smith masking of both directions. Its exact height
//! correlation is a Beta function, closer to the product than to the formula for reflection [Heitz14 §5]. Single
//! scattering between facets only. Reference: [Walter07].

use super::conductor::invert_reflection;
use super::fresnel::{dielectric, dielectric_between, refracted};
use super::ggx::{DIRAC_ALPHA, Ggx, facing, half, reflect};
use super::{Bsdf, BsdfSample, Lobes, within};
use crate::geometry::Local;
use crate::numeric::Scalar;
use crate::sampling::{Density, Pdf};
use crate::spectrum::Spectrum;
use crate::transport::TransportMode;

/// The boundary of a clear solid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dielectric {
    /// Roughness.
    pub ggx: Ggx,
    /// Refractive index inside over outside; finite and above 0.
    pub eta: f32,
    /// Factor of reflected light, 0 to 1.
    pub reflect: Spectrum,
    /// Factor of refracted light, 0 to 1.
    pub transmit: Spectrum,
}

/// A facet that refracts one direction into another.
struct RefractingFacet<T> {
    /// Unit normal on the side of the known direction.
    h: Local<T>,
    /// Refractive index on the other side over the one on the known side.
    eta: T,
    /// |known + η other|².
    length2: T,
    /// Reflectance.
    f: T,
}

impl Dielectric {
    /// Whether both sides have the same refractive index: there is neither refraction nor reflection.
    #[inline]
    pub(super) fn is_matched(&self) -> bool {
        (self.eta - 1.0).abs() <= 0.0
    }

    /// Whether the boundary counts as smooth. Refraction spreads by α |η − 1|, so that it does for small roughness and
    /// also for nearly matched media (whose half vector vanishes).
    #[inline]
    pub fn is_dirac(&self) -> bool {
        self.ggx.alpha() * (self.eta - 1.0).abs().min(1.0) < DIRAC_ALPHA
    }

    /// Returns the scattered share at incidence cosine |cos| of `known` on a smooth face, mean over lanes.
    #[inline]
    pub(super) fn throughput<T: Scalar>(&self, known: Local<T>) -> T {
        let f = dielectric(known.z.abs(), self.beyond(known));
        f * T::of(f64::from(self.reflect.mean())) + (T::ONE - f) * T::of(f64::from(self.transmit.mean()))
    }

    /// Returns the refractive index on the other side over the one on the side of `w`.
    #[inline]
    fn beyond<T: Scalar>(&self, w: Local<T>) -> T {
        let eta = T::of(f64::from(self.eta));
        if w.z.value() > 0.0 { eta } else { eta.recip() }
    }

    /// Returns the probability of selecting reflection at a facet of reflectance `f`.
    #[inline]
    fn reflect_probability<T: Scalar>(&self, f: T) -> T {
        let r = f * T::of(f64::from(self.reflect.mean()));
        let t = (T::ONE - f) * T::of(f64::from(self.transmit.mean()));
        if (r + t).value() > 0.0 { r / (r + t) } else { T::ZERO }
    }

    /// Returns the facet between directions on opposite sides [Walter07 (16)]; `None` if one of them sees its back.
    #[inline]
    fn refracting_facet<T: Scalar>(&self, known: Local<T>, other: Local<T>) -> Option<RefractingFacet<T>> {
        let eta = self.beyond(known);
        let sum = known.plus(other.scale(eta));
        let length2 = sum.dot(sum);
        let upright = if sum.same_side(known) { sum } else { sum.reversed() };
        let h = upright.scale(length2.sqrt().recip());
        let (cos, beyond) = (known.dot(h), other.reversed().dot(h));
        let seen = cos.value() > 0.0 && beyond.value() > 0.0;
        seen.then(|| RefractingFacet { h, eta, length2, f: dielectric_between(cos, eta * beyond, eta) })
    }

    /// Returns f of refraction at `h` without the measure factor η²_o / |η_i wi + η_o wo|² [Walter07 (21)].
    #[inline]
    fn refraction<T: Scalar>(&self, a: Local<T>, b: Local<T>, h: Local<T>, f: T) -> Spectrum<T> {
        let shape = self.ggx.d(h) * self.ggx.g1_over_cos(a) * self.ggx.g1_over_cos(b);
        self.transmit.cast() * ((T::ONE - f) * a.dot(h).abs() * b.dot(h).abs() * shape)
    }

    /// Returns the reflectance of the smooth face, and the probability of selecting reflection.
    #[inline]
    fn smooth_face(&self, known: Local) -> (f32, f32) {
        let f = dielectric(known.z.abs(), self.beyond(known));
        (f, self.reflect_probability(f))
    }

    /// Samples reflection or refraction by the smooth face.
    fn dirac_sample(&self, known: Local, mode: TransportMode, (f, p): (f32, f32), lobe: Lobes) -> BsdfSample {
        let eta = self.beyond(known);
        if lobe == Lobes::DIRAC_REFLECT {
            return BsdfSample {
                direction: Local::new(-known.x, -known.y, known.z),
                value: self.reflect * f,
                density: Density::Delta(p),
                lobe: Lobes::DIRAC_REFLECT,
                eta: 1.0,
            };
        }
        let g = refracted(known.z.abs(), eta).max(0.0).sqrt();
        BsdfSample {
            direction: Local::new(-known.x / eta, -known.y / eta, (-g / eta).copysign(-known.z)),
            value: self.transmit * ((1.0 - f) * radiance_scale(eta, mode)),
            density: Density::Delta(1.0 - p),
            lobe: Lobes::DIRAC_TRANSMIT,
            eta,
        }
    }

    fn sample_reflection(&self, known: Local, h: Local, f: f32, p: f32) -> Option<BsdfSample> {
        let other = reflect(known, h);
        known.same_side(other).then(|| BsdfSample {
            direction: other,
            value: self.reflect * (f * self.ggx.reflection(known, other, h)),
            density: Density::Smooth(Pdf::new(p * self.ggx.reflection_pdf(known, h))),
            lobe: Lobes::REFLECT,
            eta: 1.0,
        })
    }

    fn sample_refraction(&self, known: Local, mode: TransportMode, h: Local, f: f32, p: f32) -> Option<BsdfSample> {
        let eta = self.beyond(known);
        let cos = known.dot(h);
        let g2 = refracted(cos, eta);
        if g2 <= 0.0 {
            return None;
        }
        // cos − g without cancellation: this is also the length of known + η other.
        let length = (1.0 - eta) * (1.0 + eta) / (cos + g2.sqrt());
        let other = h.scale(length).plus(known.reversed()).scale(eta.recip());
        let measure = eta * eta / (length * length);
        let density = p * self.ggx.visible_normal_pdf(known, h) * other.dot(h).abs() * measure;
        (known.z * other.z < 0.0).then(|| BsdfSample {
            direction: other,
            value: self.refraction(known, other, h, f) * (measure * radiance_scale(eta, mode)),
            density: Density::Smooth(Pdf::new(density)),
            lobe: Lobes::TRANSMIT,
            eta,
        })
    }
}

/// Returns the factor of refraction for radiance relative to importance. Light leaves on the known side in a camera
/// subpath.
#[inline]
fn radiance_scale(eta: f32, mode: TransportMode) -> f32 {
    match mode {
        TransportMode::Radiance => (eta * eta).recip(),
        TransportMode::Importance => 1.0,
    }
}

impl Bsdf for Dielectric {
    #[inline]
    fn eval<T: Scalar>(&self, wi: Local<T>, wo: Local<T>, lobes: Lobes) -> Spectrum<T> {
        let lobes = lobes.intersection(self.lobes());
        if wi.same_side(wo) {
            if !lobes.intersects(Lobes::REFLECT) {
                return Spectrum::ZERO;
            }
            let h = half(wi, wo);
            let f = dielectric(wi.dot(h), self.beyond(wi));
            return self.reflect.cast() * (f * self.ggx.reflection(wi, wo, h));
        }
        if !opposite(wi, wo) || !lobes.intersects(Lobes::TRANSMIT) {
            return Spectrum::ZERO;
        }
        self.refracting_facet(wi, wo).map_or(Spectrum::ZERO, |facet| {
            self.refraction(wi, wo, facet.h, facet.f) * (facet.eta.squared() / facet.length2)
        })
    }

    #[inline]
    fn sample(&self, known: Local, mode: TransportMode, u: [f32; 3]) -> Option<BsdfSample> {
        if self.is_dirac() {
            let face = self.smooth_face(known);
            let lobe = if u[0] < face.1 { Lobes::DIRAC_REFLECT } else { Lobes::DIRAC_TRANSMIT };
            return Some(self.dirac_sample(known, mode, face, lobe));
        }
        let h = facing(self.ggx.sample_normal(facing(known, known), [u[1], u[2]]), known);
        let f = dielectric(known.dot(h), self.beyond(known));
        let p = self.reflect_probability(f);
        if u[0] < p {
            self.sample_reflection(known, h, f, p)
        } else {
            self.sample_refraction(known, mode, h, f, 1.0 - p)
        }
    }

    #[inline]
    fn dirac(&self, known: Local, mode: TransportMode, lobe: Lobes) -> Option<BsdfSample> {
        let sample = self.is_dirac().then(|| self.dirac_sample(known, mode, self.smooth_face(known), lobe))?;
        (sample.density.value() > 0.0).then_some(sample)
    }

    #[inline]
    fn pdf<T: Scalar>(&self, known: Local<T>, other: Local<T>, _: TransportMode, lobes: Lobes) -> T {
        let lobes = lobes.intersection(self.lobes());
        if known.same_side(other) {
            if !lobes.intersects(Lobes::REFLECT) {
                return T::ZERO;
            }
            let h = half(known, other);
            let f = dielectric(known.dot(h), self.beyond(known));
            return self.reflect_probability(f) * self.ggx.reflection_pdf(known, h);
        }
        if !opposite(known, other) || !lobes.intersects(Lobes::TRANSMIT) {
            return T::ZERO;
        }
        self.refracting_facet(known, other).map_or(T::ZERO, |facet| {
            let p = T::ONE - self.reflect_probability(facet.f);
            let measure = facet.eta.squared() / facet.length2;
            p * self.ggx.visible_normal_pdf(known, facet.h) * other.dot(facet.h).abs() * measure
        })
    }

    fn invert(&self, known: Local, other: Local, _: TransportMode, aux: [f32; 2]) -> Option<([f32; 3], f64)> {
        if self.is_dirac() {
            return None;
        }
        let ([a, b], h, reflects) = if known.same_side(other) {
            (invert_reflection(self.ggx, known, other), half(known, other), true)
        } else {
            let h = self.refracting_facet(known, other)?.h;
            (self.ggx.invert_normal(facing(known, known), facing(h, known)), h, false)
        };
        let p = self.reflect_probability(dielectric(known.dot(h), self.beyond(known)));
        let interval = if reflects { [0.0, p] } else { [p, 1.0] };
        within(interval, aux[1]).map(|(lobe, log)| ([lobe, a, b], log))
    }

    #[inline]
    fn lobes(&self) -> Lobes {
        if self.is_dirac() { Lobes::DIRAC } else { Lobes::SMOOTH }
    }
}

/// Whether the directions are on opposite sides of the surface.
#[inline]
fn opposite<T: Scalar>(a: Local<T>, b: Local<T>) -> bool {
    (a.z * b.z).value() < 0.0
}
