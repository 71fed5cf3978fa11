//! Generalised-Pareto fit of a tail (stand-in until the branch lands).

/// Above this shape the mean of the samples converges too slowly for any interval.
const HEAVY: f64 = 0.7;

/// The tail of a sample.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Tail {
    /// The shape.
    pub shape: f64,
    /// How many values it was fitted to.
    pub exceedances: usize,
    /// What they exceed.
    pub threshold: f64,
}

impl Tail {
    /// Whether it is too heavy.
    pub fn is_heavy(&self) -> bool {
        self.shape > HEAVY
    }
}

/// Fits the tail.
pub fn tail_shape(values: &mut [f64]) -> Option<Tail> {
    let n = values.len();
    let m = ((0.2 * n as f64).min(3.0 * (n as f64).sqrt())) as usize;
    if m < 5 {
        return None;
    }
    values.sort_by(f64::total_cmp);
    let threshold = values[n - m - 1];
    let x: Vec<f64> = values[n - m..].iter().map(|v| v - threshold).collect();
    let (n, last) = (m as f64, x[m - 1]);
    let quartile = x[((n / 4.0 + 0.5) as usize).max(1) - 1];
    if quartile <= 0.0 {
        return None;
    }
    let grid = 20 + n.sqrt() as usize;
    let theta = |j: usize| 1.0 / last + (1.0 - (grid as f64 / (j as f64 + 0.5)).sqrt()) / (3.0 * quartile);
    let k = |t: f64| x.iter().map(|x| (-t * x).ln_1p()).sum::<f64>() / n;
    let l: Vec<f64> = (0..grid).map(|j| (theta(j), k(theta(j)))).map(|(t, k)| n * ((-t / k).ln() - k - 1.0)).collect();
    let weight = |j: usize| 1.0 / l.iter().map(|o| (o - l[j]).exp()).sum::<f64>();
    let t: f64 = (0..grid).map(|j| theta(j) * weight(j)).sum();
    Some(Tail { shape: (k(t) * n + 5.0) / (n + 10.0), exceedances: m, threshold })
}
