//! Phase functions: distributions of scattered directions. Each is its own density under sampling.

use crate::geometry::Frame;
use crate::geometry::Local;
use crate::sampling::{Pdf, SolidAngle};
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, TAU};

/// 1 / 4π.
const UNIFORM: f32 = 0.25 * FRAC_1_PI;

/// How a medium scatters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Phase {
    /// Alike in all directions.
    Isotropic,
    /// See [`HenyeyGreenstein`], with this mean cosine.
    HenyeyGreenstein(f32),
    /// Two such functions, and the share of the first.
    Mixture([f32; 2], f32),
    /// Small spheres: 3 (1 + cos²) / 16π.
    Rayleigh,
}

/// The angle between two directions by 1 − cos and 1 + cos, of which the smaller one keeps its digits.
#[derive(Debug, Clone, Copy)]
struct Turn {
    /// 1 − cos, 0 for light that goes on.
    ahead: f32,
    /// 1 + cos, 0 for light that returns.
    back: f32,
}

impl Turn {
    /// Returns the angle by which light from `wi` is turned to `wo`, both unit vectors away from the vertex.
    #[inline]
    fn between(wi: Vec3, wo: Vec3) -> Self {
        Turn { ahead: 0.5 * (wi + wo).length_squared(), back: 0.5 * (wi - wo).length_squared() }
    }

    #[inline]
    fn cos(self) -> f32 {
        if self.ahead < self.back { 1.0 - self.ahead } else { self.back - 1.0 }
    }
}

/// A sampled direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhaseSample {
    /// Unit direction away from the vertex.
    pub direction: Vec3,
    /// Value and density.
    pub pdf: Pdf<SolidAngle>,
}

impl Phase {
    /// Returns the value for light that arrives along `wi` and leaves along `wo`, per solid angle. It integrates to 1
    /// over either, and is the density of either under [`Phase::sample`] of the other.
    #[inline]
    pub fn eval(&self, wi: Vec3, wo: Vec3) -> f32 {
        self.of(Turn::between(wi, wo))
    }

    #[inline]
    fn of(&self, turn: Turn) -> f32 {
        match *self {
            Phase::Isotropic => UNIFORM,
            Phase::HenyeyGreenstein(g) => henyey_greenstein(g, turn),
            Phase::Mixture([a, b], share) => {
                share * henyey_greenstein(a, turn) + (1.0 - share) * henyey_greenstein(b, turn)
            }
            Phase::Rayleigh => 0.75 * UNIFORM * (1.0 + turn.cos() * turn.cos()),
        }
    }

    /// Samples the other direction for the unit direction `known` by u in [0, 1)².
    #[inline]
    pub fn sample(&self, known: Vec3, [u, v]: [f32; 2]) -> PhaseSample {
        let turn = match *self {
            Phase::Isotropic => Turn { ahead: 2.0 * (1.0 - u), back: 2.0 * u },
            Phase::HenyeyGreenstein(g) => sample_henyey_greenstein(g, u),
            Phase::Mixture([a, _], share) if u < share => sample_henyey_greenstein(a, u / share),
            Phase::Mixture([_, b], share) => sample_henyey_greenstein(b, (u - share) / (1.0 - share)),
            Phase::Rayleigh => sample_rayleigh(u),
        };
        let sin = (turn.ahead * turn.back).max(0.0).sqrt();
        let (y, x) = (TAU * v).sin_cos();
        let direction = Frame::around(-known).to_world(Local::new(sin * x, sin * y, turn.cos()));
        PhaseSample { direction, pdf: Pdf::new(self.of(turn)) }
    }

    /// Returns its kind and its parameters as numbers.
    pub fn numbers(&self) -> [f32; 4] {
        match *self {
            Phase::Isotropic => [0.0; 4],
            Phase::HenyeyGreenstein(g) => [1.0, g, 0.0, 0.0],
            Phase::Mixture([a, b], share) => [2.0, a, b, share],
            Phase::Rayleigh => [3.0, 0.0, 0.0, 0.0],
        }
    }

    /// Returns the mean cosine of the angle by which light is turned, from −1 to 1.
    pub fn mean_cosine(&self) -> f32 {
        match *self {
            Phase::Isotropic | Phase::Rayleigh => 0.0,
            Phase::HenyeyGreenstein(g) => g,
            Phase::Mixture([a, b], share) => share * a + (1.0 - share) * b,
        }
    }
}

/// (1 − g²) / (4π (1 + g² − 2g cos)^(3/2)) [HenyeyGreenstein41]. The base is written as a sum of squares on the side of
/// the peak: (1 − g)² + 2g (1 − cos).
#[inline]
fn henyey_greenstein(g: f32, turn: Turn) -> f32 {
    let (near, away) = if g < 0.0 { (1.0 + g, turn.back) } else { (1.0 - g, turn.ahead) };
    let base = near * near + 2.0 * g.abs() * away;
    UNIFORM * near * (1.0 + g.abs()) / (base * base.sqrt())
}

/// Samples 1 ∓ cos. The usual formula for the cosine, divided by 2g, loses all digits for small g, and those of 1 − cos
/// for g near 1. Factored out of it, for s = 1 + g (2u − 1): 1 − cos = 2 (1 − u) (1 − g)² (1 + g u) / s², and the same
/// for 1 + cos with g and u turned round.
#[inline]
fn sample_henyey_greenstein(g: f32, u: f32) -> Turn {
    let v = 1.0 - u;
    let s = if g < 0.0 { (1.0 + g) - 2.0 * g * v } else { (1.0 - g) + 2.0 * g * u };
    let square = |x: f32| x * x;
    Turn {
        ahead: 2.0 * v * square((1.0 - g) / s) * (1.0 + g * u),
        back: 2.0 * u * square((1.0 + g) / s) * (1.0 - g * v),
    }
}

/// Samples the cosine x, whose distribution function is (x³ + 3x + 4) / 8: the root of a cubic.
#[inline]
fn sample_rayleigh(u: f32) -> Turn {
    let z = 4.0 * u - 2.0;
    let root = (z.abs() + (z * z + 1.0).sqrt()).cbrt();
    let cos = (root - root.recip()).min(1.0).copysign(z);
    Turn { ahead: 1.0 - cos, back: 1.0 + cos }
}
