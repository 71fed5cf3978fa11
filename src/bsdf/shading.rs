//! Scattering at a point of a surface, in world directions: the one place that knows both normals.
//!
//! The scattering function of transport is F(wi, wo) = f(wi, wo) |wi·ns| / |wi·ng|, zero unless each direction is on the
//! same side of the shading normal ns and of the geometric normal ng [Veach97 §5.3]. It is not symmetric even where f is,
//! which is why the cosines below differ by the way of the walk. Only products that stay finite at grazing angles are
//! offered; |wi·ng| → 0 remains in the light walk's, where the model itself is unbounded.

use super::{Bsdf, Lobes, Surface};
use crate::geometry::{Local, SurfacePoint};
use crate::sampling::{Density, Pdf, SolidAngle};
use crate::spectrum::Spectrum;
use crate::transport::Transport;
use glam::Vec3;

/// A surface point with its scattering model. All directions have unit length and point away from the surface.
#[derive(Debug, Clone, Copy)]
pub struct Shading<'a> {
    /// Where.
    pub point: &'a SurfacePoint,
    /// What scatters there.
    pub surface: &'a Surface,
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
    /// `surface` at `point`.
    #[inline]
    pub fn new(point: &'a SurfacePoint, surface: &'a Surface) -> Self {
        Shading { point, surface }
    }

    /// F(wi, wo) |wi·ng| of the smooth lobes: what a camera walk at `wo` gets from light along `wi`.
    #[inline]
    pub fn f_cos_light(&self, wi: Vec3, wo: Vec3) -> Spectrum {
        match (self.local(wi), self.local(wo)) {
            (Some(i), Some(o)) => self.surface.eval(i, o, Lobes::SMOOTH) * i.z.abs(),
            _ => Spectrum::ZERO,
        }
    }

    /// F(wi, wo) |wo·ng| of the smooth lobes: what a light walk at `wi` sends along `wo`.
    #[inline]
    pub fn f_cos_camera(&self, wi: Vec3, wo: Vec3) -> Spectrum {
        match (self.local(wi), self.local(wo)) {
            (Some(i), Some(o)) => self.surface.eval(i, o, Lobes::SMOOTH) * (i.z.abs() * self.cos(wo) / self.cos(wi)),
            _ => Spectrum::ZERO,
        }
    }

    /// F(wi, wo) of the smooth lobes, for connections and merges.
    #[inline]
    pub fn f(&self, wi: Vec3, wo: Vec3) -> Spectrum {
        match (self.local(wi), self.local(wo)) {
            (Some(i), Some(o)) => self.surface.eval(i, o, Lobes::SMOOTH) * (i.z.abs() / self.cos(wi)),
            _ => Spectrum::ZERO,
        }
    }

    /// Continues a walk that knows one direction; u = [lobe, direction, direction]. `None` if nothing scatters, or if the
    /// direction is on different sides of the two normals, where F is zero.
    #[inline]
    pub fn sample(&self, known: Vec3, toward: Transport, u: [f32; 3]) -> Option<ShadingSample> {
        let k = self.local(known)?;
        let sample = self.surface.sample(k, toward, u)?;
        let direction = self.point.frame.to_world(sample.direction);
        if !agree(direction.dot(self.point.ng), sample.direction.z) {
            return None;
        }
        let cos = match sample.density {
            Density::Smooth(pdf) => sample.direction.z.abs() / pdf.value(),
            Density::Delta(probability) => probability.recip(),
        };
        let weight = sample.value * (cos * self.adjoint(known, k, direction, sample.direction, toward));
        Some(ShadingSample { direction, weight, density: sample.density, lobe: sample.lobe, eta: sample.eta })
    }

    /// Continues a camera walk at `wo` along `wi`, which was made with density `pdf` by other means than [`Shading::sample`].
    #[inline]
    pub fn along(&self, wi: Vec3, wo: Vec3, pdf: Pdf<SolidAngle>) -> ShadingSample {
        let weight = self.f_cos_light(wi, wo) / pdf.value();
        ShadingSample { direction: wi, weight, density: Density::Smooth(pdf), lobe: Lobes::SMOOTH, eta: 1.0 }
    }

    /// Density of `other` under [`Shading::sample`], all smooth lobes together; zero where F is.
    #[inline]
    pub fn pdf(&self, known: Vec3, other: Vec3, toward: Transport) -> Pdf<SolidAngle> {
        match (self.local(known), self.local(other)) {
            (Some(k), Some(o)) => Pdf::new(self.surface.pdf(k, o, toward, Lobes::SMOOTH)),
            _ => Pdf::new(0.0),
        }
    }

    /// Numbers that [`Shading::sample`] maps to `other`: see [`Bsdf::invert`].
    pub fn invert(&self, known: Vec3, other: Vec3, toward: Transport, aux: [f32; 2]) -> Option<([f32; 3], f64)> {
        self.surface.invert(self.local(known)?, self.local(other)?, toward, aux)
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

    /// `w` in the shading frame, if both normals have it on the same side.
    #[inline]
    fn local(&self, w: Vec3) -> Option<Local> {
        let local = self.point.frame.to_local(w);
        agree(w.dot(self.point.ng), local.z).then_some(local)
    }

    /// The weight of a walk over f |cos| / density, the cosine to ns in the sampled direction: 1 toward the light,
    /// |wi·ns| |wo·ng| / (|wi·ng| |wo·ns|) toward the camera [Veach97 (5.19)].
    #[inline]
    fn adjoint(&self, known: Vec3, k: Local, sampled: Vec3, s: Local, toward: Transport) -> f32 {
        match toward {
            Transport::Light => 1.0,
            Transport::Camera => (k.z / self.cos(known)).abs() * (self.cos(sampled) / s.z).abs(),
        }
    }
}

/// Whether a direction of cosines `geometric` and `shading` is on one side of both normals.
#[inline]
fn agree(geometric: f32, shading: f32) -> bool {
    (geometric > 0.0 && shading > 0.0) || (geometric < 0.0 && shading < 0.0)
}
