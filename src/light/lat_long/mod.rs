//! A latitude-longitude environment map with importance sampling.
//!
//! Up is +y. Column u of the map shows the direction of azimuth φ = 2π (½ − u), counted from +x counter-clockwise seen
//! from above (so +x is in the middle and −z a quarter to the left of it). Row v shows the polar angle πv from the
//! zenith. Texel centres are at (i + ½) / width. The lookup is bilinear between them, also across the seam. Above the
//! first and below the last row of centres it is constant in the polar angle.
//!
//! **Density.** The strips between rows of centres, cut at the columns of centres, are cells. Within each cell the
//! density per solid angle is bilinear in azimuth and *height* cos θ between the shares of the four corner texels. The
//! share of a texel is its lane mean after MIS compensation (`compensation`). But for that the density equals the
//! lookup with height in place of angle within a strip: a factor between ⅔ and 2 next to the poles, and within 1 % 100
//! strips away. It is positive exactly where the lookup is. Its integral over a cell is the solid angle of the cell
//! times the mean of its corners. The inverse has a closed form, monotone in each coordinate, with one random number
//! each. Evaluation uses the same four texels. Nothing divides by the sine at a pole.
//!
//! Lookup and sampling are kernels over lanes: lanes search and fetch one stage after the other, so that their cache
//! misses overlap. The functions for one direction are the kernels at one lane.
//!
//! Limits: random numbers and tables have 24 bits. Cells less likely than 2⁻²⁴ share random numbers with their
//! neighbours.

mod columns;
mod compensation;
mod strips;

use super::{EmitterPoint, EnvironmentSamples, LightSample};
use crate::numeric::next_down;
use crate::sampling::lanes::{circle, linear, signed_turn};
use crate::sampling::{Density, Pdf, SolidAngle};
use crate::spectrum::Spectrum;
use crate::texture::RadianceMap;
use columns::Columns;
use compensation::Compensation;
use etendue_lanes::{Float, Int, MOST_LANES, ROW, Vec3};
use std::f64::consts;
use std::sync::Arc;
use strips::Strips;

/// A map with less than this is dark: the inverse of [`RadianceMap::BRIGHTEST`], so that quotients also stay within
/// f32.
const DARK: f64 = 1e-30;

/// Environment light of a [`RadianceMap`].
#[derive(Debug)]
pub struct EnvironmentMap {
    map: Arc<RadianceMap>,
    scale: f32,
    /// Rotation of the map about the up axis, in turns from 0 to 1.
    turn: f32,
    strips: Strips,
    columns: Columns,
    compensation: Compensation,
    /// ∫ of the lane mean under height-linear interpolation, before scaling.
    integral: f64,
    /// The same of the texels' shares of the density.
    shares: f32,
}

/// Cells, and points in them.
struct Lookup<F: Float> {
    strip: F::Int,
    /// Column of texels on the left.
    column: F::Int,
    /// Position from left to right.
    x: F,
    /// Position from top to bottom, in angle and in height.
    angle: F,
    height: F,
}

impl EnvironmentMap {
    /// Creates the light of `map` times `scale` (finite, not negative), rotated by `degrees` about the up axis,
    /// counter-clockwise seen from above; `None` if it is dark.
    pub fn new(map: Arc<RadianceMap>, scale: f32, degrees: f64) -> Option<EnvironmentMap> {
        let integral = strips::integrals(&row_means(&map)).iter().sum();
        if integral < DARK || scale <= 0.0 {
            return None;
        }
        let compensation = Compensation::new(integral / (4.0 * consts::PI));
        let (columns, means) = Columns::new(&map, |texel| f64::from(compensation.of(mean(Spectrum(texel)))));
        let (strips, shares) = Strips::new(&means);
        let turn = (degrees / 360.0).rem_euclid(1.0) as f32;
        Some(EnvironmentMap {
            map,
            scale,
            turn,
            strips: strips?,
            columns,
            compensation,
            integral,
            shares: shares as f32,
        })
    }

    /// Returns the radiance from the unit direction `w`, and the density of `w` under [`EnvironmentMap::sample`].
    #[inline]
    pub fn along(&self, w: glam::Vec3) -> (Spectrum, Pdf<SolidAngle>) {
        let (radiance, pdf) = self.along_lanes::<f32>(w.into());
        (radiance, Pdf::new(pdf))
    }

    /// Does [`EnvironmentMap::along`] in every lane.
    #[inline]
    pub fn along_lanes<F: Float>(&self, w: Vec3<F>) -> (Spectrum<F>, F) {
        let place = self.place(w);
        self.blend(&place, self.corners(&place))
    }

    /// Samples a direction, by the parts of the map that stand out from its mean.
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> Option<LightSample> {
        let EnvironmentSamples { wi, radiance, pdf, valid } = self.sample_lanes::<f32>(u);
        let density = Density::Smooth(Pdf::new(pdf));
        valid.then_some(LightSample { wi: wi.into(), radiance, density, end: EmitterPoint::Distant })
    }

    /// Does [`EnvironmentMap::sample`] in every lane.
    #[inline]
    pub fn sample_lanes<F: Float>(&self, u: [F; 2]) -> EnvironmentSamples<F> {
        let strips::Height { strip, height, sin, cos, angle } = self.strips.sample(u[0]);
        let (column, rest) = self.columns.sample(strip, height, u[1]);
        self.fetch::<F>(strip, column);
        let mut place = Lookup { strip, column, x: rest, angle, height };
        let corners = self.corners(&place);
        let [above, below] = corners.map(|row| self.shares_of(row));
        let side = |k: usize| mix(above[k], below[k], height);
        place.x = linear(rest, [side(0), side(1)]);
        let (radiance, pdf) = self.blend(&place, corners);
        let position = (F::from_int(column) + F::splat(0.5) + place.x) / F::splat(self.width());
        let [x, z] = circle(within_turn(F::splat(0.5 + self.turn) - position));
        let valid = pdf.above(F::splat(0.0)) & radiance.is_lit();
        EnvironmentSamples { wi: Vec3::new(sin * x, cos, -(sin * z)), radiance, pdf, valid }
    }

    /// Returns the power into a sphere of `radius`: ∫ L dω times its cross-section.
    pub fn power(&self, radius: f32) -> f64 {
        consts::PI * f64::from(radius).powi(2) * f64::from(self.scale) * self.integral
    }

    /// Returns the radiance of the brightest texel, mean over lanes.
    pub(super) fn largest_radiance(&self) -> f64 {
        let means =
            (0..self.map.size()[1]).flat_map(|y| self.map.row(y)).map(|&texel| Spectrum::from_rgb(texel).mean());
        f64::from(self.scale) * f64::from(means.fold(0.0, f32::max))
    }

    /// Returns the memory held, including the map, in bytes.
    pub fn bytes(&self) -> usize {
        self.map.bytes() + self.strips.bytes() + self.columns.bytes()
    }

    /// Returns the number of columns.
    #[inline(always)]
    fn width(&self) -> f32 {
        self.map.size()[0] as f32
    }

    /// Returns the map positions of `w`.
    #[inline(always)]
    fn place<F: Float>(&self, w: Vec3<F>) -> Lookup<F> {
        let turn = F::splat(0.5 + self.turn) - signed_turn(-w.z, w.x);
        let width = F::splat(self.width());
        let x = within_turn(turn) * width - F::splat(0.5);
        // Rounding may lead to the width itself.
        let x = F::select(x.below(F::splat(0.0)), x + width, x).min(F::splat(next_down(self.width())));
        let column = x.to_int();
        let (strip, angle, height) = self.strips.place(w);
        Lookup { strip, column, x: x - F::from_int(column), angle, height }
    }

    /// Asks for the texels of cells.
    #[inline(always)]
    fn fetch<F: Float>(&self, strip: F::Int, column: F::Int) {
        for lane in 0..F::LANES {
            for row in self.rows(strip.lane(lane)) {
                etendue_lanes::prefetch(&row[column.lane(lane) as usize]);
            }
        }
    }

    /// Returns the texels of the rows above and below a strip.
    #[inline(always)]
    fn rows(&self, strip: u32) -> [&[[f32; 3]]; 2] {
        strips::rows(strip as usize, self.map.size()[1]).map(|y| self.map.row(y))
    }

    /// Returns the texels around positions: above and below, left and right.
    #[inline(always)]
    fn corners<F: Float>(&self, place: &Lookup<F>) -> [[Spectrum<F>; 2]; 2] {
        let mut texels = [[[0.0; ROW]; MOST_LANES]; 2];
        for lane in 0..F::LANES {
            let left = place.column.lane(lane) as usize;
            let right = next(left, self.map.size()[0]);
            for (row, texels) in self.rows(place.strip.lane(lane)).into_iter().zip(&mut texels) {
                let ([a, b, c], [d, e, f]) = (row[left], row[right]);
                texels[lane] = [a, b, c, d, e, f, 0.0, 0.0];
            }
        }
        let pair = |texels: &[[f32; ROW]; MOST_LANES]| {
            let [a, b, c, d, e, f, ..] = F::rows(|lane| &texels[lane]);
            [Spectrum([a, b, c]), Spectrum([d, e, f])]
        };
        [pair(&texels[0]), pair(&texels[1])]
    }

    /// Interpolates radiance and density at positions among `corners`.
    #[inline(always)]
    fn blend<F: Float>(&self, place: &Lookup<F>, [above, below]: [[Spectrum<F>; 2]; 2]) -> (Spectrum<F>, F) {
        let between = |a: Spectrum<F>, b: Spectrum<F>, t: F| a.zip(b, |a, b| mix(a, b, t));
        let [share_above, share_below] = [above, below].map(|row| {
            let [left, right] = self.shares_of(row);
            mix(left, right, place.x)
        });
        let (above, below) = (between(above[0], above[1], place.x), between(below[0], below[1], place.x));
        let density = mix(share_above, share_below, place.height) / F::splat(self.shares);
        (between(above, below, place.angle) * F::splat(self.scale), density)
    }

    /// Returns the shares of two texels in the density, before it is normalised.
    #[inline(always)]
    fn shares_of<F: Float>(&self, texels: [Spectrum<F>; 2]) -> [F; 2] {
        texels.map(|texel| self.compensation.of(mean(texel)))
    }
}

/// Returns the mean over lanes and columns of each row.
fn row_means(map: &RadianceMap) -> Vec<f64> {
    let texel = |texel: &[f32; 3]| texel.iter().map(|&lane| f64::from(lane)).sum::<f64>() / texel.len() as f64;
    let row = |y: usize| map.row(y).iter().map(texel).sum::<f64>() / map.size()[0] as f64;
    (0..map.size()[1]).map(row).collect()
}

/// Reduces turns from −1 to 2, exclusive, to those from 0 to 1.
#[inline(always)]
fn within_turn<F: Float>(turn: F) -> F {
    let one = F::splat(1.0);
    let turn = F::select(turn.below(F::splat(0.0)), turn + one, turn);
    F::select(turn.below(one), turn, turn - one)
}

/// Returns the column after `x`, with wrap-around at the seam.
#[inline]
fn next(x: usize, width: usize) -> usize {
    if x + 1 == width { 0 } else { x + 1 }
}

#[inline(always)]
fn mean<F: Float>(Spectrum([a, b, c]): Spectrum<F>) -> F {
    (a + b + c) / F::splat(3.0)
}

#[inline(always)]
fn mix<F: Float>(a: F, b: F, t: F) -> F {
    a * (F::splat(1.0) - t) + b * t
}
