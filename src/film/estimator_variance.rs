//! Variance of an estimated relative variance, from disjoint pairs of replicates, summed over the pixels of a patch.

use super::layout::COLOR;

/// Cumulants of an estimate, with its denominators treated as known. Those of independent estimates add.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Spread {
    /// Unbiased estimate of the variance; may be negative.
    pub(super) variance: f64,
    /// Unbiased estimate of the variance under normal replicates.
    pub(super) of_normal: f64,
    /// Third cumulant, estimated conservatively (too large).
    pub(super) third: f64,
}

impl Spread {
    /// Returns the spread of `scale` times the estimate.
    pub(super) fn scaled(self, scale: f64) -> Self {
        let square = scale * scale;
        Spread {
            variance: square * self.variance,
            of_normal: square * self.of_normal,
            third: square * scale * self.third,
        }
    }
}

impl std::ops::Add for Spread {
    type Output = Spread;

    fn add(self, b: Spread) -> Spread {
        Spread {
            variance: self.variance + b.variance,
            of_normal: self.of_normal + b.of_normal,
            third: self.third + b.third,
        }
    }
}

impl std::iter::Sum for Spread {
    fn sum<I: Iterator<Item = Spread>>(spreads: I) -> Spread {
        spreads.fold(Spread::default(), std::ops::Add::add)
    }
}

/// Third cumulant of an estimated variance with mean `mean` and variance `variance`; a direct estimate would need six
/// replicates. For a gamma distribution, as of normal samples, it is 2 S²/T. For rare events, each of which contributes
/// T² to S, it is S T. The smaller of the two fits both cases.
pub(super) fn third_cumulant(variance: f64, mean: f64) -> f64 {
    let positive = variance.max(0.0);
    if mean > 0.0 { positive * mean.min(2.0 * positive / mean) } else { 0.0 }
}

/// Two replicates and the weight of their squared difference.
pub(super) struct Pair {
    pub(super) a: usize,
    pub(super) b: usize,
    /// The other two replicates of the group of four.
    pub(super) others: [usize; 2],
    /// The factor that makes (m_a − m_b)² an unbiased estimate of Var(m).
    pub(super) variance_weight: f64,
}

/// Pairs of replicates for the noise estimate. Consecutive pairs partition a group of four.
pub(super) struct Pairs {
    pub(super) pairs: Vec<Pair>,
    /// Weights of Var(d) and of tr C² in the variance, and the weight of tr C² under normal samples: see
    /// [`Pairs::spread`].
    weights: [f64; 3],
}

impl Pairs {
    /// Returns the three partitions of four neighbouring replicates into two pairs, for each complete group of four.
    /// `counts` are the passes by replicate.
    pub(super) fn of(counts: &[f64]) -> Self {
        let total: f64 = counts.iter().sum();
        let pair = |[a, b, c, d]: [usize; 4]| {
            let (na, nb): (f64, f64) = (counts[a], counts[b]);
            Pair { a, b, others: [c, d], variance_weight: 1.0 / ((1.0 / na + 1.0 / nb) * total) }
        };
        let deal = |[a, b, c, d]: [usize; 4]| [[a, b, c, d], [c, d, a, b]];
        let deals = |r: usize| {
            [[r, r + 1, r + 2, r + 3], [r, r + 2, r + 1, r + 3], [r, r + 3, r + 1, r + 2]].into_iter().flat_map(deal)
        };
        let fours = (0..counts.len() / 4).map(|i| 4 * i);
        Pairs { pairs: fours.flat_map(deals).map(pair).collect(), weights: weights(counts.len() as f64) }
    }

    /// Returns the spread of T, the sum of relative variances over a `patch`; `None` with fewer than four replicates.
    ///
    /// Let e be the differences of a pair over the patch, d = |e|², C the covariance of e, and κ the excess of Var(d)
    /// over a normal e: Var(d) = 2 tr C² + κ/2. Squares that share a replicate have the covariance (2 tr C² + κ) / 4,
    /// so that the mean over all pairs of R replicates has the variance 2/(R − 1) tr C² + κ/R. Disjoint pairs are
    /// independent: half the squared difference of their d estimates Var(d), and the square of their e · e′ estimates
    /// tr C².
    pub(super) fn spread(&self, patch: &Patch) -> Option<Spread> {
        let deals = patch.products.len() as f64;
        if patch.products.is_empty() {
            return None;
        }
        let half_square = |d: &[f64]| 0.5 * (d[0] - d[1]) * (d[0] - d[1]);
        let differences = patch.squares.chunks_exact(2).map(half_square).sum::<f64>() / deals;
        let products = patch.products.iter().map(|p| p * p).sum::<f64>() / deals;
        let [of_differences, of_products, of_normal] = self.weights;
        let variance = of_differences * differences + of_products * products;
        Some(Spread { variance, of_normal: of_normal * products, third: third_cumulant(variance, patch.relative) })
    }
}

/// Returns the weights for the mean over all pairs of `replicates`: see [`Pairs::spread`].
fn weights(replicates: f64) -> [f64; 3] {
    let of_normal = 2.0 / (replicates - 1.0);
    [2.0 / replicates, of_normal - 4.0 / replicates, of_normal]
}

/// Sums over pixels whose samples may be correlated.
pub(super) struct Patch {
    relative: f64,
    /// By pair: d.
    squares: Vec<f64>,
    /// By partition into disjoint pairs: e · e′.
    products: Vec<f64>,
}

impl Patch {
    pub(super) fn empty(pairs: &Pairs) -> Self {
        let count = pairs.pairs.len();
        Patch { relative: 0.0, squares: vec![0.0; count], products: vec![0.0; count / 2] }
    }

    /// Adds a pixel: its relative variance, and by pair the signed square roots of its channels.
    pub(super) fn add(&mut self, relative: f64, roots: &[[f64; COLOR]]) {
        self.relative += relative;
        self.squares.iter_mut().zip(roots).for_each(|(sum, root)| *sum += dot(root, root));
        self.products.iter_mut().zip(roots.chunks_exact(2)).for_each(|(sum, deal)| *sum += dot(&deal[0], &deal[1]));
    }
}

fn dot(a: &[f64; COLOR], b: &[f64; COLOR]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
