//! Symmetric steps on the unit circle. Positions are integers in units of 2⁻³²: addition modulo 1 is exact, and 1 is
//! never reached.

/// Distribution of small steps of a coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SmallStep {
    /// Step length between `least` and `most`, log-uniform, in either direction [Kelemen02 §4.1]: mostly short,
    /// sometimes long.
    Exponential {
        /// Shortest step.
        least: f64,
        /// Longest step.
        most: f64,
    },
    /// Normal distribution, wrapped.
    Gaussian {
        /// Standard deviation.
        sigma: f64,
    },
}

/// 2³².
const CIRCLE: f64 = 4_294_967_296.0;

impl SmallStep {
    /// Range recommended by [Kelemen02]: between 1/1024 and 1/64.
    pub const KELEMEN: SmallStep = SmallStep::Exponential { least: 1.0 / 1024.0, most: 1.0 / 64.0 };

    /// Moves `x` by a step drawn from 64 random `bits`.
    #[inline]
    pub fn apply(self, x: u32, bits: u64) -> u32 {
        let (a, b) = ((bits >> 32) as u32, bits as u32);
        let unit = |x: u32| (f64::from(x) + 0.5) / CIRCLE;
        let step = match self {
            SmallStep::Exponential { least, most } => {
                let length = most * ((least / most).ln() * unit(a)).exp();
                if b & 1 == 0 { length } else { -length }
            }
            // Box–Muller transform.
            SmallStep::Gaussian { sigma } => {
                sigma * (-2.0 * unit(a).ln()).sqrt() * (std::f64::consts::TAU * unit(b)).cos()
            }
        };
        let step = (step * CIRCLE).round() as i64;
        x.wrapping_add(step as u32)
    }
}
