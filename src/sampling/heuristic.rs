//! MIS weights, from density *ratios*: squares of densities may overflow where their ratio does not.

use etendue_lanes::Float;

/// MIS heuristic for two techniques.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Default,
    Hash,
    serde::Serialize,
    serde::Deserialize,
    strum::VariantArray,
    strum::IntoStaticStr,
    strum::EnumMessage,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Heuristic {
    /// Weights proportional to the densities [Veach97 §9.2.2]. relMSE × CPU seconds of bidirectional path tracing with
    /// the power and the balance heuristic: .0424 and .0395 on the modified Cornell box, .90 and .83 on the ajar door,
    /// equal on the Cornell box and the glass caustic.
    #[default]
    Balance,
    /// Weights proportional to the squared densities [Veach97 §9.2.4].
    Power,
}

/// Returns the power heuristic's weight (exponent 2) of a sample with density `p`, and density `other` under the other
/// technique.
#[inline]
pub fn power<F: Float>(p: F, other: F) -> F {
    let ratio = other / p;
    (F::splat(1.0) + ratio * ratio).recip()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn power_heuristic_weights_sum_to_one_at_any_scale() {
        for (p, q) in [(1.0, 3.0), (1e-30, 2e-30), (1e30, 5e-30), (0.5, 0.0), (1e20, 1e21)] {
            let sum: f32 = power(p, q) + if q > 0.0 { power(q, p) } else { 0.0 };
            assert!((sum - 1.0).abs() <= 2.0 * f32::EPSILON, "{p} {q}: {sum}");
        }
    }
}
