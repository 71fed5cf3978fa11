//! Which part of a surface's scattering is diffuse and which a lobe, in outline.

use super::{Shading, Surface};
use crate::geometry::Local;
use crate::transport::ScatteringOutline;

/// Weights of a [`ScatteringOutline`], for one known direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares<F = f32> {
    /// See [`ScatteringOutline::diffuse`].
    pub diffuse: F,
    /// See [`ScatteringOutline::glossy`].
    pub glossy: F,
    /// See [`ScatteringOutline::alpha2`].
    pub alpha2: F,
}

impl Shares {
    /// All is diffuse.
    pub(super) const DIFFUSE: Shares = Shares { diffuse: 1.0, glossy: 0.0, alpha2: 1.0 };
}

impl Surface {
    /// Returns the weights of the diffuse part and of the lobe for the direction `known`. Transmission counts as
    /// diffuse.
    #[inline]
    fn shares(&self, known: Local) -> Shares {
        match self {
            Surface::Conductor(b) => Shares { diffuse: 0.0, glossy: 1.0, alpha2: b.ggx.alpha() * b.ggx.alpha() },
            Surface::MetalDielectric(b) => b.shares(known),
            Surface::Black | Surface::Lambert(_) | Surface::Dielectric(_) | Surface::Thin(_) => Shares::DIFFUSE,
        }
    }

    /// Whether light crosses it.
    #[inline]
    fn transmits(&self) -> bool {
        match self {
            Surface::Dielectric(_) | Surface::Thin(_) => true,
            Surface::MetalDielectric(b) => b.transmits(),
            Surface::Black | Surface::Lambert(_) | Surface::Conductor(_) => false,
        }
    }
}

impl Shading<'_> {
    /// Returns the outline of scattering toward the known direction.
    #[inline]
    pub fn outline(&self) -> ScatteringOutline {
        let Shares { diffuse, glossy, alpha2 } = self.surface.shares(self.seen());
        let (n, wo, transmits) = (self.point.frame.n, self.known(), self.surface.transmits());
        ScatteringOutline { n, wo, diffuse, glossy, alpha2, transmits }
    }
}
