//! Scattering at surfaces. One model a file; to add one, write the struct, implement [`Bsdf`] and give it a variant in
//! [`Surface`].
//!
//! All directions are local (z = shading normal) and point away from the surface. Values are in light flow: light arrives
//! along `wi` and leaves along `wo`, whichever end the walk came from; for refraction the value is radiance's, that is
//! F(wi, wo) / η²_o = F(wo, wi) / η²_i. Geometric normals and adjoint factors are not known here: see [`shading`].

pub mod albedo;
mod conductor;
mod dielectric;
pub mod fresnel;
pub mod ggx;
mod gltf;
mod lambert;
mod metallic_roughness;
pub mod shading;
pub mod sides;
mod straight;
mod surface;
mod thin;

pub use conductor::Conductor;
pub use dielectric::Dielectric;
pub use fresnel::Fresnel;
pub use ggx::Ggx;
pub use gltf::Gltf;
pub use lambert::Lambert;
pub use metallic_roughness::{MetallicRoughness, Wall};
pub use shading::{Folds, Scattering, Shading, ShadingSample};
pub use surface::Surface;
pub use thin::Thin;

use crate::geometry::Local;
use crate::numeric::{Scalar, next_down};
use crate::sampling::Density;
use crate::spectrum::Spectrum;
use crate::transport::Transport;

/// A set of scattering components.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Lobes(u8);

impl Lobes {
    /// Nothing.
    pub const NONE: Lobes = Lobes(0);
    /// Smooth reflection: diffuse and rough.
    pub const REFLECT: Lobes = Lobes(1);
    /// Smooth transmission.
    pub const TRANSMIT: Lobes = Lobes(2);
    /// Mirror reflection.
    pub const DIRAC_REFLECT: Lobes = Lobes(4);
    /// Unscattered or refracted transmission.
    pub const DIRAC_TRANSMIT: Lobes = Lobes(8);
    /// Every lobe with a density.
    pub const SMOOTH: Lobes = Lobes(3);
    /// Every Dirac lobe.
    pub const DIRAC: Lobes = Lobes(12);
    /// Everything.
    pub const ALL: Lobes = Lobes(15);

    /// Both sets together.
    #[inline]
    pub const fn union(self, other: Lobes) -> Lobes {
        Lobes(self.0 | other.0)
    }

    /// What both sets share.
    #[inline]
    pub const fn intersection(self, other: Lobes) -> Lobes {
        Lobes(self.0 & other.0)
    }

    /// Whether the sets share a component.
    #[inline]
    pub const fn intersects(self, other: Lobes) -> bool {
        self.0 & other.0 != 0
    }
}

/// A sampled direction.
#[derive(Debug, Clone, Copy)]
pub struct BsdfSample {
    /// The direction, pointing away from the surface.
    pub direction: Local,
    /// Smooth: the value f(wi, wo) of all smooth lobes, without cosine. Dirac: what the throughput is multiplied by
    /// before the division by the probability (cosines cancelled).
    pub value: Spectrum,
    /// Density of all smooth lobes together, or the probability of the Dirac direction.
    pub density: Density,
    /// The component that was taken.
    pub lobe: Lobes,
    /// Refractive index on the sampled side over the one on the known side; 1 for reflection. Roulette divides it out.
    pub eta: f32,
}

/// A scattering model with its parameters resolved at one point.
pub trait Bsdf: Copy {
    /// f(wi, wo) of the smooth components in `lobes`, without cosine; Dirac components contribute nothing.
    fn eval<T: Scalar>(&self, wi: Local<T>, wo: Local<T>, lobes: Lobes) -> Spectrum<T>;
    /// Samples the direction that is not known with u = [lobe, direction, direction]; `None` if nothing scatters there.
    fn sample(&self, known: Local, toward: Transport, u: [f32; 3]) -> Option<BsdfSample>;
    /// The Dirac component `lobe`, one of them, for the known direction: what [`Bsdf::sample`] gives where it takes it, with the
    /// probability of that; `None` where it never does.
    fn dirac(&self, known: Local, toward: Transport, lobe: Lobes) -> Option<BsdfSample>;
    /// Density of `other` per solid angle under [`Bsdf::sample`] restricted to the smooth components in `lobes`
    /// (with all of them: including the probability of having chosen a smooth one).
    fn pdf<T: Scalar>(&self, known: Local<T>, other: Local<T>, toward: Transport, lobes: Lobes) -> T;
    /// [`Bsdf::eval`] and [`Bsdf::pdf`] of all smooth components; models whose two share work do it once.
    #[inline]
    fn eval_and_pdf<T: Scalar>(&self, known: Local<T>, other: Local<T>, toward: Transport) -> (Spectrum<T>, T) {
        let (wi, wo) = toward.flow(known, other);
        (self.eval(wi, wo, Lobes::SMOOTH), self.pdf(known, other, toward, Lobes::SMOOTH))
    }
    /// Numbers u that [`Bsdf::sample`] maps to `other` (smooth lobes only), chosen with the auxiliary numbers where
    /// several do, and the natural logarithm of the density of that choice in the unit cube.
    fn invert(&self, known: Local, other: Local, toward: Transport, aux: [f32; 2]) -> Option<([f32; 3], f64)>;
    /// The components it has.
    fn lobes(&self) -> Lobes;
}

/// A number in [start, end) chosen by `aux`, and the logarithm of its density; `None` for an empty interval.
fn within([start, end]: [f32; 2], aux: f32) -> Option<(f32, f64)> {
    let width = end - start;
    (width > 0.0).then(|| ((start + width * aux).min(next_down(end)), -f64::from(width).ln()))
}
