//! Weights of multiple importance sampling, from density *ratios*: squares of densities overflow where their ratio does not.

/// How two techniques that may make the same sample share it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Heuristic {
    /// Weights proportional to the densities [Veach97 §9.2.2]. relMSE × CPU seconds of bidirectional path tracing under the power
    /// heuristic and this: .0424 and .0395 on the modified Cornell box, .90 and .83 on the ajar door, the same on the Cornell box and
    /// the glass caustic.
    #[default]
    Balance,
    /// Weights proportional to their squares [Veach97 §9.2.4].
    Power,
}

/// The balance heuristic's weight of a sample made with density `p` that another technique makes with `other`.
#[inline]
pub fn balance(p: f32, other: f32) -> f32 {
    1.0 / (1.0 + other / p)
}

/// The power heuristic's weight (exponent 2) of a sample made with density `p` that another technique makes with `other`.
#[inline]
pub fn power(p: f32, other: f32) -> f32 {
    let ratio = other / p;
    1.0 / (1.0 + ratio * ratio)
}

impl Heuristic {
    /// The weight of a sample made with density `p` > 0 that another technique makes with density `other` ≥ 0.
    #[inline]
    pub fn weight(self, p: f32, other: f32) -> f32 {
        match self {
            Heuristic::Balance => balance(p, other),
            Heuristic::Power => power(p, other),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weights_of_both_techniques_sum_to_one_at_any_scale() {
        for (p, q) in [(1.0, 3.0), (1e-30, 2e-30), (1e30, 5e-30), (0.5, 0.0), (1e20, 1e21)] {
            for h in [Heuristic::Balance, Heuristic::Power] {
                let sum = h.weight(p, q) + if q > 0.0 { h.weight(q, p) } else { 0.0 };
                assert!((sum - 1.0).abs() <= 2.0 * f32::EPSILON, "{h:?} {p} {q}: {sum}");
            }
        }
    }
}
