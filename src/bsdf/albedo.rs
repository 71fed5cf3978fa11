//! Directional albedo of a GGX reflection with Schlick's Fresnel, from a small table made once by quadrature.
//!
//! With E₁(μ) the albedo under F = 1 and S(μ) the mean Schlick weight of what is reflected, linear in f0 and f90:
//! E(μ) = E₁ (f0 (1 − S) + f90 S). Two choices make bilinear interpolation accurate on a coarse grid. Both functions
//! depend on μ / α where α is small, so they lie over the root of p = μ (1 + k α) / (μ + k α). And S = (1 − c)⁵ for an
//! effective cosine c that goes from about α at grazing angles to μ, so that c / (μ + α) is stored. Rows lie over √α.

use super::fresnel::schlick_weight;
use super::ggx::{Ggx, reflect};
use crate::geometry::Local;
use crate::numeric::Scalar;
use crate::spectrum::Spectrum;
use std::sync::LazyLock;

/// Largest error of an interpolated albedo, for f0 and f90 up to 1, α from 1e-4 to 1 and cosines from 1e-4 to 1. Measured
/// against a 160 × 64 point quadrature on a 40 × 40 grid: 3.8e-3 at grazing angles, where up to 3.2e-3 are the table's own
/// quadrature. The table takes 7 ms.
pub const ERROR: f64 = 4e-3;

/// Intervals over √α, and over the coordinate of the cosine.
const ROWS: usize = 24;
const CELLS: usize = 20;
/// Points over half the circle (the other is alike) and over the cap's height.
const QUADRATURE: [usize; 2] = [20, 10];
/// Bisections for the horizon: few, since the integrand is zero beyond.
const BISECTIONS: u32 = 12;
/// k of the module head: nodes crowd below μ ≈ k α.
const KNEE: f64 = 8.0;
/// The cosine over α that stands for the limit at grazing angles.
const GRAZING: f64 = 1e-4;
/// Cosines of the hemispherical means.
const MEAN_POINTS: usize = 64;

/// Albedo of one roughness as a function of the cosine.
#[derive(Debug, Clone, Copy)]
pub struct Albedo {
    table: &'static Table,
    row: usize,
    weight: f32,
    alpha: f32,
}

/// E₁ and the mean Schlick weight at one cosine.
#[derive(Debug, Clone, Copy)]
pub struct Moments<T> {
    /// Albedo under F = 1.
    pub white: T,
    /// Mean of (1 − cos)⁵ over what is reflected.
    pub schlick: T,
}

impl<T: Scalar> Moments<T> {
    /// The albedo for reflectance `f0` at normal and `f90` at grazing incidence.
    #[inline]
    pub fn albedo(&self, f0: Spectrum, f90: Spectrum) -> Spectrum<T> {
        f0.cast().lerp(f90.cast(), self.schlick) * self.white
    }
}

impl Albedo {
    /// The albedo of `ggx`.
    pub fn of(ggx: Ggx) -> Self {
        static TABLE: LazyLock<Table> = LazyLock::new(Table::new);
        let x = ggx.alpha().sqrt() * ROWS as f32;
        let row = (x as usize).min(ROWS - 1);
        Albedo { table: &TABLE, row, weight: x - row as f32, alpha: ggx.alpha() }
    }

    /// At the cosine `cos` > 0.
    #[inline]
    pub fn at<T: Scalar>(&self, cos: T) -> Moments<T> {
        self.table.at(self.row, self.weight, self.alpha, cos)
    }

    /// The albedo for light from everywhere, 2 ∫ E(μ) μ dμ.
    pub fn mean(&self, f0: Spectrum, f90: Spectrum) -> Spectrum {
        let mix = |column: &[f32; ROWS + 1]| column[self.row] + (column[self.row + 1] - column[self.row]) * self.weight;
        let (white, grazing) = (mix(&self.table.mean_white), mix(&self.table.mean_schlick));
        f0 * (white - grazing) + f90 * grazing
    }
}

type Rows = [[f32; CELLS + 1]; ROWS + 1];

/// One row for each √α.
#[derive(Debug)]
struct Table {
    white: Rows,
    cosine: Rows,
    mean_white: [f32; ROWS + 1],
    mean_schlick: [f32; ROWS + 1],
}

impl Table {
    fn new() -> Self {
        let empty = [[0.0; CELLS + 1]; ROWS + 1];
        let mut table = Table { white: empty, cosine: empty, mean_white: [0.0; ROWS + 1], mean_schlick: [0.0; ROWS + 1] };
        for row in 0..=ROWS {
            // row 0 stands for the limit of no roughness, which f32 cannot tell from this
            let alpha = (row as f64 / ROWS as f64).powi(2).max(1e-7);
            for i in 0..=CELLS {
                let (p, knee) = ((i as f64 / CELLS as f64).powi(2), KNEE * alpha);
                let cos = (p * knee / (1.0 + knee - p)).max(GRAZING * alpha);
                let exact = moments(Ggx::new(alpha as f32), cos, QUADRATURE);
                table.white[row][i] = exact.white as f32;
                table.cosine[row][i] = ((1.0 - exact.schlick.powf(0.2)) / (cos + alpha)) as f32;
            }
            (table.mean_white[row], table.mean_schlick[row]) = table.means(row, alpha as f32);
        }
        table
    }

    /// 2 ∫ E₁ μ dμ and 2 ∫ E₁ S μ dμ of what [`Table::at`] gives at a row.
    fn means(&self, row: usize, alpha: f32) -> (f32, f32) {
        let (mut white, mut grazing) = (0.0, 0.0);
        for i in 0..MEAN_POINTS {
            let cos = (i as f64 + 0.5) / MEAN_POINTS as f64;
            let here = self.at(row.min(ROWS - 1), if row == ROWS { 1.0 } else { 0.0 }, alpha, cos);
            white += 2.0 * cos * here.white / MEAN_POINTS as f64;
            grazing += 2.0 * cos * here.white * here.schlick / MEAN_POINTS as f64;
        }
        (white as f32, grazing as f32)
    }

    #[inline]
    fn at<T: Scalar>(&self, row: usize, weight: f32, alpha: f32, cos: T) -> Moments<T> {
        let (alpha, cos) = (T::of(f64::from(alpha)), cos.min(T::ONE));
        let sum = cos + alpha;
        let knee = alpha * T::of(KNEE);
        let p = (cos * (T::ONE + knee) / (cos + knee)).sqrt();
        let white = bilinear(&self.white, row, weight, p);
        Moments { white, schlick: schlick_weight(sum * bilinear(&self.cosine, row, weight, p)) }
    }
}

#[inline]
fn bilinear<T: Scalar>(rows: &Rows, row: usize, weight: f32, x: T) -> T {
    let x = x * T::of(CELLS as f64);
    let i = (x.value() as usize).min(CELLS - 1);
    let across = |i: usize| T::of(f64::from(rows[row][i] + (rows[row + 1][i] - rows[row][i]) * weight));
    let (a, b) = (across(i), across(i + 1));
    a + (b - a) * (x - T::of(i as f64))
}

/// The moments at `cos` by quadrature over the square of visible normals, m × n points: azimuth, and the heights of the
/// cap that reflect above the horizon. Points crowd at the ends, where facets turn away from `cos`, the cap's sine has a
/// root and the horizon cuts.
pub fn moments(ggx: Ggx, cos: f64, [m, n]: [usize; 2]) -> Moments<f64> {
    let known = Local::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
    let heights = crowded_points(n);
    let (mut white, mut grazing) = (0.0, 0.0);
    for (azimuth, share) in crowded_points(m) {
        let (sin, cos) = (std::f64::consts::PI * azimuth).sin_cos();
        let facet = |v: f64| ggx.cap_normal(known, [cos, sin], v);
        let horizon = below_horizon(|v| reflect(known, facet(v)).z);
        for &(v, dv) in &heights {
            let h = facet(horizon * v);
            let other = reflect(known, h);
            let ratio = ggx.reflection(known, other, h) * other.z.max(0.0) / ggx.reflection_pdf(known, h);
            white += ratio * share * horizon * dv;
            grazing += ratio * share * horizon * dv * schlick_weight(known.dot(h));
        }
    }
    Moments { white, schlick: grazing / white }
}

/// Points of the unit interval, denser at both ends, and their weights: the midpoint rule under a polynomial with two
/// flat derivatives at each end.
fn crowded_points(n: usize) -> Vec<(f64, f64)> {
    let midpoints = (0..n).map(|i| (i as f64 + 0.5) / n as f64);
    let slope = |t: f64| (t * (1.0 - t)).powi(2);
    let total: f64 = midpoints.clone().map(slope).sum();
    midpoints.map(|t| (t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t), slope(t) / total)).collect()
}

/// A little beyond where `height`, positive at 0 and negative at 1, changes sign.
fn below_horizon(height: impl Fn(f64) -> f64) -> f64 {
    let (mut above, mut below) = (0.0, 1.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (above + below);
        *(if height(middle) > 0.0 { &mut above } else { &mut below }) = middle;
    }
    below
}

#[cfg(test)]
mod tests {
    use super::*;

    fn logarithmic(i: u32, n: u32) -> f64 {
        10f64.powf(-4.0 * f64::from(i) / f64::from(n - 1))
    }

    #[test]
    fn interpolated_albedo_is_as_close_to_quadrature_as_stated() {
        for i in 0..20 {
            let ggx = Ggx::new(logarithmic(i, 20) as f32);
            for cos in (0..20).map(|j| logarithmic(j, 20)) {
                let (exact, table) = (moments(ggx, cos, [160, 64]), Albedo::of(ggx).at(cos));
                let grazing = exact.white * exact.schlick - table.white * table.schlick;
                let normal = exact.white * (1.0 - exact.schlick) - table.white * (1.0 - table.schlick);
                for error in [exact.white - table.white, grazing, normal] {
                    assert!(error.abs() < ERROR, "alpha {} cos {cos}: {error}", ggx.alpha());
                }
            }
        }
    }

    #[test]
    fn quadrature_agrees_with_the_closed_form_at_normal_incidence_of_full_roughness() {
        let exact = 1.0 - 2f64.ln();
        assert!((moments(Ggx::new(1.0), 1.0, [16, 64]).white - exact).abs() < 1e-5);
    }

    #[test]
    fn a_smooth_surface_reflects_by_schlick_alone() {
        for cos in [1.0, 0.5, 0.1, 1e-3] {
            let table = Albedo::of(Ggx::new(0.0)).at(cos);
            // roundings of f32 entries, and their five-fold power
            let tolerance = 16.0 * f64::from(f32::EPSILON);
            assert!((table.white - 1.0).abs() < tolerance && (table.schlick - schlick_weight(cos)).abs() < tolerance);
        }
    }
}
