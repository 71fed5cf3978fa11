//! Densities typed by their measure, so that a solid-angle density cannot be compared with an area density.

use std::marker::PhantomData;

/// Measure of a density.
pub trait Measure: Copy + Send + Sync + 'static {}

/// Solid angle at a point, in steradians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolidAngle;
/// Surface area, in scene units squared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area;
/// Counting measure: a probability.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Discrete;

impl Measure for SolidAngle {}
impl Measure for Area {}
impl Measure for Discrete {}

/// A probability density in the measure `M`: finite and not negative.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Pdf<M: Measure>(f32, PhantomData<M>);

impl<M: Measure> Pdf<M> {
    /// Returns the density `value`.
    #[inline]
    pub fn new(value: f32) -> Self {
        debug_assert!(value.is_finite() && value >= 0.0, "density {value}");
        Pdf(value, PhantomData)
    }

    /// Returns the numerical value.
    #[inline]
    pub fn value(self) -> f32 {
        self.0
    }

    /// Multiplies by the selection probability of this technique.
    #[inline]
    pub fn choose(self, probability: Pdf<Discrete>) -> Self {
        Pdf(self.0 * probability.0, PhantomData)
    }
}

impl Pdf<Area> {
    /// Converts an area density to solid angle, from a point at squared distance `d2`; `cos` is |cos| at the surface. A
    /// degenerate geometry term (cos = 0) gives a density of 0: the caller drops such samples.
    #[inline]
    pub fn to_solid_angle(self, d2: f32, cos: f32) -> Pdf<SolidAngle> {
        if cos == 0.0 { Pdf::new(0.0) } else { Pdf::new((self.0 * d2 / cos).min(f32::MAX)) }
    }
}

/// Density of a sampled direction. A Dirac lobe is a variant of its own, not a special value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Density {
    /// A density per solid angle.
    Smooth(Pdf<SolidAngle>),
    /// A Dirac direction, with its discrete probability.
    Delta(f32),
}

impl Density {
    /// Returns the divisor of the estimator: the density, or the probability of the Dirac direction.
    #[inline]
    pub fn value(self) -> f32 {
        match self {
            Density::Smooth(pdf) => pdf.value(),
            Density::Delta(probability) => probability,
        }
    }

    /// Returns whether this is a Dirac direction.
    #[inline]
    pub fn is_delta(self) -> bool {
        matches!(self, Density::Delta(_))
    }
}
