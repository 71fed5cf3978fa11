//! Symmetric steps on the unit circle. Positions are whole numbers of 2⁻³²: addition modulo 1 is exact, and 1 is not reached.

use crate::defects::{Defect, planted};

/// How far a coordinate moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SmallStep {
    /// Between `least` and `most` on either side, the logarithm of the length uniform [Kelemen02 §4.1]: mostly near and
    /// sometimes far.
    Exponential {
        /// Shortest step.
        least: f64,
        /// Longest step.
        most: f64,
    },
    /// A normal distribution of this standard deviation, wrapped.
    Gaussian {
        /// Standard deviation.
        sigma: f64,
    },
}

/// 2³².
const CIRCLE: f64 = 4_294_967_296.0;

impl SmallStep {
    /// What [Kelemen02] found good: between 1/1024 and 1/64.
    pub const KELEMEN: SmallStep = SmallStep::Exponential { least: 1.0 / 1024.0, most: 1.0 / 64.0 };

    /// `x` moved as 64 random `bits` say.
    #[inline]
    pub fn apply(self, x: u32, bits: u64) -> u32 {
        let (a, b) = ((bits >> 32) as u32, bits as u32);
        let unit = |x: u32| (f64::from(x) + 0.5) / CIRCLE;
        let step = match self {
            SmallStep::Exponential { least, most } => {
                let length = most * ((least / most).ln() * unit(a)).exp();
                if b & 1 == 0 { length } else { -length }
            }
            // Box and Muller's.
            SmallStep::Gaussian { sigma } => sigma * (-2.0 * unit(a).ln()).sqrt() * (std::f64::consts::TAU * unit(b)).cos(),
        };
        let step = (step * CIRCLE).round() as i64;
        if planted(Defect::StepsStopAtEdges) {
            return (i64::from(x) + step).clamp(0, i64::from(u32::MAX)) as u32;
        }
        x.wrapping_add(step as u32)
    }
}
