//! Directional albedo of a GGX reflection with Schlick's Fresnel, from a small table made once by quadrature.
//!
//! With E₁(μ) the albedo under F = 1 and S(μ) the mean Schlick weight of what is reflected, linear in f0 and f90:
//! E(μ) = E₁ (f0 (1 − S) + f90 S). Two choices make bilinear interpolation accurate on a coarse grid. Both functions
//! depend on μ / α where α is small, so they lie over p = μ (1 + α) / (μ + α). And S = (1 − c)⁵ for an effective cosine c
//! that goes from about α at grazing angles to μ, so that c / (μ + α) is stored. Rows lie over √α. The error is stated at
//! [`ERROR`] and tested.

use super::fresnel::schlick_weight;
use super::ggx::{Ggx, reflect};
use crate::geometry::Local;
use crate::numeric::Scalar;
use crate::spectrum::Spectrum;
use std::sync::LazyLock;

/// Largest error of an interpolated albedo for f0 = f90 = 1, over roughness 1e-4 to 1 and cosines 1e-4 to 1.
pub const ERROR: f64 = 1e-3;

const CELLS: usize = 24;
const NODES: usize = CELLS + 1;
/// Points along each axis of the square of visible normals: half the circle by symmetry, and the cap's height.
const QUADRATURE: usize = 16;
/// The cosine that stands for the limit at grazing angles.
const GRAZING: f64 = 1e-8;
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
        let x = ggx.alpha().sqrt() * CELLS as f32;
        let row = (x as usize).min(CELLS - 1);
        Albedo { table: &TABLE, row, weight: x - row as f32, alpha: ggx.alpha() }
    }

    /// At the cosine `cos` > 0.
    #[inline]
    pub fn at<T: Scalar>(&self, cos: T) -> Moments<T> {
        self.table.at(self.row, self.weight, self.alpha, cos)
    }

    /// The albedo for light from everywhere, 2 ∫ E(μ) μ dμ.
    pub fn mean(&self, f0: Spectrum, f90: Spectrum) -> Spectrum {
        let mix = |column: &[f32; NODES]| column[self.row] + (column[self.row + 1] - column[self.row]) * self.weight;
        let (white, grazing) = (mix(&self.table.mean_white), mix(&self.table.mean_schlick));
        f0 * (white - grazing) + f90 * grazing
    }
}

type Rows = [[f32; NODES]; NODES];

/// One row for each √α.
#[derive(Debug)]
struct Table {
    white: Rows,
    cosine: Rows,
    mean_white: [f32; NODES],
    mean_schlick: [f32; NODES],
}

impl Table {
    fn new() -> Self {
        let empty = [[0.0; NODES]; NODES];
        let mut table = Table { white: empty, cosine: empty, mean_white: [0.0; NODES], mean_schlick: [0.0; NODES] };
        for row in 0..NODES {
            // row 0 stands for the limit of no roughness, which f32 does not tell from this one
            let alpha = node(row).powi(2).max(1e-4);
            for i in 0..NODES {
                let cos = (node(i) * alpha / (1.0 + alpha - node(i))).max(GRAZING);
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
            let here = self.at(row.min(CELLS - 1), if row == CELLS { 1.0 } else { 0.0 }, alpha, cos);
            white += 2.0 * cos * here.white / MEAN_POINTS as f64;
            grazing += 2.0 * cos * here.white * here.schlick / MEAN_POINTS as f64;
        }
        (white as f32, grazing as f32)
    }

    #[inline]
    fn at<T: Scalar>(&self, row: usize, weight: f32, alpha: f32, cos: T) -> Moments<T> {
        let (alpha, cos) = (T::of(f64::from(alpha)), cos.min(T::ONE));
        let sum = cos + alpha;
        let p = cos * (T::ONE + alpha) / sum;
        let white = bilinear(&self.white, row, weight, p);
        Moments { white, schlick: schlick_weight(sum * bilinear(&self.cosine, row, weight, p)) }
    }
}

/// Position of a node, 0 to 1.
fn node(i: usize) -> f64 {
    i as f64 / CELLS as f64
}

#[inline]
fn bilinear<T: Scalar>(rows: &Rows, row: usize, weight: f32, x: T) -> T {
    let x = x * T::of(CELLS as f64);
    let i = (x.value() as usize).min(CELLS - 1);
    let across = |i: usize| T::of(f64::from(rows[row][i] + (rows[row + 1][i] - rows[row][i]) * weight));
    let (a, b) = (across(i), across(i + 1));
    a + (b - a) * (x - T::of(i as f64))
}

/// The moments at `cos` by quadrature over the square of visible normals, n² points: the midpoint rule, after a
/// substitution that flattens both ends of the cap where its sine has a root.
pub fn moments(ggx: Ggx, cos: f64, n: usize) -> Moments<f64> {
    let known = Local::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
    let (mut white, mut grazing) = (0.0, 0.0);
    for i in 0..n {
        let t = (i as f64 + 0.5) / n as f64;
        let v = t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t);
        let dv = 30.0 * (t * (1.0 - t)).powi(2) / n as f64;
        for j in 0..n {
            let (sin, cos) = (std::f64::consts::PI * (j as f64 + 0.5) / n as f64).sin_cos();
            let h = ggx.cap_normal(known, [cos, sin], v);
            let other = reflect(known, h);
            if other.z > 0.0 {
                let weight = ggx.reflection(known, other, h) * other.z / ggx.reflection_pdf(known, h) * dv / n as f64;
                white += weight;
                grazing += weight * schlick_weight(known.dot(h));
            }
        }
    }
    Moments { white, schlick: grazing / white }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measure() {
        let (mut w1, mut w2) = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0));
        for i in 0..40 {
            for j in 0..40 {
                let a = 10f64.powf(-4.0 + 4.0 * i as f64 / 39.0) as f32;
                let c = 10f64.powf(-4.0 + 4.0 * j as f64 / 39.0);
                let ggx = Ggx::new(a);
                let m = moments(ggx, c, 128);
                let q = Albedo::of(ggx).at(c);
                let e = (m.white - q.white).abs();
                if e > w1.0 {
                    w1 = (e, a as f64, c);
                }
                let e = (m.white * m.schlick - q.white * q.schlick).abs();
                if e > w2.0 {
                    w2 = (e, a as f64, c);
                }
            }
        }
        println!("{CELLS} {QUADRATURE} {w1:?} {w2:?}");
        let mut t = 1e9f64;
        for _ in 0..8 {
            let s = std::time::Instant::now();
            let x = Table::new();
            std::hint::black_box(x);
            t = t.min(s.elapsed().as_secs_f64());
        }
        println!("table {t}");
    }
}
