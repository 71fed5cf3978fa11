//! Scattering at surfaces. One model a file; to add one, write the struct, implement [`Bsdf`] and give it a variant in
//! [`Surface`].
//!
//! All directions are local (z = shading normal) and point away from the surface. Values follow the light flow: light
//! arrives along `wi` and leaves along `wo`, in subpaths from either end. Values of refraction are for radiance
//! transport, that is F(wi, wo) / η²_o = F(wo, wi) / η²_i. Geometric normals and adjoint factors are handled in
//! [`shading`].

pub mod albedo;
mod bound;
mod conductor;
mod dielectric;
pub mod fresnel;
pub mod ggx;
mod lambert;
pub mod lanes;
mod metal_dielectric;
mod metallic_roughness;
pub mod shading;
mod shares;
pub mod sides;
mod straight;
mod surface;
mod thin;

pub use bound::ScatteringBound;
pub use conductor::Conductor;
pub use dielectric::Dielectric;
pub use fresnel::Fresnel;
pub use ggx::Ggx;
pub use lambert::Lambert;
pub use metal_dielectric::MetalDielectric;
pub use metallic_roughness::{MetallicRoughness, Wall};
pub use shading::{Folds, Scattering, Shading, ShadingSample};
pub use shares::Shares;
pub use surface::Surface;
pub use thin::Thin;

use crate::geometry::Local;
use crate::numeric::{Scalar, next_down};
use crate::sampling::Density;
use crate::spectrum::Spectrum;
use crate::transport::TransportMode;

/// A set of scattering components.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Lobes(u8);

impl Lobes {
    /// Empty set.
    pub const NONE: Lobes = Lobes(0);
    /// Smooth reflection: diffuse and rough.
    pub const REFLECT: Lobes = Lobes(1);
    /// Smooth transmission.
    pub const TRANSMIT: Lobes = Lobes(2);
    /// Mirror reflection.
    pub const DIRAC_REFLECT: Lobes = Lobes(4);
    /// Unscattered or refracted transmission.
    pub const DIRAC_TRANSMIT: Lobes = Lobes(8);
    /// All lobes with a density.
    pub const SMOOTH: Lobes = Lobes(3);
    /// All Dirac lobes.
    pub const DIRAC: Lobes = Lobes(12);
    /// All lobes.
    pub const ALL: Lobes = Lobes(15);

    /// Union of both sets.
    #[inline]
    pub const fn union(self, other: Lobes) -> Lobes {
        Lobes(self.0 | other.0)
    }

    /// Intersection of both sets.
    #[inline]
    pub const fn intersection(self, other: Lobes) -> Lobes {
        Lobes(self.0 & other.0)
    }

    /// Whether the intersection is not empty.
    #[inline]
    pub const fn intersects(self, other: Lobes) -> bool {
        self.0 & other.0 != 0
    }
}

/// A sampled direction.
#[derive(Debug, Clone, Copy)]
pub struct BsdfSample {
    /// Direction, pointing away from the surface.
    pub direction: Local,
    /// Smooth: the value f(wi, wo) of all smooth lobes, without cosine. Dirac: the throughput factor before the
    /// division by the probability (cosines cancelled).
    pub value: Spectrum,
    /// Density of all smooth lobes together, or the probability of the Dirac direction.
    pub density: Density,
    /// Sampled component.
    pub lobe: Lobes,
    /// Refractive index on the sampled side over the one on the known side; 1 for reflection. Roulette divides it out.
    pub eta: f32,
}

/// A scattering model with its parameters resolved at one point.
pub trait Bsdf: Copy {
    /// Evaluates f(wi, wo) of the smooth components in `lobes`, without cosine. Dirac components contribute nothing.
    fn eval<T: Scalar>(&self, wi: Local<T>, wo: Local<T>, lobes: Lobes) -> Spectrum<T>;
    /// Samples the unknown direction with the random numbers u = [lobe, direction, direction]; `None` if nothing
    /// scatters.
    fn sample(&self, known: Local, mode: TransportMode, u: [f32; 3]) -> Option<BsdfSample>;
    /// Returns the Dirac component `lobe`, a single one, for the known direction: the result of [`Bsdf::sample`] if it
    /// selects this component, with its probability. `None` if it never does.
    fn dirac(&self, known: Local, mode: TransportMode, lobe: Lobes) -> Option<BsdfSample>;
    /// Returns the density of `other` per solid angle under [`Bsdf::sample`] restricted to the smooth components in
    /// `lobes`. For all of them it includes the probability of selecting a smooth component.
    fn pdf<T: Scalar>(&self, known: Local<T>, other: Local<T>, mode: TransportMode, lobes: Lobes) -> T;
    /// [`Bsdf::eval`] and [`Bsdf::pdf`] of all smooth components. Models override it to share work.
    #[inline]
    fn eval_and_pdf<T: Scalar>(&self, known: Local<T>, other: Local<T>, mode: TransportMode) -> (Spectrum<T>, T) {
        let (wi, wo) = mode.flow(known, other);
        (self.eval(wi, wo, Lobes::SMOOTH), self.pdf(known, other, mode, Lobes::SMOOTH))
    }
    /// Returns random numbers u that [`Bsdf::sample`] maps to `other` (smooth lobes only), and the natural logarithm of
    /// their density in the unit cube. The auxiliary random numbers select among several preimages. No method calls it
    /// yet: it is for reversible-jump kernels of Metropolis light transport.
    fn invert(&self, known: Local, other: Local, mode: TransportMode, aux: [f32; 2]) -> Option<([f32; 3], f64)>;
    /// Components of the model.
    fn lobes(&self) -> Lobes;
}

/// Maps `aux` to [start, end), and returns the logarithm of the density; `None` for an empty interval.
fn within([start, end]: [f32; 2], aux: f32) -> Option<(f32, f64)> {
    let width = end - start;
    (width > 0.0).then(|| ((start + width * aux).min(next_down(end)), -f64::from(width).ln()))
}
