//! Scattering at a point of a surface, in world directions: the one place that knows both normals.
//!
//! The scattering function of transport is F(wi, wo) = f(wi, wo) |wi·ns| / |wi·ng|, zero unless each direction is on the
//! same side of the shading normal ns and of the geometric normal ng [Veach97 §5.3]. It is not symmetric even where f is,
//! which is why the cosines below differ by the way of the walk. Only products that stay finite at grazing angles are
//! offered; |wi·ng| → 0 remains in the light walk's, where the model itself is unbounded.

use super::{Bsdf, Lobes, Surface};
use crate::defects::{Defect, planted};
use crate::geometry::{Local, SurfacePoint};
use crate::sampling::{Density, Pdf, SolidAngle};
use crate::spectrum::Spectrum;
use crate::transport::Transport;
use glam::Vec3;

/// A walk's arrival at a surface: the point, its scattering model and the direction that is known. All directions have unit
/// length and point away from the surface.
#[derive(Debug, Clone, Copy)]
pub struct Shading<'a> {
    /// Where.
    pub point: &'a SurfacePoint,
    /// What scatters there.
    pub surface: &'a Surface,
    known: Vec3,
    local: Local,
    toward: Transport,
}

/// What scatters into a direction that the walk did not choose.
#[derive(Debug, Clone, Copy)]
pub struct Scattering {
    /// F |cos| in that direction, all smooth lobes: cos = wi·ng toward the light, wo·ng toward the camera.
    pub f_cos: Spectrum,
    /// Density of the direction under [`Shading::sample`], all smooth lobes together.
    pub pdf: Pdf<SolidAngle>,
}

/// A sampled direction of a walk.
#[derive(Debug, Clone, Copy)]
pub struct ShadingSample {
    /// Away from the surface, in the world.
    pub direction: Vec3,
    /// What the throughput is multiplied by: F |cos| / density in the sampled direction.
    pub weight: Spectrum,
    /// Density of all smooth lobes together, or the probability of the Dirac direction.
    pub density: Density,
    /// The component that was taken.
    pub lobe: Lobes,
    /// Refractive index on the sampled side over the one on the known side; 1 for reflection. Roulette divides it out.
    pub eta: f32,
}

impl<'a> Shading<'a> {
    /// `surface` at `point`, met along the reverse of `known` by a walk that goes `toward` an end of the path. `None` if the
    /// two normals have `known` on different sides, where nothing scatters.
    #[inline]
    pub fn new(point: &'a SurfacePoint, surface: &'a Surface, known: Vec3, toward: Transport) -> Option<Self> {
        let local = local(point, known)?;
        Some(Shading { point, surface, known, local, toward })
    }

    /// What scatters between the known direction and `other`; `None` where F is zero.
    #[inline]
    pub fn scattering(&self, other: Vec3) -> Option<Scattering> {
        let o = local(self.point, other)?;
        let (f, pdf) = self.surface.eval_and_pdf(self.local, o, self.toward);
        if f.is_black() {
            return None;
        }
        let cos = if planted(Defect::CosineToNg) { self.cos(other) } else { o.z.abs() };
        let f_cos = f * (cos * self.adjoint(other, o));
        Some(Scattering { f_cos, pdf: Pdf::new(pdf) })
    }

    /// F(wi, wo) of the smooth lobes.
    #[inline]
    pub fn f(&self, other: Vec3) -> Spectrum {
        let Some(o) = local(self.point, other) else { return Spectrum::ZERO };
        let (wi, wo) = self.toward.flow((self.known, self.local), (other, o));
        self.surface.eval(wi.1, wo.1, Lobes::SMOOTH) * (wi.1.z.abs() / self.cos(wi.0))
    }

    /// Continues the walk; u = [lobe, direction, direction]. `None` if nothing scatters, or if the direction is on different
    /// sides of the two normals, where F is zero.
    #[inline]
    pub fn sample(&self, u: [f32; 3]) -> Option<ShadingSample> {
        let sample = self.surface.sample(self.local, self.toward, u)?;
        let direction = self.point.frame.to_world(sample.direction);
        if !agree(direction.dot(self.point.ng), sample.direction.z) {
            return None;
        }
        let cos = match sample.density {
            Density::Smooth(pdf) if planted(Defect::CosineDropped) => pdf.value().recip(),
            Density::Smooth(pdf) => sample.direction.z.abs() / pdf.value(),
            Density::Delta(probability) => probability.recip(),
        };
        let weight = sample.value * (cos * self.adjoint(direction, sample.direction));
        Some(ShadingSample { direction, weight, density: sample.density, lobe: sample.lobe, eta: sample.eta })
    }

    /// Density of the known direction in a walk the other way that has come along `other`, all smooth lobes together.
    #[inline]
    pub fn reverse_pdf(&self, other: Vec3) -> Pdf<SolidAngle> {
        let pdf = |o| self.surface.pdf(o, self.local, self.toward.reversed(), Lobes::SMOOTH);
        Pdf::new(local(self.point, other).map_or(0.0, pdf))
    }

    /// What multiple importance sampling compares of `sample`: the density that made it, and that of the known direction in a walk
    /// the other way. A Dirac direction has the probability of its component times |w·ns| η², η the index on the side that w leads
    /// to over that of the known direction: the factor by which a chain of Dirac vertices stretches one way and not the other.
    pub fn densities(&self, sample: &ShadingSample) -> [f64; 2] {
        match sample.density {
            Density::Smooth(pdf) => [pdf, self.reverse_pdf(sample.direction)].map(|p| f64::from(p.value())),
            Density::Delta(probability) => {
                let other = self.point.frame.to_local(sample.direction);
                let back = self.surface.dirac(other, self.toward.reversed(), sample.lobe);
                let back = back.map_or(0.0, |back| back.density.value());
                let eta2 = f64::from(sample.eta).powi(2);
                [f64::from(probability * other.z.abs()) * eta2, f64::from(back * self.local.z.abs())]
            }
        }
    }

    /// Continues the walk along `other`, which was made with density `pdf` by other means than [`Shading::sample`].
    #[inline]
    pub fn along(&self, other: Vec3, pdf: Pdf<SolidAngle>) -> ShadingSample {
        let weight = self.scattering(other).map_or(Spectrum::ZERO, |s| s.f_cos / pdf.value());
        ShadingSample { direction: other, weight, density: Density::Smooth(pdf), lobe: Lobes::SMOOTH, eta: 1.0 }
    }

    /// Numbers that [`Shading::sample`] maps to `other`: see [`Bsdf::invert`].
    pub fn invert(&self, other: Vec3, aux: [f32; 2]) -> Option<([f32; 3], f64)> {
        self.surface.invert(self.local, local(self.point, other)?, self.toward, aux)
    }

    /// The direction that is known.
    #[inline]
    pub fn known(&self) -> Vec3 {
        self.known
    }

    /// The components of the surface.
    #[inline]
    pub fn lobes(&self) -> Lobes {
        self.surface.lobes()
    }

    /// |w·ng|.
    #[inline]
    fn cos(&self, w: Vec3) -> f32 {
        w.dot(self.point.ng).abs()
    }

    /// The weight of a walk over f |cos| / density, the cosine to ns in the other direction: 1 toward the light,
    /// |wi·ns| |wo·ng| / (|wi·ng| |wo·ns|) toward the camera [Veach97 (5.19)].
    #[inline]
    fn adjoint(&self, other: Vec3, o: Local) -> f32 {
        match self.toward {
            Transport::Light => 1.0,
            Transport::Camera if planted(Defect::AdjointForgotten) => 1.0,
            Transport::Camera => (self.local.z / self.cos(self.known)).abs() * (self.cos(other) / o.z).abs(),
        }
    }
}

/// `w` in the shading frame, if both normals have it on the same side.
#[inline]
fn local(point: &SurfacePoint, w: Vec3) -> Option<Local> {
    let local = point.frame.to_local(w);
    agree(w.dot(point.ng), local.z).then_some(local)
}

/// Whether a direction of cosines `geometric` and `shading` is on one side of both normals.
#[inline]
fn agree(geometric: f32, shading: f32) -> bool {
    (geometric > 0.0 && shading > 0.0) || (geometric < 0.0 && shading < 0.0)
}
