//! How noisy an estimated relative variance is: from pairs of replicates that share none, summed over the pixels of a patch.

use super::replicates::COLOR;

/// How an estimate is distributed, its denominators taken as known. Those of independent estimates add up to that of their sum.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Spread {
    /// Its variance, without bias; may be negative.
    pub(super) variance: f64,
    /// What the variance would be if replicates were normal, without bias.
    pub(super) of_normal: f64,
    /// Its third cumulant, rather too large than too small.
    pub(super) third: f64,
}

impl Spread {
    /// That of `scale` times the estimate.
    pub(super) fn scaled(self, scale: f64) -> Self {
        let square = scale * scale;
        Spread { variance: square * self.variance, of_normal: square * self.of_normal, third: square * scale * self.third }
    }
}

impl std::ops::Add for Spread {
    type Output = Spread;

    fn add(self, b: Spread) -> Spread {
        Spread { variance: self.variance + b.variance, of_normal: self.of_normal + b.of_normal, third: self.third + b.third }
    }
}

impl std::iter::Sum for Spread {
    fn sum<I: Iterator<Item = Spread>>(spreads: I) -> Spread {
        spreads.fold(Spread::default(), std::ops::Add::add)
    }
}

/// The third cumulant of an estimated variance that is `mean` and has the variance `variance`, which six replicates could tell.
/// That of a gamma distribution, as of normal samples, is 2 S²/T; that of rare events, of which each brings T² to S, is S T. The
/// smaller one fits both.
pub(super) fn third_cumulant(variance: f64, mean: f64) -> f64 {
    let positive = variance.max(0.0);
    if mean > 0.0 { positive * mean.min(2.0 * positive / mean) } else { 0.0 }
}

/// Two replicates, and what their difference says.
pub(super) struct Pair {
    pub(super) a: usize,
    pub(super) b: usize,
    /// The other two of the four that it is of.
    pub(super) others: [usize; 2],
    /// (m_a − m_b)² times this estimates Var(m) without bias.
    pub(super) variance_weight: f64,
}

/// The pairs whose differences tell the noise: two by two they deal four replicates.
pub(super) struct Pairs {
    pub(super) pairs: Vec<Pair>,
    /// The weights of Var(d) and of tr C² in a variance, and that of the latter if samples are normal: see [`Pairs::spread`].
    weights: [f64; 3],
}

impl Pairs {
    /// The three ways to deal four neighbouring replicates into two pairs, for each whole four of those with `counts` passes.
    pub(super) fn of(counts: &[f64]) -> Self {
        let total: f64 = counts.iter().sum();
        let pair = |[a, b, c, d]: [usize; 4]| {
            let (na, nb): (f64, f64) = (counts[a], counts[b]);
            Pair { a, b, others: [c, d], variance_weight: 1.0 / ((1.0 / na + 1.0 / nb) * total) }
        };
        let deal = |[a, b, c, d]: [usize; 4]| [[a, b, c, d], [c, d, a, b]];
        let deals =
            |r: usize| [[r, r + 1, r + 2, r + 3], [r, r + 2, r + 1, r + 3], [r, r + 3, r + 1, r + 2]].into_iter().flat_map(deal);
        let fours = (0..counts.len() / 4).map(|i| 4 * i);
        Pairs { pairs: fours.flat_map(deals).map(pair).collect(), weights: weights(counts.len() as f64) }
    }

    /// The spread of T, the sum over a `patch` of relative variances; `None` with fewer than four replicates.
    ///
    /// Let e be the differences of a pair over the patch, d = |e|², C the covariance of e and κ what Var(d) has beyond that of a
    /// normal e: Var(d) = 2 tr C² + κ/2. Squares that share a replicate covary by a quarter of 2 tr C² + κ, so that the mean over
    /// all pairs of R replicates has the variance 2/(R − 1) tr C² + κ/R. Disjoint pairs are independent: half the squared
    /// difference of their d estimates Var(d), the square of their e · e′ estimates tr C².
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

/// The weights for the mean over all pairs of `replicates`: see [`Pairs::spread`].
fn weights(replicates: f64) -> [f64; 3] {
    let of_normal = 2.0 / (replicates - 1.0);
    [2.0 / replicates, of_normal - 4.0 / replicates, of_normal]
}

/// Sums over pixels that samples may have fallen on together.
pub(super) struct Patch {
    relative: f64,
    /// By pair: d.
    squares: Vec<f64>,
    /// By two pairs that share no replicate: e · e′.
    products: Vec<f64>,
}

impl Patch {
    pub(super) fn empty(pairs: &Pairs) -> Self {
        let count = pairs.pairs.len();
        Patch { relative: 0.0, squares: vec![0.0; count], products: vec![0.0; count / 2] }
    }

    /// Adds a pixel: its relative variance, and by pair the signed roots of that by channel.
    pub(super) fn add(&mut self, relative: f64, roots: &[[f64; COLOR]]) {
        self.relative += relative;
        self.squares.iter_mut().zip(roots).for_each(|(sum, root)| *sum += dot(root, root));
        self.products.iter_mut().zip(roots.chunks_exact(2)).for_each(|(sum, deal)| *sum += dot(&deal[0], &deal[1]));
    }
}

fn dot(a: &[f64; COLOR], b: &[f64; COLOR]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
