//! What scatters at a vertex, seen from one direction: a surface or a medium.

use super::MediumPoint;
use crate::bsdf::{Scattering, Shading};
use crate::medium::{Phase, PhaseSample};
use crate::sampling::{Pdf, SolidAngle};
use crate::scene::{Edge, EdgeEnd};
use crate::spectrum::Spectrum;
use glam::Vec3;

/// Scattering at a vertex for the direction in which a walk arrives.
pub enum Scatterer<'a> {
    /// By the BSDF of a surface.
    Surface(Shading<'a>),
    /// By the phase function of a medium.
    Medium(PhaseAt),
}

/// A phase function for a known direction. The scattering coefficient belongs to the throughput of the walk that
/// collided.
#[derive(Debug, Clone, Copy)]
pub struct PhaseAt {
    point: MediumPoint,
    known: Vec3,
}

impl PhaseAt {
    /// Returns scattering at `point` for the unit direction `known` to the vertex before it.
    #[inline]
    pub fn new(point: &MediumPoint, known: Vec3) -> Self {
        PhaseAt { point: *point, known }
    }

    /// Returns the phase function.
    #[inline]
    pub fn phase(&self) -> &Phase {
        &self.point.phase
    }

    /// Returns the edge in the unit direction `w` to `end`.
    #[inline]
    pub fn edge_to(&self, w: Vec3, end: EdgeEnd) -> Edge {
        Edge::from_medium(self.point.p, self.point.state, w, end)
    }

    /// Returns the value for the unit direction `other`, which is also its density under [`PhaseAt::sample`].
    #[inline]
    pub fn scattering(&self, other: Vec3) -> Scattering {
        let value = self.point.phase.eval(other, self.known);
        Scattering { f_cos: Spectrum::splat(value), pdf: Pdf::new(value) }
    }

    /// Samples the other direction by `u`.
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> PhaseSample {
        self.point.phase.sample(self.known, u)
    }
}

impl Scatterer<'_> {
    /// See [`Shading::scattering`].
    #[inline]
    pub fn scattering(&self, other: Vec3) -> Option<Scattering> {
        match self {
            Scatterer::Surface(shading) => shading.scattering(other),
            Scatterer::Medium(phase) => Some(phase.scattering(other)),
        }
    }

    /// See [`Shading::reverse_pdf`].
    #[inline]
    pub fn reverse_pdf(&self, other: Vec3) -> Pdf<SolidAngle> {
        match self {
            Scatterer::Surface(shading) => shading.reverse_pdf(other),
            Scatterer::Medium(phase) => phase.scattering(other).pdf,
        }
    }
}
