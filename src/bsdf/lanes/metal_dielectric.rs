//! [`crate::bsdf::MetalDielectric`] over lanes, rough and opaque.

use super::lambert::{cosine_direction, cosine_pdf};
use super::{LaneConductor, LanePoint, LaneScatter, LocalSample};
use crate::bsdf::Shares;
use crate::bsdf::albedo::LaneMoments;
use crate::spectrum::{LANES, Spectrum};
use etendue_lanes::{Float, ROW, Vec3};

/// A diffuse base under a layer that reflects, or metal, or a mixture of both.
#[derive(Debug, Clone, Copy)]
pub struct LaneMetalDielectric<F: Float> {
    specular: LaneConductor<F>,
    layer: [Spectrum<F>; 2],
    /// Place of the albedo in its table.
    albedo: [F; 3],
    /// The base over π, coupled with the layer.
    base: Spectrum<F>,
    /// Selection probabilities of reflection and base for the known direction.
    choice: [F; 2],
    /// Transmittance of the layer for the known direction.
    below: Spectrum<F>,
    /// Lanes that reflect anything.
    is_lit: F::Mask,
}

#[inline(always)]
fn mean<F: Float>(Spectrum([r, g, b]): Spectrum<F>) -> F {
    (r + g + b) / F::splat(LANES as f32)
}

impl<F: Float> LaneMetalDielectric<F> {
    /// Returns what the layer lets through of a direction with these moments.
    #[inline(always)]
    fn passed(layer: [Spectrum<F>; 2], moments: &LaneMoments<F>) -> Spectrum<F> {
        let one = Spectrum::splat(F::splat(1.0));
        (one - moments.albedo(layer)).map(|x| x.max(F::splat(0.0)))
    }
}

impl<F: Float> LaneScatter<F> for LaneMetalDielectric<F> {
    const HAS_LOBES: bool = true;

    #[inline(always)]
    fn new([first, second, third]: [[F; ROW]; 3], point: &LanePoint<F>) -> Self {
        let [r, g, b, r90, g90, b90, alpha, row] = first;
        let (f0, f90) = (Spectrum([r, g, b]), Spectrum([r90, g90, b90]));
        let [r, g, b, r90, g90, b90, weight, _] = second;
        let layer = [Spectrum([r, g, b]), Spectrum([r90, g90, b90])];
        let [r, g, b, base_r, base_g, base_b, ..] = third;
        let (diffuse, base) = (Spectrum([r, g, b]), Spectrum([base_r, base_g, base_b]));
        let albedo = [row, weight, alpha];
        let moments = LaneMoments::new(albedo, point.known.z.abs());
        let below = Self::passed(layer, &moments);
        let (specular, diffuse) = (mean(moments.albedo([f0, f90])), mean(diffuse * below));
        let total = specular + diffuse;
        let k = total.recip();
        LaneMetalDielectric {
            specular: LaneConductor::of(f0, f90, alpha),
            layer,
            albedo,
            base,
            choice: [specular * k, diffuse * k],
            below,
            is_lit: total.above(F::splat(0.0)),
        }
    }

    #[inline(always)]
    fn shares(&self) -> Shares<F> {
        let [zero, one] = [0.0, 1.0].map(F::splat);
        let ([glossy, diffuse], lit) = (self.choice, self.is_lit);
        let alpha = F::select(lit, self.specular.shares().alpha2, one);
        Shares { diffuse: F::select(lit, diffuse, one), glossy: F::select(lit, glossy, zero), alpha2: alpha }
    }

    #[inline(always)]
    fn eval_and_pdf(&self, known: Vec3<F>, other: Vec3<F>) -> (Spectrum<F>, F) {
        let below = self.below * Self::passed(self.layer, &LaneMoments::new(self.albedo, other.z.abs()));
        let (reflected, facets) = self.specular.eval_and_pdf(known, other);
        let [specular, diffuse] = self.choice;
        let zero = F::splat(0.0);
        let value = self.base * below + reflected;
        let pdf = specular * facets + diffuse * cosine_pdf(other);
        (value.map(|x| F::select(self.is_lit, x, zero)), F::select(self.is_lit, pdf, zero))
    }

    #[inline(always)]
    fn sample(&self, known: Vec3<F>, [lobe, u, v]: [F; 3]) -> LocalSample<F> {
        let glossy = lobe.below(self.choice[0]);
        let (facet, found) = self.specular.direction(known, [u, v]);
        let w = Vec3::select(glossy, facet, cosine_direction(known, [u, v]));
        let (value, pdf) = self.eval_and_pdf(known, w);
        let zero = F::splat(0.0);
        let valid = self.is_lit & (found | !glossy) & (known.z * w.z).above(zero) & pdf.above(zero);
        LocalSample { w, value, pdf, valid }
    }
}
