//! Scattering over lanes, toward the light, of models without Dirac components. Each lane has the bits of
//! [`super::Shading`] with the same surface.
//!
//! Lanes in which the two normals disagree about a direction, so that its mirror image counts, are not answered but
//! named: `doubtful`. With one normal for both, only rounding at grazing angles does that.

mod conductor;
mod lambert;
mod metal_dielectric;
mod metallic_roughness;
#[cfg(test)]
mod tests;

pub use conductor::LaneConductor;
pub use lambert::LaneLambert;
pub use metal_dielectric::LaneMetalDielectric;
pub use metallic_roughness::LaneMetallicRoughness;

use super::{Conductor, Fresnel, Lambert, Shares, Surface};
use crate::geometry::lanes::tangents;
use crate::spectrum::Spectrum;
use etendue_lanes::{Float, ROW, Vec3};

/// Parameters of a surface, as rows of numbers.
pub type Parameters = [[f32; ROW]; 3];

/// A surface as parameters of a model that has a kernel.
#[derive(Debug, Clone, Copy)]
pub struct LaneSurface {
    /// The model.
    pub model: LaneModel,
    /// Its parameters, as [`LaneScatter::new`] reads them.
    pub parameters: Parameters,
}

/// Models that have a kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LaneModel {
    /// See [`LaneLambert`].
    Lambert,
    /// See [`LaneConductor`].
    Conductor,
    /// See [`LaneMetalDielectric`].
    MetalDielectric,
}

impl LaneSurface {
    /// Returns the parameters of `surface`; `None` if its model has no kernel.
    pub fn new(surface: &Surface) -> Option<Self> {
        let zero = [0.0; ROW];
        match surface {
            Surface::Lambert(Lambert { albedo: Spectrum([r, g, b]) }) => {
                let parameters = [[*r, *g, *b, 0.0, 0.0, 0.0, 0.0, 0.0], zero, zero];
                Some(LaneSurface { model: LaneModel::Lambert, parameters })
            }
            Surface::Conductor(Conductor { ggx, fresnel: Fresnel::Schlick { f0, f90 } }) if !ggx.is_dirac() => {
                let ([a, b, c], [d, e, f]) = (f0.0, f90.0);
                let parameters = [[a, b, c, d, e, f, ggx.alpha(), 0.0], zero, zero];
                Some(LaneSurface { model: LaneModel::Conductor, parameters })
            }
            Surface::MetalDielectric(mixture) => {
                let parameters = mixture.parameters()?;
                Some(LaneSurface { model: LaneModel::MetalDielectric, parameters })
            }
            _ => None,
        }
    }
}

/// Surface points at which light leaves along known directions.
#[derive(Debug, Clone, Copy)]
pub struct LanePoint<F: Float> {
    /// Shading normal.
    n: Vec3<F>,
    /// Geometric normal.
    ng: Vec3<F>,
    /// Tangents, which make a frame with `n`.
    tangents: [Vec3<F>; 2],
    /// Unit directions away from the surfaces, in the frames.
    known: Vec3<F>,
    /// Lanes in which light may leave along the known direction: it is not in the plane of the surface.
    pub scatters: F::Mask,
    /// Lanes in which the normals disagree about the known direction.
    pub doubtful: F::Mask,
}

/// Values and densities of directions.
#[derive(Debug, Clone, Copy)]
pub struct LaneScattering<F: Float> {
    /// F |cos|.
    pub f_cos: Spectrum<F>,
    /// Density under sampling.
    pub pdf: F,
    /// Lanes in which anything is scattered.
    pub valid: F::Mask,
    /// Lanes in which another direction counts as well, so that the fields mean nothing.
    pub doubtful: F::Mask,
}

/// Sampled directions.
#[derive(Debug, Clone, Copy)]
pub struct LaneSample<F: Float> {
    /// Unit direction away from the surface.
    pub direction: Vec3<F>,
    /// F |cos| over the density.
    pub weight: Spectrum<F>,
    /// Density of the direction.
    pub pdf: F,
    /// Lanes in which a direction was found.
    pub valid: F::Mask,
    /// Lanes in which another direction counts in place of it or as well, so that the fields mean nothing.
    pub doubtful: F::Mask,
}

/// A local direction found by a model.
#[derive(Debug, Clone, Copy)]
pub struct LocalSample<F: Float> {
    w: Vec3<F>,
    value: Spectrum<F>,
    pdf: F,
    valid: F::Mask,
}

impl<F: Float> LanePoint<F> {
    /// Returns the points with shading normals `n`, geometric normals `ng` and known directions `wo`.
    #[inline(always)]
    pub fn new([n, ng]: [Vec3<F>; 2], wo: Vec3<F>) -> Self {
        let tangents = tangents(n);
        let known = local(n, tangents, wo);
        let (side, zero) = (known.z * wo.dot(ng), F::splat(0.0));
        LanePoint { n, ng, tangents, known, scatters: side.above(zero), doubtful: side.below(zero) }
    }

    /// Returns the world directions whose local coordinates are `w`.
    #[inline(always)]
    fn world(&self, w: Vec3<F>) -> Vec3<F> {
        let [s, t] = self.tangents;
        s * w.x + t * w.y + self.n * w.z
    }

    /// Returns the lanes in which two local directions lead to the direction of local height `z` and cosine `cos` to
    /// the geometric normal: see [`super::sides::Sided::is_met_twice`].
    #[inline(always)]
    fn is_met_twice(&self, z: F, cos: F) -> F::Mask {
        let slant = self.n.dot(self.ng);
        ((z - F::splat(2.0) * cos * slant) * cos).above(F::splat(0.0))
    }
}

#[inline(always)]
fn local<F: Float>(n: Vec3<F>, [s, t]: [Vec3<F>; 2], w: Vec3<F>) -> Vec3<F> {
    Vec3::new(w.dot(s), w.dot(t), w.dot(n))
}

/// A model with parameters in lanes, for known directions.
pub trait LaneScatter<F: Float>: Copy {
    /// Whether sampling needs a number that selects a lobe.
    const HAS_LOBES: bool = false;
    /// Returns the surfaces at `point`, of which `columns` are those of the rows of their [`Parameters`].
    fn new(columns: [[F; ROW]; 3], point: &LanePoint<F>) -> Self;
    /// See [`super::Shading::outline`].
    fn shares(&self) -> Shares<F>;
    /// Returns value and density of the local direction `other`, on the side of the known one.
    fn eval_and_pdf(&self, known: Vec3<F>, other: Vec3<F>) -> (Spectrum<F>, F);
    /// Samples a local direction with u = [lobe, direction, direction].
    fn sample(&self, known: Vec3<F>, u: [F; 3]) -> LocalSample<F>;

    /// See [`super::Shading::scattering`].
    #[inline(always)]
    fn scattering(&self, point: &LanePoint<F>, wi: Vec3<F>) -> LaneScattering<F> {
        let other = local(point.n, point.tangents, wi);
        let (cos, zero) = (wi.dot(point.ng), F::splat(0.0));
        let (f, pdf) = self.eval_and_pdf(point.known, other);
        let f_cos = f * other.z.abs();
        let agrees = (other.z * cos).above(zero);
        let valid = agrees & (point.known.z * other.z).above(zero) & f_cos.is_lit();
        LaneScattering { f_cos, pdf, valid, doubtful: agrees & point.is_met_twice(other.z, cos) }
    }

    /// See [`super::Shading::sample`].
    #[inline(always)]
    fn sampled(&self, point: &LanePoint<F>, u: [F; 3]) -> LaneSample<F> {
        let LocalSample { w, value, pdf, valid } = self.sample(point.known, u);
        let direction = point.world(w);
        let cos = direction.dot(point.ng);
        let doubtful = !(cos * w.z).above(F::splat(0.0)) | point.is_met_twice(w.z, cos);
        LaneSample { direction, weight: value * (w.z.abs() / pdf), pdf, valid, doubtful: valid & doubtful }
    }
}
