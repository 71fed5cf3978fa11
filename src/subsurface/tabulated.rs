//! Profiles by table.

use super::{MediumLane, RadialProfile};
use std::f64::consts::TAU;

/// Radius of the first node in mean free paths.
const NEAREST: f64 = 1e-4;

/// Slopes below this are 0: their square rounds to 0 beside 1.
const FLAT: f64 = 1e-12;

/// A radial profile through nodes at equal ratios of radii, a power of the radius between two of them. It falls like
/// 1 / r below the first node, as single scattering does, and is 0 beyond the last one.
///
/// The density, the tail and the sampled radius belong to this one curve. They are consistent to rounding, whatever the
/// distance between the nodes.
#[derive(Debug, Clone)]
pub struct Tabulated {
    /// ln of the first radius.
    first: f64,
    /// Difference of ln r between nodes.
    step: f64,
    /// 2π r² R at the nodes, over the total.
    density: Vec<f64>,
    /// Share of the total beyond each node.
    tails: Vec<f64>,
    total: f64,
}

impl Tabulated {
    /// Tabulates `value`, R(r), at `nodes` radii from `first` to `last`.
    ///
    /// # Panics
    /// Unless there are two nodes at least, 0 < `first` < `last`, and the values are positive and finite.
    pub fn new(first: f64, last: f64, nodes: usize, value: impl Fn(f64) -> f64) -> Self {
        assert!(nodes >= 2 && first > 0.0 && last > first, "{nodes} nodes from {first} to {last}");
        let step = (last / first).ln() / (nodes - 1) as f64;
        let mut density: Vec<f64> = (0..nodes)
            .map(|i| {
                let r = first * (i as f64 * step).exp();
                TAU * r * r * value(r)
            })
            .collect();
        assert!(density.iter().all(|&f| f > 0.0 && f.is_finite()), "values must be positive");
        let mut tails = vec![0.0; nodes];
        for i in (0..nodes - 1).rev() {
            tails[i] = tails[i + 1] + mass(density[i + 1], (density[i + 1] / density[i]).ln(), step);
        }
        let total = tails[0] + density[0];
        density.iter_mut().chain(&mut tails).for_each(|x| *x /= total);
        Tabulated { first: first.ln(), step, density, tails, total }
    }

    /// Tabulates the profile `value` of `medium` at 512 radii, from 1e-4 mean free paths to where e^−40 of the light is
    /// left by the coefficient `decay`, at most 1e5 mean free paths. The total is 0 if the medium does not scatter.
    ///
    /// # Panics
    /// Unless `medium` has a positive extinction, and the values are positive and finite or round to 0.
    pub(super) fn of_medium(medium: &MediumLane, decay: f64, value: impl Fn(f64) -> f64) -> Self {
        let path = 1.0 / medium.reduced().extinction();
        let last = (40.0 / decay).clamp(40.0 * path, 1e5 * path);
        let table =
            Tabulated::new(NEAREST / medium.extinction(), last, 512, |r| value(r).max(f64::MIN_POSITIVE / (r * r)));
        if medium.scattering > 0.0 { table } else { table.with_total(0.0) }
    }

    /// Returns the same shape with another total, in [0, 1].
    pub fn with_total(self, total: f64) -> Self {
        Tabulated { total, ..self }
    }

    /// Returns the segment `i` of ln r above the first node: the density at its upper end, and the slope λ of ln f
    /// across it.
    fn segment(&self, i: usize) -> (f64, f64) {
        (self.density[i + 1], (self.density[i + 1] / self.density[i]).ln())
    }
}

/// Returns ∫ f dx over the length `x` below the upper end of a segment, with f = `upper` there and f falling by e^λ
/// over the `x`.
fn mass(upper: f64, lambda: f64, x: f64) -> f64 {
    let share = if lambda.abs() < FLAT { 1.0 } else { -(-lambda).exp_m1() / lambda };
    upper * x * share
}

impl RadialProfile for Tabulated {
    fn total(&self) -> f64 {
        self.total
    }

    fn density(&self, r: f64) -> f64 {
        // The pole is cut where a sample falls with probability 1e-12 at most.
        let x = ((r.ln() - self.first) / self.step).max(-28.0 / self.step);
        let f = if x <= 0.0 {
            self.density[0] * (x * self.step).exp()
        } else if x >= (self.density.len() - 1) as f64 {
            return 0.0;
        } else {
            let (upper, lambda) = self.segment(x as usize);
            upper * (-lambda * (1.0 - x.fract())).exp()
        };
        f / (TAU * (2.0 * (self.first + x * self.step)).exp())
    }

    fn tail(&self, r: f64) -> f64 {
        let x = (r.ln() - self.first) / self.step;
        if x <= 0.0 {
            return self.tails[0] + self.density[0] * (1.0 - (x * self.step).exp());
        }
        let i = x as usize;
        if i + 1 >= self.density.len() {
            return 0.0;
        }
        let (upper, lambda) = self.segment(i);
        let above = 1.0 - x.fract();
        self.tails[i + 1] + mass(upper, lambda * above, self.step * above)
    }

    fn radius(&self, tail: f64) -> f64 {
        debug_assert!(tail > 0.0 && tail <= 1.0, "tail {tail}");
        if tail >= self.tails[0] {
            return self.first.exp() * ((1.0 - tail) / self.density[0]).clamp(0.0, 1.0);
        }
        // The first node beyond which less is left than `tail`; the last one has 0.
        let end = self.tails.partition_point(|&t| t >= tail);
        let (upper, lambda) = self.segment(end - 1);
        // The inverse of [`mass`] in the share of the segment.
        let linear = (tail - self.tails[end]) / (upper * self.step);
        let above = if lambda.abs() < FLAT { linear } else { -(-lambda * linear).ln_1p() / lambda };
        (self.first + self.step * (end as f64 - above.clamp(0.0, 1.0))).exp()
    }
}
