//! The strips between rows of texel centres: their selection, and heights in them.
//!
//! Heights are kept as versines, 1 − |cos θ|. Near the poles cosines lose all precision in f32, and versines none.

use crate::numeric::BELOW_ONE;
use crate::sampling::Distribution;
use crate::sampling::lanes::{linear, signed_turn};
use etendue_lanes::{Float, Int, ROW, Vec3};
use std::f64::consts::PI;

/// Strip between the rows of centres j − 1 and j, as a row of numbers: see [`strip`].
type Strip = [f32; ROW];

/// Returns the integral over the solid angle of each strip of a map whose rows have these `means`.
pub(super) fn integrals(means: &[f64]) -> Vec<f64> {
    let count = means.len();
    let integral = |j: usize| {
        let [[from, to], [above, below]] = [versines(j, count), rows(j, count).map(|y| means[y])];
        PI * (to - from).abs() * (above + below)
    };
    (0..=count).map(integral).collect()
}

/// All strips of a map.
#[derive(Debug)]
pub(super) struct Strips {
    strips: Vec<Strip>,
    choice: Distribution,
}

/// A point between two rows of centres in each lane.
pub(super) struct Height<F: Float> {
    pub(super) strip: F::Int,
    /// Position from top to bottom in height.
    pub(super) height: F,
    /// The same in angle.
    pub(super) angle: F,
    /// Sine and cosine of the angle to the zenith.
    pub(super) sin: F,
    pub(super) cos: F,
}

impl Strips {
    /// Returns the strips of a map whose rows have these `means`, and ∫ of its lane mean over the sphere; `None` for
    /// the strips if it is dark.
    pub(super) fn new(means: &[f64]) -> (Option<Self>, f64) {
        let weights = integrals(means);
        let integral = weights.iter().sum();
        let strips = (0..=means.len()).map(|j| strip(j, means)).collect();
        (Distribution::new(weights).map(|choice| Strips { strips, choice }), integral)
    }

    /// Returns the memory held, in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.strips[..])
    }

    /// Returns the number of rows of texels.
    #[inline(always)]
    fn count(&self) -> usize {
        self.strips.len() - 1
    }

    /// Selects a height by the mean radiance at it.
    #[inline(always)]
    pub(super) fn sample<F: Float>(&self, u: F) -> Height<F> {
        let (strip, _, rest) = self.choice.sample_lanes(u);
        let [from, extent, _, side, above, below, ..] = F::rows(|lane| &self.strips[strip.lane(lane) as usize]);
        let height = linear(rest, [above, below]);
        let (zero, one) = (F::splat(0.0), F::splat(1.0));
        let versine = (from + extent * height).max(zero);
        let (sin, cos) = ((versine * (F::splat(2.0) - versine)).sqrt(), side * (one - versine));
        let angle = (self.row(sin, cos) - F::from_int(strip)).max(zero).min(one);
        Height { strip, height, angle, sin, cos }
    }

    /// Returns strip and positions in angle and in height of the unit direction `w`.
    #[inline(always)]
    pub(super) fn place<F: Float>(&self, w: Vec3<F>) -> (F::Int, F, F) {
        let squared = w.x * w.x + w.z * w.z;
        let row = self.row(squared.sqrt(), w.y);
        let strip = row.to_int();
        let [from, _, per_extent, side, ..] = F::rows(|lane| &self.strips[strip.lane(lane) as usize]);
        let one = F::splat(1.0);
        let cos = side * w.y;
        let versine = F::select(cos.below(F::splat(0.0)), one - cos, squared / (one + cos));
        let height = ((versine - from) * per_extent).max(F::splat(0.0)).min(F::splat(BELOW_ONE));
        (strip, row - F::from_int(strip), height)
    }

    /// Returns the row of the angle to the zenith, in strips.
    #[inline(always)]
    fn row<F: Float>(&self, sin: F, cos: F) -> F {
        signed_turn(sin, cos) * F::splat(2.0 * self.count() as f32) + F::splat(0.5)
    }
}

/// Returns the rows of centres above and below strip `j` of a map with `count` rows.
#[inline(always)]
pub(super) fn rows(j: usize, count: usize) -> [usize; 2] {
    [j.saturating_sub(1), j.min(count - 1)]
}

/// Returns the row of numbers of strip `j`: the versine at its top, that at its bottom less that at its top, the inverse
/// of this, the sign of the cosines that they belong to, and the means over the rows above and below.
fn strip(j: usize, means: &[f64]) -> Strip {
    let count = means.len();
    let [from, to] = versines(j, count);
    let [above, below] = rows(j, count);
    // At the poles both rows are the same, and heights between them mean nothing.
    let per_extent = if above == below { 0.0 } else { (to - from).recip() };
    let side = if is_north(j, count) { 1.0 } else { -1.0 };
    [from, to - from, per_extent, side, means[above], means[below], 0.0, 0.0].map(|x| x as f32)
}

/// Whether the versines of strip `j` are those of the angle to the zenith, and not to the nadir.
fn is_north(j: usize, count: usize) -> bool {
    2 * j <= count
}

/// Returns the versines of the angles at which strip `j` begins and ends.
fn versines(j: usize, count: usize) -> [f64; 2] {
    let angle = |j: usize| ((j as f64 - 0.5) / count as f64).clamp(0.0, 1.0) * PI;
    let versine = |angle: f64| 2.0 * (0.5 * angle).sin().powi(2);
    let to_pole = |angle: f64| if is_north(j, count) { angle } else { PI - angle };
    [j, j + 1].map(|j| versine(to_pole(angle(j))))
}
