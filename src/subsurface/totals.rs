//! Exact total reflectance of a half-space behind a smooth dielectric boundary, for Henyey–Greenstein scattering.
//!
//! The azimuthal mean of the radiance is sampled at Gauss–Radau nodes μ > 0 [DavisRabinowitz84], in two panels that
//! meet at the critical cosine. Each is clustered like x² at its lower end, where Fresnel's equations and the radiance
//! are singular. The unknowns are the sum S and the difference D of the radiances downwards and upwards, times √(w μ)
//! for the weight w [StamnesSwanson81]. The equation of transfer becomes S′ = −A D, D′ = −B S. The symmetric A holds
//! the odd Legendre moments of the phase function, and B the even ones. In a half-space D = Z S at every depth. So Z A
//! Z = B, and Z is the geometric mean of A⁻¹ and B [Bhatia07 ch. 4]: L⁻ᵀ U Σ Uᵀ L⁻¹ with A = L Lᵀ, B = K Kᵀ and Lᵀ K =
//! U Σ Vᵀ. By reciprocity the share that is absorbed of the light that enters in each direction is 2 [T + Z (2 − T)]⁻¹
//! Z 1, where T is the transmittance of the boundary. The moments from `NODES` on are those of a peak, forwards or
//! backwards with the sign of g [Wiscombe77]. The row sums of B are imposed, which conserves energy to rounding.
//!
//! For g in [−0.9, 0.95], indices up to 2.5 and any albedo, twice the nodes change the result by less than 6e-8 for
//! diffuse light and 2e-6 for normal incidence, and by less than 1e-11 up to |g| = 0.8. Beyond that range the error is
//! not known, and it grows as |g| tends to 1. One evaluation takes about 7 ms.

use super::MediumLane;
use std::f64::consts::{FRAC_PI_2, PI};

/// Number of nodes of the hemisphere, and of Legendre moments. It is even.
const NODES: usize = 96;

/// Cosine between columns that count as orthogonal: some roundings of their products.
const ORTHOGONAL: f64 = 1e-13;

/// Returns the share of the entered light that finally leaves, for diffuse light outside that Fresnel's equations let
/// in. It is 0 in a medium that neither absorbs nor scatters.
///
/// # Panics
///
/// Panics if a coefficient is negative, the mean cosine is not inside (−1, 1), the index is below 1, or one of them is
/// not finite.
pub fn diffuse_total(medium: &MediumLane) -> f64 {
    totals(medium, NODES).0
}

/// Returns the share of the entered light that finally leaves, for normal incidence.
///
/// # Panics
///
/// Panics like [`diffuse_total`].
pub fn normal_total(medium: &MediumLane) -> f64 {
    totals(medium, NODES).1
}

/// A direction inside: its cosine, the weight of the integral over it and the share that the boundary transmits.
struct Node {
    mu: f64,
    weight: f64,
    transmitted: f64,
}

/// Returns the totals of diffuse light and of normal incidence.
fn totals(medium: &MediumLane, count: usize) -> (f64, f64) {
    let &MediumLane { absorption, scattering, mean_cosine, eta } = medium;
    let valid = absorption >= 0.0 && scattering >= 0.0 && mean_cosine.abs() < 1.0 && eta >= 1.0;
    assert!(valid && absorption.max(scattering).max(eta).is_finite(), "{medium:?}");
    // Light that is not scattered does not return, absorbed or not.
    let loss = if scattering > 0.0 { 1.0 / (1.0 + scattering / absorption) } else { 1.0 };
    let nodes = nodes(eta.min(100.0), count);
    let scales: Vec<f64> = nodes.iter().map(|node| (node.weight * node.mu).sqrt()).collect();
    let (odd, even) = factors(&nodes, &scales, loss, mean_cosine);
    let system = admittance(&odd, &even);
    let mut absorbed: Vec<f64> = system.iter().map(|row| dot(row, &scales)).collect();
    let exchanged = |(node, scale): (&Node, _)| node.transmitted / (2.0 - node.transmitted) * scale;
    let sums = nodes.iter().zip(&scales).map(exchanged).zip(&absorbed).map(|(x, y)| x + y).collect();
    let system = cholesky(system, &scales, sums);
    for (i, row) in system.iter().enumerate() {
        absorbed[i] = (absorbed[i] - dot(&row[..i], &absorbed[..i])) / row[i];
    }
    back_substitute(&system, &mut absorbed);
    // By Snell's law diffuse light has the density T(μ) μ inside as outside.
    let (mut share, mut diffuse, mut entered) = (0.0, 0.0, 0.0);
    for ((node, scale), x) in nodes.iter().zip(&scales).zip(&absorbed) {
        share = 2.0 * x / ((2.0 - node.transmitted) * scale);
        diffuse += node.transmitted * node.weight * node.mu * share;
        entered += node.transmitted * node.weight * node.mu;
    }
    ((1.0 - diffuse / entered).clamp(0.0, 1.0), (1.0 - share).clamp(0.0, 1.0))
}

/// Returns `count` nodes with rising cosines. The panels share them like their angles, but have at least 12 each.
fn nodes(eta: f64, count: usize) -> Vec<Node> {
    let critical = ((1.0 - 1.0 / eta) * (1.0 + 1.0 / eta)).sqrt();
    let share = (count as f64 * critical.asin() / FRAC_PI_2) as usize;
    let below = if critical > 0.0 { share.clamp(12, count - 12) } else { 0 };
    let width = 1.0 / (eta * eta * (1.0 + critical));
    let total = |(x, w)| Node { mu: critical * x * x, weight: critical * 2.0 * x * w, transmitted: 0.0 };
    let partial = |(x, w)| {
        let mu = critical + width * x * x;
        let transmitted = transmittance(mu, eta * x * (width * (mu + critical)).sqrt(), eta);
        Node { mu, weight: width * 2.0 * x * w, transmitted }
    };
    radau(below).into_iter().map(total).chain(radau(count - below).into_iter().map(partial)).collect()
}

/// Returns the transmittance for unpolarized light of the cosines `inside` and `outside` by Fresnel's equations.
fn transmittance(inside: f64, outside: f64, eta: f64) -> f64 {
    let product = 2.0 * eta * inside * outside;
    product / (eta * inside + outside).powi(2) + product / (inside + eta * outside).powi(2)
}

/// Returns the `n` rising nodes in (0, 1] and weights of the Gauss–Radau rule with the node 1 [DavisRabinowitz84].
fn radau(n: usize) -> Vec<(f64, f64)> {
    let count = n as f64;
    let rule = |i: usize| {
        // Newton's method for the zeros of P(n − 1) + P(n), from those of the Chebyshev rule. The first is exact.
        let mut x = -(2.0 * PI * i as f64 / (2.0 * count - 1.0)).cos();
        for _ in 0..8 {
            let p = legendre(n + 1, x);
            x -= (1.0 - x) / count * (p[n - 1] + p[n]) / (p[n - 1] - p[n]);
        }
        (0.5 * (1.0 - x), if i == 0 { 1.0 } else { 0.5 * (1.0 - x) } / (count * legendre(n, x)[n - 1]).powi(2))
    };
    (0..n).rev().map(rule).collect()
}

/// Returns the first `count` Legendre polynomials at `x`, at least two.
fn legendre(count: usize, x: f64) -> Vec<f64> {
    let mut p = vec![1.0, x];
    for l in 1..count - 1 {
        let order = l as f64;
        p.push(((2.0 * order + 1.0) * x * p[l] - order * p[l - 1]) / (order + 1.0));
    }
    p
}

/// Returns the factors L of A and K of B. The albedo is 1 − `loss`.
fn factors(nodes: &[Node], scales: &[f64], loss: f64, mean_cosine: f64) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let (count, sign) = (nodes.len(), mean_cosine.signum());
    // The bound replaces −∞: the moments are 0 all the same.
    let log = mean_cosine.abs().ln().max(-800.0);
    let moment = |l: f64| (loss - 1.0) * (log * l).exp() * (log * (count as f64 - l)).exp_m1() * (2.0 * l + 1.0);
    let moments: Vec<f64> = (0..count).map(|l| moment(l as f64)).collect();
    let polynomials: Vec<Vec<f64>> = nodes.iter().map(|node| legendre(count, node.mu)).collect();
    let (mut odd, mut even) = (vec![vec![0.0; count]; count], vec![vec![0.0; count]; count]);
    let mut sums = Vec::with_capacity(count);
    for (i, p) in polynomials.iter().enumerate() {
        let forwards: Vec<f64> = moments.iter().zip(p).map(|(m, p)| m * p).collect();
        let backwards: Vec<f64> = forwards.iter().enumerate().map(|(l, x)| if l % 2 == 0 { *x } else { -x }).collect();
        for (j, q) in polynomials.iter().enumerate() {
            let factor = -0.5 * scales[i] * scales[j] / (nodes[i].mu * nodes[j].mu);
            let (forward, backward) = (dot(&forwards, q), dot(&backwards, q));
            (odd[i][j], even[i][j]) = (sign * factor * (forward - backward), factor * (forward + backward));
        }
        // The peak holds the moments from `count` on, and what the quadrature misses of the sum of the row.
        let rate = scales[i] / nodes[i].mu;
        let peak = (1.0 - loss) * rate + dot(&even[i], scales);
        sums.push((dot(&odd[i], scales) + rate - sign * peak, loss * rate));
    }
    let (odd_sums, even_sums) = sums.into_iter().unzip();
    (cholesky(odd, scales, odd_sums), cholesky(even, scales, even_sums))
}

/// Returns the scalar product, with four sums for the sake of vectorization.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    for (x, y) in a.chunks_exact(4).zip(b.chunks_exact(4)) {
        sums.iter_mut().zip(x.iter().zip(y)).for_each(|(sum, (x, y))| *sum += x * y);
    }
    let rest = a.len() / 4 * 4;
    a[rest..].iter().zip(&b[rest..]).map(|(x, y)| x * y).sum::<f64>() + sums.iter().sum::<f64>()
}

/// Returns the lower triangular factor L of the matrix L Lᵀ of which L Lᵀ `vector` = `sums` and the elements off the
/// diagonal are given. No digits cancel where these are negative and the sums are not [Grassmann85].
fn cholesky(mut matrix: Vec<Vec<f64>>, vector: &[f64], mut sums: Vec<f64>) -> Vec<Vec<f64>> {
    for k in 0..matrix.len() {
        let mut column = matrix[k].split_off(k + 1);
        let root = ((sums[k] - dot(&column, &vector[k + 1..])) / vector[k]).max(0.0).sqrt();
        column.iter_mut().for_each(|x| *x /= root);
        matrix[k][k] = root;
        for (i, factor) in (k + 1..).zip(&column) {
            matrix[i][k] = *factor;
            matrix[i][k + 1..].iter_mut().zip(&column).for_each(|(x, y)| *x -= factor * y);
            sums[i] -= factor / root * sums[k];
        }
    }
    matrix
}

/// Replaces `x` by the solution of Lᵀ y = x.
fn back_substitute(l: &[Vec<f64>], x: &mut [f64]) {
    for (i, row) in l.iter().enumerate().rev() {
        x[i] /= row[i];
        let value = x[i];
        x[..i].iter_mut().zip(row).for_each(|(y, factor)| *y -= factor * value);
    }
}

/// Returns Z from the factors L of A and K of B.
fn admittance(l: &[Vec<f64>], k: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut columns = vec![vec![0.0; l.len()]; l.len()];
    for (row, factors) in l.iter().zip(k) {
        for (column, factor) in columns.iter_mut().zip(factors) {
            column.iter_mut().zip(row).for_each(|(x, y)| *x += factor * y);
        }
    }
    orthogonalize(&mut columns);
    let mut result = vec![vec![0.0; l.len()]; l.len()];
    for mut column in columns {
        let sigma = dot(&column, &column).sqrt().max(f64::MIN_POSITIVE);
        back_substitute(l, &mut column);
        for (row, x) in result.iter_mut().zip(&column) {
            row.iter_mut().zip(&column).for_each(|(sum, y)| *sum += x / sigma * y);
        }
    }
    result
}

/// Rotates the columns of a matrix U Σ Vᵀ to those of U Σ by the Jacobi method [DemmelVeselic92].
fn orthogonalize(columns: &mut [Vec<f64>]) {
    // Columns were rotated in at most 10 sweeps.
    for _ in 0..12 {
        for i in 0..columns.len() {
            let (head, tail) = columns.split_at_mut(i + 1);
            let x = &mut head[i];
            let mut square = dot(x, x);
            for y in tail {
                let (product, other) = (dot(x, y), dot(y, y));
                if product.abs() > ORTHOGONAL * square.sqrt() * other.sqrt() {
                    let zeta = (other - square) / (2.0 * product);
                    let tan = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
                    let cos = 1.0 / tan.hypot(1.0);
                    for (a, b) in x.iter_mut().zip(y.iter_mut()) {
                        (*a, *b) = (cos * (*a - tan * *b), cos * (tan * *a + *b));
                    }
                    square = dot(x, x);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn medium(loss: f64, mean_cosine: f64, eta: f64) -> MediumLane {
        MediumLane { absorption: loss, scattering: 1.0 - loss, mean_cosine, eta }
    }

    /// Printed digits of an independent computation for isotropic scattering without a boundary. The
    /// bound is half a unit of the last digit, plus the quadrature's error.
    #[test]
    fn totals_equal_the_printed_digits() {
        let losses = [0.7, 0.5, 0.3, 0.2, 0.1, 0.05, 0.01, 0.001];
        let normal = [0.057214, 0.115226, 0.208680, 0.285255, 0.414947, 0.535541, 0.752721, 0.912845];
        let diffuse = [0.074451, 0.146544, 0.256557, 0.341867, 0.478024, 0.596669, 0.794564, 0.929713];
        for (i, loss) in losses.into_iter().enumerate() {
            let found = totals(&medium(loss, 0.0, 1.0), NODES);
            assert!((found.0 - diffuse[i]).abs().max((found.1 - normal[i]).abs()) < 0.51e-6, "{loss} {found:?}");
        }
    }

    /// The bounds are those of the head comment.
    #[test]
    fn twice_the_nodes_change_little() {
        for (g, bounds) in [(-0.9, (6e-8, 3e-7)), (0.0, (1e-11, 1e-11)), (0.8, (1e-11, 1e-11)), (0.95, (6e-8, 2e-6))] {
            for (eta, loss) in [(1.0, 0.3), (1.001, 0.3), (1.1, 0.1), (1.4, 0.1), (2.5, 0.1), (2.5, 1e-6)] {
                let (found, exact) = (totals(&medium(loss, g, eta), NODES), totals(&medium(loss, g, eta), 2 * NODES));
                assert!((found.0 - exact.0).abs() < bounds.0, "{g} {eta} {loss}: {found:?} {exact:?}");
                assert!((found.1 - exact.1).abs() < bounds.1, "{g} {eta} {loss}: {found:?} {exact:?}");
            }
        }
    }

    /// With little absorption the radiance is nearly uniform, and diffuse light loses 4 √(a / (3 − 3 g)) / (1 − Fdr)
    /// for the share a of absorption [vandeHulst80], with the internal reflectance Fdr by [Walsh26]. The bounds are
    /// rounding, and the next order with a coefficient of 4.
    #[test]
    fn energy_is_conserved() {
        for (eta, transmitted) in [(1.0, 1.0), (1.3, 0.5555432987), (1.5, 0.4036542403), (2.5, 0.1245013482)] {
            for (g, loss) in [(-0.9, 0.0), (0.0, 0.0), (0.95, 0.0), (-0.9, 1e-8), (0.0, 1e-12), (0.95, 1e-12)] {
                let expected = 4.0 * f64::sqrt(loss / (3.0 - 3.0 * g)) / transmitted;
                let found = 1.0 - diffuse_total(&medium(loss, g, eta));
                assert!((found - expected).abs() < 4.0 * expected * expected + 1e-12, "{g} {eta} {loss}: {found}");
            }
        }
    }

    /// The bound is the rounding that was found, with a factor of 10.
    #[test]
    fn extreme_media_have_a_total() {
        const TINY: f64 = f64::from_bits(1);
        for (absorption, scattering) in [(0.0, 0.0), (0.0, TINY), (TINY, 0.0), (TINY, f64::MAX), (f64::MAX, TINY)] {
            for (mean_cosine, eta) in [(1e-15 - 1.0, 1.0), (-0.0, 1.0 + 1e-15), (1.0 - 1e-15, f64::MAX)] {
                let medium = MediumLane { absorption, scattering, mean_cosine, eta };
                let (found, exact) = (totals(&medium, NODES), f64::from(scattering > absorption));
                assert!((found.0 - exact).abs().max((found.1 - exact).abs()) < 3e-10, "{medium:?} {found:?}");
            }
        }
    }
}
