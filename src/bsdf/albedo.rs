//! Directional albedo of GGX reflection with Schlick's Fresnel, from a small table computed once by quadrature.
//!
//! Let E₁(μ) be the albedo under F = 1 and S(μ) the mean Schlick weight of the reflected light. The albedo is linear in
//! f0 and f90: E(μ) = E₁ (f0 (1 − S) + f90 S). Two parametrisations make bilinear interpolation accurate on a coarse
//! grid. For small α both functions depend on μ / α, so that they are tabulated over the square root of p = μ (1 + k
//! α) / (μ + k α). S = (1 − c)⁵ for an effective cosine c that ranges from about α at grazing angles to μ, so that
//! c / (μ + α) is stored. Rows are spaced uniformly in √α.

use super::fresnel::schlick_weight;
use super::ggx::{DIRAC_ALPHA, Ggx, reflect};
use crate::geometry::Local;
use crate::numeric::Scalar;
use crate::spectrum::Spectrum;
use etendue_lanes::{Float, Int, MOST_LANES, ROW};
use std::sync::LazyLock;

/// Largest error of an interpolated albedo, for f0 and f90 up to 1, α from 1e-4 to 1 and cosines from 1e-4 to 1.
/// Measured against a 24 × 48 point quadrature on a 40 × 60 grid: 3.2e-3, at α = 1 and cosines of 4e-4; the table's own
/// quadrature contributes 3e-5. The table takes 11 ms.
pub const ERROR: f64 = 3.5e-3;

/// Intervals in √α, and in the coordinate of the cosine.
const ROWS: usize = 24;
const CELLS: usize = 20;
/// Quadrature points over the angle to the plane of incidence, and over the angle within it.
const QUADRATURE: [usize; 2] = [8, 20];
/// k of the module head: nodes are concentrated below μ ≈ k α.
const KNEE: f64 = 8.0;
/// Cosine over α that represents the limit at grazing angles.
const GRAZING: f64 = 1e-4;
/// c is derived from S at cosines up to this bound. Above, S is too small for its fifth root to be smooth: at α = 0.004
/// the few facets of GGX's long tail make c(1) = 0.94, and interpolation would spread this to relevant cosines.
const STEEP: f64 = 0.5;
/// Quadrature points of the hemispherical means.
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
pub struct AlbedoMoments<T> {
    /// Albedo under F = 1.
    pub white: T,
    /// Mean of (1 − cos)⁵ over the reflected light.
    pub schlick: T,
}

/// [`AlbedoMoments`] over lanes.
#[derive(Debug, Clone, Copy)]
pub struct LaneMoments<F> {
    white: F,
    schlick: F,
}

/// Returns the columns of a row of a table in each lane. All rows are found before the first is read: calls of closures
/// that search are not inlined into [`Float::rows`].
#[inline(always)]
fn columns_of<F: Float>(row: impl Fn(usize) -> &'static [f32; ROW]) -> [F; ROW] {
    let mut rows = [row(0); MOST_LANES];
    for (lane, found) in rows.iter_mut().enumerate().take(F::LANES) {
        *found = row(lane);
    }
    F::rows(|lane| rows[lane])
}

impl<F: Float> LaneMoments<F> {
    /// Does [`Albedo::at`] in every lane, for the albedos that [`Albedo::place`] describes.
    #[inline(always)]
    pub fn new([row, weight, alpha]: [F; 3], cos: F) -> Self {
        let one = F::splat(1.0);
        let cos = cos.min(one);
        let (sum, knee) = (cos + alpha, alpha * F::splat(KNEE as f32));
        let p = (cos * (one + knee) / (cos + knee)).sqrt();
        let x = p * F::splat(CELLS as f32);
        let cell = x.min(F::splat((CELLS - 1) as f32)).to_int();
        let (row, part, rest) = (row.to_int(), x - F::from_int(cell), weight);
        let table = &*TABLE;
        let interpolated = |[left, right, below_left, below_right]: [F; 4]| {
            let (a, b) = (left + (below_left - left) * rest, right + (below_right - right) * rest);
            a + (b - a) * part
        };
        let [a, b, c, d, e, f, g, h] =
            columns_of::<F>(|lane| &table.corners[row.lane(lane) as usize][cell.lane(lane) as usize]);
        let m = (one - sum * interpolated([e, f, g, h])).max(F::splat(0.0));
        LaneMoments { white: interpolated([a, b, c, d]), schlick: (m * m) * (m * m) * m }
    }

    /// See [`AlbedoMoments::albedo`].
    #[inline(always)]
    pub fn albedo(&self, [f0, f90]: [Spectrum<F>; 2]) -> Spectrum<F> {
        (f0 * (F::splat(1.0) - self.schlick) + f90 * self.schlick) * self.white
    }
}

/// [`Albedo`] over lanes.
#[derive(Debug, Clone, Copy)]
pub struct LaneAlbedo<F> {
    row: F,
    weight: F,
    alpha: F,
}

impl<F: Float> LaneAlbedo<F> {
    /// See [`Albedo::of`]; `alpha` is that of [`Ggx::alpha`].
    #[inline(always)]
    pub fn of(alpha: F) -> Self {
        let x = alpha.sqrt() * F::splat(ROWS as f32);
        let row = F::from_int(x.min(F::splat((ROWS - 1) as f32)).to_int());
        LaneAlbedo { row, weight: x - row, alpha }
    }

    /// See [`Albedo::place`].
    #[inline(always)]
    pub fn place(&self) -> [F; 3] {
        [self.row, self.weight, self.alpha]
    }

    /// See [`Albedo::mean`].
    #[inline(always)]
    pub fn mean(&self, [f0, f90]: [Spectrum<F>; 2]) -> Spectrum<F> {
        let (rows, table) = (self.row.to_int(), &*TABLE);
        let [white, next_white, schlick, next_schlick, ..] =
            columns_of::<F>(|lane| &table.means[rows.lane(lane) as usize]);
        let white = white + (next_white - white) * self.weight;
        let grazing = schlick + (next_schlick - schlick) * self.weight;
        f0 * (white - grazing) + f90 * grazing
    }
}

impl<T: Scalar> AlbedoMoments<T> {
    /// Returns the albedo for reflectance `f0` at normal and `f90` at grazing incidence.
    #[inline]
    pub fn albedo(&self, f0: Spectrum, f90: Spectrum) -> Spectrum<T> {
        f0.cast().lerp(f90.cast(), self.schlick) * self.white
    }
}

impl Albedo {
    /// Returns the albedo of `ggx`.
    pub fn of(ggx: Ggx) -> Self {
        let LaneAlbedo { row, weight, alpha } = LaneAlbedo::of(ggx.alpha());
        Albedo { table: &TABLE, row: row as usize, weight, alpha }
    }

    /// Returns the row of its table, the weight of the next one, and α, for [`LaneMoments::new`].
    pub fn place(&self) -> [f32; 3] {
        [self.row as f32, self.weight, self.alpha]
    }

    /// Evaluates at the cosine `cos` > 0.
    #[inline]
    pub fn at<T: Scalar>(&self, cos: T) -> AlbedoMoments<T> {
        self.table.at(self.row, self.weight, self.alpha, cos)
    }

    /// Returns the albedo under uniform illumination, 2 ∫ E(μ) μ dμ.
    pub fn mean(&self, f0: Spectrum, f90: Spectrum) -> Spectrum {
        let [white, next_white, schlick, next_schlick, ..] = self.table.means[self.row];
        let mix = |here: f32, next: f32| here + (next - here) * self.weight;
        let (white, grazing) = (mix(white, next_white), mix(schlick, next_schlick));
        f0 * (white - grazing) + f90 * grazing
    }
}

static TABLE: LazyLock<Table> = LazyLock::new(Table::new);

type Rows = [[f32; CELLS + 1]; ROWS + 1];

/// One row for each √α.
#[derive(Debug)]
struct Table {
    white: Rows,
    cosine: Rows,
    /// Both at the corners of each cell, as kernels read them: left, right, and these in the next row.
    corners: Box<[[[f32; ROW]; CELLS]; ROWS]>,
    /// Hemispherical means of E₁ in a row and the next, then those of E₁ S.
    means: [[f32; ROW]; ROWS],
}

impl Table {
    fn new() -> Self {
        let empty = [[0.0; CELLS + 1]; ROWS + 1];
        let mut table = Table {
            white: empty,
            cosine: empty,
            corners: Box::new([[[0.0; ROW]; CELLS]; ROWS]),
            means: [[0.0; ROW]; ROWS],
        };
        let rule = Rule::new(QUADRATURE);
        let mut means = Vec::with_capacity(ROWS + 1);
        for row in 0..=ROWS {
            // Row 0 represents everything smoother than the least roughness.
            let alpha = (row as f64 / ROWS as f64).powi(2).max(f64::from(DIRAC_ALPHA));
            let ggx = Ggx::new(alpha as f32);
            for i in 0..=CELLS {
                let (p, knee) = ((i as f64 / CELLS as f64).powi(2), KNEE * alpha);
                let cos = (p * knee / (1.0 + knee - p)).max(GRAZING * alpha);
                let (steep, exact) = (cos.min(STEEP), rule.moments(ggx, cos));
                let schlick = if cos > STEEP { rule.moments(ggx, steep).schlick } else { exact.schlick };
                table.white[row][i] = exact.white as f32;
                table.cosine[row][i] = ((1.0 - schlick.powf(0.2)) / (steep + alpha)) as f32;
            }
            if row == 0 {
                // Lookup position of a mirror at any angle.
                (table.white[row][CELLS], table.cosine[row][CELLS]) = (1.0, 1.0);
            }
            means.push(table.row_means(row, alpha as f32));
        }
        for (row, pair) in means.windows(2).enumerate() {
            table.means[row][..4].copy_from_slice(&[pair[0][0], pair[1][0], pair[0][1], pair[1][1]]);
        }
        for (row, cells) in table.corners.iter_mut().enumerate() {
            for (i, corners) in cells.iter_mut().enumerate() {
                let of = |rows: &Rows| [rows[row][i], rows[row][i + 1], rows[row + 1][i], rows[row + 1][i + 1]];
                let ([a, b, c, d], [e, f, g, h]) = (of(&table.white), of(&table.cosine));
                *corners = [a, b, c, d, e, f, g, h];
            }
        }
        table
    }

    /// Returns 2 ∫ E₁ μ dμ and 2 ∫ E₁ S μ dμ of [`Table::at`] in a row.
    fn row_means(&self, row: usize, alpha: f32) -> [f32; 2] {
        let (mut white, mut grazing) = (0.0, 0.0);
        for i in 0..MEAN_POINTS {
            let cos = (i as f64 + 0.5) / MEAN_POINTS as f64;
            let here = self.at(row.min(ROWS - 1), if row == ROWS { 1.0 } else { 0.0 }, alpha, cos);
            white += 2.0 * cos * here.white / MEAN_POINTS as f64;
            grazing += 2.0 * cos * here.white * here.schlick / MEAN_POINTS as f64;
        }
        [white as f32, grazing as f32]
    }

    #[inline]
    fn at<T: Scalar>(&self, row: usize, weight: f32, alpha: f32, cos: T) -> AlbedoMoments<T> {
        let (alpha, cos) = (T::of(f64::from(alpha)), cos.min(T::ONE));
        let sum = cos + alpha;
        let knee = alpha * T::of(KNEE);
        let p = (cos * (T::ONE + knee) / (cos + knee)).sqrt();
        let white = bilinear(&self.white, row, weight, p);
        AlbedoMoments { white, schlick: schlick_weight(sum * bilinear(&self.cosine, row, weight, p)) }
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

/// Computes the moments at `cos` by quadrature over the visible normals that reflect above the horizon, with m × n
/// points.
///
/// Stretched by 1 / α the facets form a hemisphere. Let τ be the angle of a stretched normal to the plane of incidence,
/// and ω its angle to the vertical within that plane. The density of visible normals is cos² τ cos(ω − ν) dτ dω, with ν
/// the angle of the stretched view direction. With T = tan² τ and x = tan ω, the reflection is above the horizon where
/// cos α² (1 + T) x² − 2 α sin x + cos (α² T − 1) < 0. The domain lies between the roots, for T up to the value at
/// which they coincide. The integrand is smooth there.
pub fn moments(ggx: Ggx, cos: f64, points: [usize; 2]) -> AlbedoMoments<f64> {
    Rule::new(points).moments(ggx, cos)
}

/// Quadrature points and weights over τ and ω.
struct Rule([Vec<(f64, f64)>; 2]);

impl Rule {
    fn new(points: [usize; 2]) -> Self {
        Rule(points.map(crowded_points))
    }

    /// See [`moments`].
    fn moments(&self, ggx: Ggx, cos: f64) -> AlbedoMoments<f64> {
        let (alpha, sin) = (f64::from(ggx.alpha()), (1.0 - cos * cos).max(0.0).sqrt());
        let known = Local::new(sin, 0.0, cos);
        let view = (alpha * sin).atan2(cos);
        let a2 = alpha * alpha;
        let most = ((1.0 - a2) + ((1.0 - a2).powi(2) + 4.0 * a2 / (cos * cos)).sqrt()) / (2.0 * a2);
        let reach = most.sqrt().atan();
        // Half of the hemisphere; the other half is symmetric.
        let seen = std::f64::consts::FRAC_PI_4 * (1.0 + view.cos());
        let Rule([tilts, turns]) = self;
        let (mut white, mut grazing) = (0.0, 0.0);
        for &(tilt, dt) in tilts {
            let (sin_tau, cos_tau) = (reach * tilt).sin_cos();
            let t = (sin_tau / cos_tau).powi(2);
            let sum = sin + (sin * sin + cos * cos * (1.0 + t) * (1.0 - a2 * t)).max(0.0).sqrt();
            let (low, high) = ((cos * (a2 * t - 1.0) / (alpha * sum)).atan(), (sum / (cos * alpha * (1.0 + t))).atan());
            for &(x, dx) in turns {
                let omega = low + (high - low) * x;
                let h = Local::new(alpha * omega.sin() * cos_tau, alpha * sin_tau, omega.cos() * cos_tau).normalized();
                let other = reflect(known, h);
                let share = cos_tau * cos_tau * (omega - view).cos() * reach * dt * (high - low) * dx / seen;
                let ratio = ggx.reflection(known, other, h) * other.z.max(0.0) / ggx.reflection_pdf(known, h);
                white += ratio * share;
                grazing += ratio * share * schlick_weight(known.dot(h));
            }
        }
        AlbedoMoments { white, schlick: grazing / white }
    }
}

/// Returns n points of the unit interval, denser at both ends, and their weights: Gauss–Legendre nodes, by Newton
/// iteration from Tricomi's estimate, mapped by 3 t² − 2 t³. Facets turn away within α of the end of ω.
fn crowded_points(n: usize) -> Vec<(f64, f64)> {
    const ITERATIONS: usize = 4;
    let point = |i: usize| {
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..ITERATIONS {
            let (mut p, mut before) = (x, 1.0);
            for k in 2..=n {
                let k = k as f64;
                (p, before) = (((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k, p);
            }
            slope = n as f64 * (x * p - before) / (x * x - 1.0);
            x -= p / slope;
        }
        let (t, weight) = (0.5 + 0.5 * x, ((1.0 - x * x) * slope * slope).recip());
        (t * t * (3.0 - 2.0 * t), weight * 6.0 * t * (1.0 - t))
    };
    (0..n).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn logarithmic(i: u32, n: u32) -> f64 {
        10f64.powf(-4.0 * f64::from(i) / f64::from(n - 1))
    }

    #[test]
    fn interpolated_albedo_is_as_close_to_quadrature_as_stated() {
        for i in 0..40 {
            let ggx = Ggx::new(logarithmic(i, 40) as f32);
            for cos in (0..60).map(|j| logarithmic(j, 60)) {
                let (exact, table) = (moments(ggx, cos, [24, 48]), Albedo::of(ggx).at(cos));
                let grazing = exact.white * exact.schlick - table.white * table.schlick;
                let normal = exact.white * (1.0 - exact.schlick) - table.white * (1.0 - table.schlick);
                for error in [exact.white - table.white, grazing, normal] {
                    assert!(error.abs() < ERROR, "alpha {} cos {cos}: {error}", ggx.alpha());
                }
            }
        }
    }

    #[test]
    fn albedo_quadrature_matches_closed_form_at_normal_incidence() {
        let exact = 1.0 - 2f64.ln();
        // The remainder of a rule of this order is below the rounding of its sums.
        assert!((moments(Ggx::new(1.0), 1.0, [16, 32]).white - exact).abs() < 1e-10);
    }

    #[test]
    fn a_smooth_surface_reflects_by_schlick_alone() {
        for cos in [1.0f64, 0.5, 0.1, 1e-3] {
            let table = Albedo::of(Ggx::new(0.0)).at(cos);
            // Rounding of f32 entries, and of their fifth power.
            let tolerance = 16.0 * f64::from(f32::EPSILON);
            assert!((table.white - 1.0).abs() < tolerance && (table.schlick - schlick_weight(cos)).abs() < tolerance);
        }
    }
}
