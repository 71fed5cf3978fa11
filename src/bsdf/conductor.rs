//! Reflection by GGX facets or a mirror, the same on both sides: metals, and any opaque gloss. Single scattering
//! between facets only. References: [Walter07], [Heitz14].

use super::ggx::{Ggx, facing, half, reflect, through};
use super::{Bsdf, BsdfSample, Fresnel, Lobes};
use crate::geometry::Local;
use crate::numeric::Scalar;
use crate::sampling::{Density, Pdf};
use crate::spectrum::Spectrum;
use crate::transport::TransportMode;

/// A reflecting surface that absorbs what its facets do not reflect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conductor {
    /// Roughness.
    pub ggx: Ggx,
    /// Reflectance of the facets.
    pub fresnel: Fresnel,
}

impl Conductor {
    fn mirror(&self, known: Local) -> BsdfSample {
        BsdfSample {
            direction: Local::new(-known.x, -known.y, known.z),
            value: self.fresnel.reflectance(known.z.abs()),
            density: Density::Delta(1.0),
            lobe: Lobes::DIRAC_REFLECT,
            eta: 1.0,
        }
    }

    fn scatters<T: Scalar>(&self, a: Local<T>, b: Local<T>, lobes: Lobes) -> bool {
        a.same_side(b) && lobes.intersects(self.lobes().intersection(Lobes::REFLECT))
    }
}

impl Bsdf for Conductor {
    #[inline]
    fn eval<T: Scalar>(&self, wi: Local<T>, wo: Local<T>, lobes: Lobes) -> Spectrum<T> {
        if !self.scatters(wi, wo, lobes) {
            return Spectrum::ZERO;
        }
        let h = half(wi, wo);
        self.fresnel.reflectance(wi.dot(h)) * self.ggx.reflection(wi, wo, h)
    }

    #[inline]
    fn sample(&self, known: Local, _: TransportMode, u: [f32; 3]) -> Option<BsdfSample> {
        if self.ggx.is_dirac() {
            return Some(self.mirror(known));
        }
        let above = facing(known, known);
        let h = self.ggx.sample_normal(above, [u[1], u[2]]);
        let other = reflect(above, h);
        above.same_side(other).then(|| BsdfSample {
            direction: facing(other, known),
            value: self.fresnel.reflectance(above.dot(h)) * self.ggx.reflection(other, above, h),
            density: Density::Smooth(Pdf::new(self.ggx.reflection_pdf(above, h))),
            lobe: Lobes::REFLECT,
            eta: 1.0,
        })
    }

    #[inline]
    fn dirac(&self, known: Local, _: TransportMode, lobe: Lobes) -> Option<BsdfSample> {
        (self.ggx.is_dirac() && lobe == Lobes::DIRAC_REFLECT).then(|| self.mirror(known))
    }

    #[inline]
    fn pdf<T: Scalar>(&self, known: Local<T>, other: Local<T>, _: TransportMode, lobes: Lobes) -> T {
        if self.scatters(known, other, lobes) { self.ggx.reflection_pdf(known, half(known, other)) } else { T::ZERO }
    }

    fn invert(&self, known: Local, other: Local, _: TransportMode, aux: [f32; 2]) -> Option<([f32; 3], f64)> {
        self.scatters(known, other, Lobes::REFLECT).then(|| {
            let [a, b] = invert_reflection(self.ggx, known, other);
            ([aux[1], a, b], 0.0)
        })
    }

    #[inline]
    fn lobes(&self) -> Lobes {
        if self.ggx.is_dirac() { Lobes::DIRAC_REFLECT } else { Lobes::REFLECT }
    }
}

/// Returns the random numbers of the normal that reflects `known` to `other`, on either side.
pub(super) fn invert_reflection(ggx: Ggx, known: Local, other: Local) -> [f32; 2] {
    let above = facing(known, known);
    ggx.invert_normal(above, half(above, if known.z < 0.0 { through(other) } else { other }))
}
