//! A thin transparent wall: GGX reflection, and transmission as that reflection mirrored through the surface, without
//! refraction. This is KHR_materials_transmission without a volume [glTF20]; both sides are the same. For windows and
//! leaves modelled as one sheet. Interreflection inside the sheet is left out, as in glTF.

use super::conductor::invert_reflection;
use super::ggx::{Ggx, facing, half, reflect, through};
use super::{Bsdf, BsdfSample, Fresnel, Lobes, within};
use crate::geometry::Local;
use crate::numeric::Scalar;
use crate::sampling::{Density, Pdf};
use crate::spectrum::Spectrum;
use crate::transport::TransportMode;

/// A thin transparent wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thin {
    /// Roughness.
    pub ggx: Ggx,
    /// Reflectance of the facets; the rest is transmitted.
    pub fresnel: Fresnel,
    /// Factor of the transmitted light, 0 to 1.
    pub transmit: Spectrum,
}

impl Thin {
    /// Returns the reflected and transmitted shares of a facet at the incidence cosine `cos`, and the probability of
    /// reflection.
    #[inline]
    fn split<T: Scalar>(&self, cos: T) -> (Spectrum<T>, Spectrum<T>, T) {
        let r = self.fresnel.reflectance(cos);
        let t = (Spectrum::ONE - r) * self.transmit.cast();
        let total = r.mean() + t.mean();
        (r, t, if total.value() > 0.0 { r.mean() / total } else { T::ZERO })
    }

    #[inline]
    fn takes<T: Scalar>(&self, a: Local<T>, b: Local<T>, lobes: Lobes) -> bool {
        let side = if a.same_side(b) { Lobes::REFLECT } else { Lobes::TRANSMIT };
        lobes.intersection(self.lobes()).intersects(side) && (a.z * b.z).value().abs() > 0.0
    }

    /// Samples reflection or unscattered transmission by the shares of [`Thin::split`].
    fn dirac_sample(known: Local, (r, t, p): (Spectrum, Spectrum, f32), lobe: Lobes) -> BsdfSample {
        let mirrored = Local::new(-known.x, -known.y, known.z);
        let (direction, value, probability) =
            if lobe == Lobes::DIRAC_REFLECT { (mirrored, r, p) } else { (through(mirrored), t, 1.0 - p) };
        BsdfSample { direction, value, density: Density::Delta(probability), lobe, eta: 1.0 }
    }
}

/// Returns `w` mirrored to the side of `reference`.
#[inline]
fn folded<T: Scalar>(w: Local<T>, reference: Local<T>) -> Local<T> {
    if w.same_side(reference) { w } else { through(w) }
}

impl Bsdf for Thin {
    #[inline]
    fn eval<T: Scalar>(&self, wi: Local<T>, wo: Local<T>, lobes: Lobes) -> Spectrum<T> {
        if !self.takes(wi, wo, lobes) {
            return Spectrum::ZERO;
        }
        let lit = folded(wi, wo);
        let h = half(lit, wo);
        let (r, t, _) = self.split(wo.dot(h));
        (if wi.same_side(wo) { r } else { t }) * self.ggx.reflection(lit, wo, h)
    }

    #[inline]
    fn sample(&self, known: Local, _: TransportMode, u: [f32; 3]) -> Option<BsdfSample> {
        if self.ggx.is_dirac() {
            let split = self.split(known.z.abs());
            let lobe = if u[0] < split.2 { Lobes::DIRAC_REFLECT } else { Lobes::DIRAC_TRANSMIT };
            return Some(Self::dirac_sample(known, split, lobe));
        }
        let h = facing(self.ggx.sample_normal(facing(known, known), [u[1], u[2]]), known);
        let mirrored = reflect(known, h);
        let (r, t, p) = self.split(known.dot(h));
        let (direction, share, probability, lobe) =
            if u[0] < p { (mirrored, r, p, Lobes::REFLECT) } else { (through(mirrored), t, 1.0 - p, Lobes::TRANSMIT) };
        known.same_side(mirrored).then(|| BsdfSample {
            direction,
            value: share * self.ggx.reflection(mirrored, known, h),
            density: Density::Smooth(Pdf::new(probability * self.ggx.reflection_pdf(known, h))),
            lobe,
            eta: 1.0,
        })
    }

    #[inline]
    fn dirac(&self, known: Local, _: TransportMode, lobe: Lobes) -> Option<BsdfSample> {
        let sample = self.ggx.is_dirac().then(|| Self::dirac_sample(known, self.split(known.z.abs()), lobe))?;
        (sample.density.value() > 0.0).then_some(sample)
    }

    #[inline]
    fn pdf<T: Scalar>(&self, known: Local<T>, other: Local<T>, _: TransportMode, lobes: Lobes) -> T {
        if !self.takes(known, other, lobes) {
            return T::ZERO;
        }
        let h = half(folded(other, known), known);
        let (_, _, p) = self.split(known.dot(h));
        let probability = if known.same_side(other) { p } else { T::ONE - p };
        probability * self.ggx.reflection_pdf(known, h)
    }

    fn invert(&self, known: Local, other: Local, _: TransportMode, aux: [f32; 2]) -> Option<([f32; 3], f64)> {
        if !self.takes(known, other, Lobes::SMOOTH) {
            return None;
        }
        let mirrored = folded(other, known);
        let (_, _, p) = self.split(known.dot(half(mirrored, known)));
        let interval = if known.same_side(other) { [0.0, p] } else { [p, 1.0] };
        let [a, b] = invert_reflection(self.ggx, known, mirrored);
        within(interval, aux[1]).map(|(lobe, log)| ([lobe, a, b], log))
    }

    #[inline]
    fn lobes(&self) -> Lobes {
        if self.ggx.is_dirac() { Lobes::DIRAC } else { Lobes::SMOOTH }
    }
}
