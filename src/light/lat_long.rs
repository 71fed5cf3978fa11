//! A latitude-longitude environment map with importance sampling.
//!
//! Up is +y. Column u of the map shows the direction of azimuth φ = 2π (½ − u), counted from +x counter-clockwise seen
//! from above (so +x is in the middle and −z a quarter to the left of it). Row v shows the polar angle πv from the
//! zenith. Texel centres are at (i + ½) / width. The lookup is bilinear between them, also across the seam. Above the
//! first and below the last row of centres it is constant in the polar angle.
//!
//! **Density.** The strips between rows of centres, cut at the columns of centres, are cells. Within each cell the
//! density per solid angle is bilinear in azimuth and *height* cos θ, with the lane means of the four corner texels. It
//! equals the lookup except for height in place of angle within a strip: a factor between ⅔ and 2 next to the poles,
//! and within 1 % 100 strips away. It is positive exactly where the lookup is. Its integral over a cell is the solid
//! angle of the cell times the mean of its corners. The inverse has a closed form, monotone in each coordinate, with
//! one random number each. Evaluation uses the same four texels. Nothing divides by the sine at a pole.
//!
//! Limits: random numbers and tables have 24 bits. Cells less likely than 2⁻²⁴ share random numbers with their
//! neighbours.

use super::{EmitterPoint, LightSample};
use crate::huge_vec::HugeVec;
use crate::numeric::BELOW_ONE;
use crate::sampling::{Density, Distribution, Pdf, SolidAngle, warp};
use crate::spectrum::Spectrum;
use crate::texture::RadianceMap;
use glam::Vec3;
use std::f32::consts::{PI, TAU};
use std::f64::consts;
use std::sync::Arc;

/// A map with less than this is dark: the inverse of [`RadianceMap::BRIGHTEST`], so that quotients also stay within
/// f32.
const DARK: f64 = 1e-30;

/// Columns in a block of the two-level search: a cache line of sums.
const BLOCK: usize = 16;

/// Environment light of a [`RadianceMap`].
#[derive(Debug)]
pub struct EnvironmentMap {
    map: Arc<RadianceMap>,
    scale: f32,
    /// Rotation of the map about the up axis, in turns from 0 to 1.
    turn: f32,
    strips: Vec<Row>,
    choice: Distribution,
    /// Mean over each row of texels.
    rows: Vec<f32>,
    /// Inclusive prefix sums over the cells of a row of centres, row by row.
    sums: HugeVec<f32>,
    /// Prefix sums at the ends of blocks of cells.
    blocks: Vec<f32>,
    /// ∫ of the lane mean under height-linear interpolation, before scaling.
    integral: f64,
}

/// Strip between the rows of centres j − 1 and j.
#[derive(Debug)]
struct Row {
    /// Cosines to the zenith at its upper and lower boundary.
    cosines: [f64; 2],
    /// 1 / (sin θ sin Δ/2), with θ the angle of its middle and Δ its width; 0 at the poles, where both rows are the
    /// same.
    slope: f32,
}

/// A cell and a point in it.
struct Lookup {
    /// Texel rows above and below, and columns left and right.
    rows: [usize; 2],
    columns: [usize; 2],
    /// Position from left to right.
    x: f32,
    /// Position from top to bottom, in angle and in height.
    angle: f32,
    height: f32,
}

impl EnvironmentMap {
    /// Creates the light of `map` times `scale` (finite, not negative), rotated by `degrees` about the up axis,
    /// counter-clockwise seen from above; `None` if it is dark.
    pub fn new(map: Arc<RadianceMap>, scale: f32, degrees: f64) -> Option<EnvironmentMap> {
        let [width, height] = map.size();
        let mut sums = Vec::with_capacity(width * height);
        let rows: Vec<f64> = (0..height).map(|y| add_row(&map, y, &mut sums)).collect();
        let strips: Vec<Row> = (0..=height).map(|j| Row::new(j, height)).collect();
        let weight = |(j, strip): (usize, &Row)| {
            let [above, below] = neighbours(j, height);
            let height = strip.cosines[0] - strip.cosines[1];
            consts::PI * height * (rows[above] + rows[below])
        };
        let weights: Vec<f64> = strips.iter().enumerate().map(weight).collect();
        let integral = weights.iter().sum::<f64>();
        if integral < DARK || scale <= 0.0 {
            return None;
        }
        let block_ends = |row: &[f32]| row.chunks(BLOCK).map(|block| block[block.len() - 1]).collect::<Vec<_>>();
        Some(EnvironmentMap {
            choice: Distribution::new(weights)?,
            turn: (degrees / 360.0).rem_euclid(1.0) as f32,
            rows: rows.into_iter().map(|mean| mean as f32).collect(),
            blocks: sums.chunks(width).flat_map(block_ends).collect(),
            map,
            scale,
            strips,
            sums: sums.into(),
            integral,
        })
    }

    /// Returns the radiance from the unit direction `w`, and the density of `w` under [`EnvironmentMap::sample`].
    #[inline]
    pub fn along(&self, w: Vec3) -> (Spectrum, Pdf<SolidAngle>) {
        let place = self.place(w);
        self.blend(&place, self.corners(&place))
    }

    /// Samples a direction with a density close to proportional to the lane mean of the radiance.
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> Option<LightSample> {
        let [width, height] = self.map.size();
        let (strip, rest) = self.choice.sample_within(u[0]);
        let rows = neighbours(strip, height);
        let h = warp::linear(rest, [self.rows[rows[0]], self.rows[rows[1]]]);
        let (column, rest) = self.column(rows, h, u[1]);
        let (wi, angle) = self.polar(strip, h);
        let mut place = Lookup { rows, columns: [column, next(column, width)], x: 0.0, angle, height: h };
        let corners = self.corners(&place);
        let [left, right] = [0, 1].map(|side| mix(corners[0][side].mean(), corners[1][side].mean(), h));
        place.x = warp::linear(rest, [left, right]);
        let (radiance, pdf) = self.blend(&place, corners);
        let (sin, cos) = self.azimuth((column as f32 + 0.5 + place.x) / width as f32).sin_cos();
        let wi = Vec3::new(wi.x * cos, wi.y, -wi.x * sin);
        let sample = LightSample { wi, radiance, density: Density::Smooth(pdf), end: EmitterPoint::Distant };
        (pdf.value() > 0.0 && !radiance.is_black()).then_some(sample)
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
        self.map.bytes() + std::mem::size_of_val(&self.sums[..]) + std::mem::size_of_val(&self.blocks[..])
    }

    /// Returns the map position of `w`.
    #[inline]
    fn place(&self, w: Vec3) -> Lookup {
        let [width, height] = self.map.size();
        let x = (0.5 + self.turn - (-w.z).atan2(w.x) / TAU) * width as f32 - 0.5;
        let left = (x.floor() as i64).rem_euclid(width as i64) as usize;
        let theta = (w.x * w.x + w.z * w.z).sqrt().atan2(w.y);
        let v = theta / PI * height as f32 + 0.5;
        let strip = (v as usize).min(height);
        let angle = v - strip as f32;
        // (cos θ₀ − cos θ) / (cos θ₀ − cos θ₁) as products of sines, since the cosines lose all precision near a pole.
        let half = 0.5 * PI / height as f32 * angle;
        let share = self.strips[strip].slope * (theta - half).sin() * half.sin();
        Lookup {
            rows: neighbours(strip, height),
            columns: [left, next(left, width)],
            x: x - x.floor(),
            angle,
            height: share.clamp(0.0, BELOW_ONE), // below 1, since the angle is
        }
    }

    /// Returns the texels around a position: above and below, left and right.
    #[inline]
    fn corners(&self, place: &Lookup) -> [[Spectrum; 2]; 2] {
        let [left, right] = place.columns;
        let pair = |row: &[[f32; 3]]| [Spectrum::from_rgb(row[left]), Spectrum::from_rgb(row[right])];
        [pair(self.map.row(place.rows[0])), pair(self.map.row(place.rows[1]))]
    }

    /// Interpolates radiance and density at a position among `corners`.
    #[inline]
    fn blend(&self, place: &Lookup, [above, below]: [[Spectrum; 2]; 2]) -> (Spectrum, Pdf<SolidAngle>) {
        let (above, below) = (above[0].lerp(above[1], place.x), below[0].lerp(below[1], place.x));
        let density = mix(above.mean(), below.mean(), place.height) / self.integral as f32;
        (above.lerp(below, place.angle) * self.scale, Pdf::new(density))
    }

    /// Returns the cell at `u` in the row at height `h` between two rows of centres, and the position of `u` in it.
    #[inline]
    fn column(&self, [above, below]: [usize; 2], h: f32, u: f32) -> (usize, f32) {
        let width = self.map.size()[0];
        let rows = [&self.sums[above * width..][..width], &self.sums[below * width..][..width]];
        let sum = |i: usize| mix(rows[0][i], rows[1][i], h);
        let count = width.div_ceil(BLOCK);
        let blocks = [&self.blocks[above * count..][..count], &self.blocks[below * count..][..count]];
        let target = u * sum(width - 1);
        let first = BLOCK * first_above(target, blocks, h);
        let block = first..width.min(first + BLOCK);
        let cell = first + first_above(target, rows.map(|row| &row[block.clone()]), h);
        let start = if cell == 0 { 0.0 } else { sum(cell - 1) };
        (cell, warp::into_unit((target - start) / (sum(cell) - start)))
    }

    /// Returns the direction of azimuth 0 in `strip` at the height fraction `h` from the top, and the fraction in
    /// angle.
    #[inline]
    fn polar(&self, strip: usize, h: f32) -> (Vec3, f32) {
        let [top, bottom] = self.strips[strip].cosines;
        let cos = top + (bottom - top) * f64::from(h);
        let (sin, cos) = (((1.0 - cos) * (1.0 + cos)).sqrt() as f32, cos as f32);
        let v = sin.atan2(cos) / PI * self.map.size()[1] as f32 + 0.5;
        (Vec3::new(sin, cos, 0.0), (v - strip as f32).clamp(0.0, 1.0))
    }

    /// Returns the azimuth of column `u`.
    #[inline]
    fn azimuth(&self, u: f32) -> f32 {
        let turns = 0.5 + self.turn - u;
        (turns - turns.round()) * TAU
    }
}

impl Row {
    fn new(j: usize, height: usize) -> Self {
        let edge = |j: usize| ((j as f64 - 0.5) / height as f64).clamp(0.0, 1.0) * consts::PI;
        let half = consts::FRAC_PI_2 / height as f64;
        let at_pole = j == 0 || j == height;
        let slope = if at_pole { 0.0 } else { ((2.0 * half * j as f64).sin() * half.sin()).recip() };
        Row { cosines: [edge(j).cos(), edge(j + 1).cos()], slope: slope as f32 }
    }
}

/// Appends the prefix sums of a row and returns its mean. The share of a cell is the mean of its two ends; the last
/// cell lies across the seam.
fn add_row(map: &RadianceMap, y: usize, sums: &mut Vec<f32>) -> f64 {
    let row = map.row(y);
    let mean = |x: usize| row[x].iter().map(|&lane| f64::from(lane)).sum::<f64>() / row[x].len() as f64;
    let mut sum = 0.0;
    for x in 0..row.len() {
        sum += 0.5 * (mean(x) + mean(next(x, row.len())));
        sums.push(sum as f32);
    }
    sum / row.len() as f64
}

/// Returns the first index at which the interpolation of two increasing rows exceeds `target`, or the last index. A
/// linear count, not bisection: it compares eight values at once, without dependent memory accesses.
#[inline]
fn first_above(target: f32, [above, below]: [&[f32]; 2], h: f32) -> usize {
    let passed: u32 = above.iter().zip(below).map(|(&a, &b)| u32::from(mix(a, b, h) <= target)).sum();
    (passed as usize).min(above.len() - 1)
}

/// Returns the rows of centres above and below strip `j`.
#[inline]
fn neighbours(j: usize, height: usize) -> [usize; 2] {
    [j.saturating_sub(1), j.min(height - 1)]
}

/// Returns the column after `x`, with wrap-around at the seam.
#[inline]
fn next(x: usize, width: usize) -> usize {
    if x + 1 == width { 0 } else { x + 1 }
}

#[inline]
fn mix(a: f32, b: f32, t: f32) -> f32 {
    a * (1.0 - t) + b * t
}
