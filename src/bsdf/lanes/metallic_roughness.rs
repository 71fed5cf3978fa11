//! The choice of a model for textured surfaces over lanes: [`MetallicRoughness::surface`] for opaque ones.

use super::Parameters;
use crate::bsdf::MetallicRoughness;
use crate::bsdf::albedo::LaneAlbedo;
use crate::bsdf::ggx::DIRAC_ALPHA;
use crate::spectrum::Spectrum;
use etendue_lanes::{Float, ROW};
use std::f32::consts::FRAC_1_PI;

/// Models and parameters of surfaces that textures make of [`MetallicRoughness`] parameters.
#[derive(Debug, Clone, Copy)]
pub struct LaneMetallicRoughness<F: Float> {
    /// Lanes of [`super::LaneLambert`].
    pub lambert: F::Mask,
    /// Lanes of [`super::LaneConductor`].
    pub conductor: F::Mask,
    /// Lanes of [`super::LaneMetalDielectric`].
    pub metal_dielectric: F::Mask,
    /// Lanes with a mirror, which has no kernel.
    pub mirror: F::Mask,
    /// Columns of the [`Parameters`] of these models.
    columns: [[F; ROW]; 3],
}

impl MetallicRoughness {
    /// Returns it as factors of [`LaneMetallicRoughness`]: opaque, with metal that is white at grazing angles.
    pub fn factors(&self) -> Parameters {
        let (layer, Spectrum([r, g, b])) = (self.layer(), self.base);
        let (Spectrum([f, g0, h]), Spectrum([f90, g90, h90])) = (layer.f0, layer.f90);
        [[r, g, b, self.metallic, self.roughness, 0.0, 0.0, 0.0], [f, g0, h, f90, g90, h90, 0.0, 0.0], [0.0; ROW]]
    }
}

impl<F: Float> LaneMetallicRoughness<F> {
    /// Returns the surfaces with columns of the rows of their [`MetallicRoughness::factors`], times the texture values
    /// `values`: four channels with the colour, then four with roughness and metalness.
    #[inline(always)]
    pub fn new([first, second]: [[F; ROW]; 2], values: [F; ROW]) -> Self {
        let [r, g, b, metallic, roughness, ..] = first;
        let [fr, fg, fb, fr90, fg90, fb90, ..] = second;
        let [vr, vg, vb, _, _, rough, metal, _] = values;
        let base = Spectrum([r * vr, g * vg, b * vb]);
        let (metal, roughness) = (metallic * metal, roughness * rough);
        let [zero, one] = [0.0, 1.0].map(F::splat);
        let alpha = (roughness * roughness).max(zero).min(one);
        let conductor = one.at_most(metal);
        let lambert = !conductor & metal.at_most(zero) & fr90.at_most(zero);
        let mirror = !lambert & alpha.below(F::splat(DIRAC_ALPHA));
        let layer = [Spectrum([fr, fg, fb]), Spectrum([fr90, fg90, fb90])];
        LaneMetallicRoughness {
            lambert: lambert & base.is_lit(),
            conductor: conductor & !mirror,
            metal_dielectric: !(conductor | lambert | mirror),
            mirror,
            columns: Self::columns(base, metal, alpha, layer, lambert),
        }
    }

    /// Returns the columns of mixtures of metal and dielectric, which are those of conductors where `metal` is 1. In the
    /// lanes of `lambert` they are those of its model.
    #[inline(always)]
    fn columns(base: Spectrum<F>, metal: F, alpha: F, layer: [Spectrum<F>; 2], lambert: F::Mask) -> [[F; ROW]; 3] {
        let [zero, one] = [0.0, 1.0].map(F::splat);
        let (dielectric, albedo) = (one - metal, LaneAlbedo::of(alpha));
        let [row, weight, _] = albedo.place();
        let passed = Spectrum::splat(one) - albedo.mean(layer);
        let coupling = passed.map(|x| F::select(x.above(zero), x.recip(), zero));
        let diffuse = base * dielectric;
        let [f0, f90] = layer;
        let mixed = base * metal + f0 * dielectric;
        let Spectrum([a, b, c]) = Spectrum::select(lambert, base, mixed);
        let Spectrum([d, e, f]) = Spectrum::splat(metal) + f90 * dielectric;
        let (Spectrum([g, h, i]), Spectrum([j, k, l])) = (f0, f90);
        let (Spectrum([m, n, o]), Spectrum([p, q, r])) = (diffuse, diffuse * coupling * F::splat(FRAC_1_PI));
        [[a, b, c, d, e, f, alpha, row], [g, h, i, j, k, l, weight, zero], [m, n, o, p, q, r, zero, zero]]
    }

    /// Writes the parameters of the given lanes to `rows`.
    #[inline(always)]
    pub fn store(&self, lanes: u32, rows: &mut [Parameters]) {
        for (number, columns) in self.columns.into_iter().enumerate() {
            F::to_rows(columns, |lane, row| {
                if lanes >> lane & 1 == 1 {
                    rows[lane][number] = row;
                }
            });
        }
    }
}
