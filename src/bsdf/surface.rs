//! The closed set of scattering models, dispatched by `match`.

use super::{Bsdf, BsdfSample, Conductor, Dielectric, Lambert, Lobes, MetalDielectric, ScatteringBound, Shares, Thin};
use crate::geometry::Local;
use crate::numeric::Scalar;
use crate::spectrum::Spectrum;
use crate::transport::TransportMode;
use std::f32::consts::FRAC_1_PI;

/// Any scattering model with its parameters at one point.
#[derive(Debug, Clone, Copy)]
pub enum Surface {
    /// No scattering: emitters and unlit materials.
    Black,
    /// Ideal diffuse reflection.
    Lambert(Lambert),
    /// GGX or mirror reflection.
    Conductor(Conductor),
    /// The boundary of a clear solid.
    Dielectric(Dielectric),
    /// A thin transparent wall.
    Thin(Thin),
    /// A mixture of metal and dielectric.
    MetalDielectric(MetalDielectric),
}

impl Surface {
    /// Whether [`Bsdf::sample`] has a single lobe and ignores its first random number.
    #[inline]
    pub fn is_single_lobe(&self) -> bool {
        matches!(self, Surface::Black | Surface::Lambert(_) | Surface::Conductor(_))
    }

    /// Whether it is the boundary of a transmitting solid.
    #[inline]
    pub fn refracts(&self) -> bool {
        match self {
            Surface::Dielectric(_) => true,
            Surface::MetalDielectric(b) => b.refracts(),
            Surface::Black | Surface::Lambert(_) | Surface::Conductor(_) | Surface::Thin(_) => false,
        }
    }

    /// Returns a bound of light scattered from or into the direction `known`. None is known for rough transmission.
    pub fn bound(&self, known: Local) -> ScatteringBound {
        match self {
            Surface::Black => ScatteringBound::ZERO,
            Surface::Lambert(b) => ScatteringBound { diffuse: b.albedo.max_lane() * FRAC_1_PI, glossy: 0.0 },
            Surface::Conductor(b) if b.ggx.is_dirac() => ScatteringBound::ZERO,
            Surface::Conductor(b) => {
                ScatteringBound { diffuse: 0.0, glossy: b.fresnel.highest() * b.ggx.most_reflection(known) }
            }
            Surface::MetalDielectric(b) => b.bound(known),
            Surface::Dielectric(b) if b.ggx.is_dirac() => ScatteringBound::ZERO,
            Surface::Thin(b) if b.ggx.is_dirac() => ScatteringBound::ZERO,
            Surface::Dielectric(_) | Surface::Thin(_) => ScatteringBound::NONE,
        }
    }

    /// Returns the weights of the diffuse part and of the lobe for the direction `known`.
    #[inline]
    pub fn shares(&self, known: Local) -> Shares {
        match self {
            Surface::Conductor(b) => Shares { diffuse: 0.0, glossy: 1.0, alpha2: b.ggx.alpha_squared() },
            Surface::MetalDielectric(b) => b.shares(known),
            Surface::Black | Surface::Lambert(_) | Surface::Dielectric(_) | Surface::Thin(_) => Shares::DIFFUSE,
        }
    }

    /// Whether light crosses it.
    #[inline]
    pub fn transmits(&self) -> bool {
        match self {
            Surface::Dielectric(_) | Surface::Thin(_) => true,
            Surface::MetalDielectric(b) => b.transmits(),
            Surface::Black | Surface::Lambert(_) | Surface::Conductor(_) => false,
        }
    }

    /// Returns the factor of light that is refracted into a solid or out of it.
    pub fn transmission(&self) -> Spectrum {
        match self {
            Surface::Dielectric(b) => b.transmit,
            Surface::MetalDielectric(b) => b.refracted(),
            Surface::Black | Surface::Lambert(_) | Surface::Conductor(_) | Surface::Thin(_) => Spectrum::ZERO,
        }
    }

    /// Returns the colour of the surface for denoisers and previews, 0 to 1: the base colour where the model has one.
    pub fn reflectance(&self) -> Spectrum {
        match self {
            Surface::Black => Spectrum::ZERO,
            Surface::Lambert(b) => b.albedo,
            Surface::Conductor(b) => b.fresnel.reflectance(1.0),
            Surface::Dielectric(b) => b.transmit,
            Surface::Thin(b) => b.transmit,
            Surface::MetalDielectric(b) => b.base,
        }
    }
}

macro_rules! dispatch {
    ($surface:expr, $model:ident => $call:expr, $black:expr) => {
        match $surface {
            Surface::Black => $black,
            Surface::Lambert($model) => $call,
            Surface::Conductor($model) => $call,
            Surface::Dielectric($model) => $call,
            Surface::Thin($model) => $call,
            Surface::MetalDielectric($model) => $call,
        }
    };
}

impl Bsdf for Surface {
    #[inline]
    fn eval<T: Scalar>(&self, wi: Local<T>, wo: Local<T>, lobes: Lobes) -> Spectrum<T> {
        dispatch!(self, b => b.eval(wi, wo, lobes), Spectrum::ZERO)
    }

    #[inline]
    fn sample(&self, known: Local, mode: TransportMode, u: [f32; 3]) -> Option<BsdfSample> {
        dispatch!(self, b => b.sample(known, mode, u), None)
    }

    #[inline]
    fn dirac(&self, known: Local, mode: TransportMode, lobe: Lobes) -> Option<BsdfSample> {
        dispatch!(self, b => b.dirac(known, mode, lobe), None)
    }

    #[inline]
    fn pdf<T: Scalar>(&self, known: Local<T>, other: Local<T>, mode: TransportMode, lobes: Lobes) -> T {
        dispatch!(self, b => b.pdf(known, other, mode, lobes), T::ZERO)
    }

    #[inline]
    fn eval_and_pdf<T: Scalar>(&self, known: Local<T>, other: Local<T>, mode: TransportMode) -> (Spectrum<T>, T) {
        dispatch!(self, b => b.eval_and_pdf(known, other, mode), (Spectrum::ZERO, T::ZERO))
    }

    fn invert(&self, known: Local, other: Local, mode: TransportMode, aux: [f32; 2]) -> Option<([f32; 3], f64)> {
        dispatch!(self, b => b.invert(known, other, mode, aux), None)
    }

    #[inline]
    fn lobes(&self) -> Lobes {
        dispatch!(self, b => b.lobes(), Lobes::NONE)
    }
}
