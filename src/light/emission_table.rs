//! Points on a triangle in proportion to its emission, by a table over n² equal parts.
//!
//! A part has a tenth of the mean probability and nine tenths in proportion to its own mean emission. The tenth keeps
//! texels between the points at which the texture is looked at. A table takes 4 bytes a part: at most 1 kB.

use super::emission::Emission;
use super::parts::{centroids, in_part, part_at};
use crate::sampling::Distribution;
use crate::sampling::lanes::uniform_triangle;

/// Share of the probability that all parts share equally.
const FLOOR: f64 = 0.1;
/// Ratio of the mean square emission of the parts to the square of their mean above which a triangle has a table. The
/// ratio bounds the gain in variance.
const LEAST_VARIATION: f64 = 1.5;
/// Points of a side of the triangle at which the texture is looked at, at most.
const MOST_POINTS: u32 = 128;

/// The table.
#[derive(Debug)]
pub(super) struct EmissionTable {
    parts: Distribution,
    /// Parts of a side of the triangle.
    n: u32,
}

impl EmissionTable {
    /// Returns the table of `emission`; `None` if it varies so little that a table does not pay.
    pub(super) fn new(emission: &Emission) -> Option<Self> {
        if emission.is_constant() || emission.only_seen {
            return None;
        }
        let n = emission.divisions();
        let points = emission.points().min(MOST_POINTS);
        let within = centroids((points / n).max(1));
        let value = |barycentric| f64::from((emission.at(barycentric) * emission.covered(barycentric)).mean());
        let mean = |part| within.iter().map(|&at| value(in_part(n, part, at))).sum::<f64>() / within.len() as f64;
        let means: Vec<f64> = (0..n * n).map(mean).collect();
        let count = means.len() as f64;
        let [sum, squares] = means.iter().fold([0.0; 2], |[sum, squares], x| [sum + x, squares + x * x]);
        let worth = squares * count > LEAST_VARIATION * sum * sum;
        let weight = |x: f64| (1.0 - FLOOR) * x + FLOOR * sum / count;
        let parts = Distribution::new(means.into_iter().map(weight)).filter(|_| worth)?;
        Some(EmissionTable { parts, n })
    }

    /// Returns the density of the point over that of a uniform one.
    #[inline]
    pub(super) fn factor(&self, barycentric: [f64; 2]) -> f32 {
        self.parts.pmf(part_at(self.n, barycentric) as usize).value() * (self.n * self.n) as f32
    }

    /// Samples a point; returns the barycentric weights of the second and third vertex. A part of small probability
    /// resolves its points to 2⁻¹² of its area: the number that has chosen it is used again.
    #[inline]
    pub(super) fn sample(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let (part, _, u) = self.parts.sample_lanes(u);
        in_part(self.n, part, uniform_triangle([u, v]))
    }
}
