//! A latitude-longitude map as a light, importance sampled.
//!
//! Up is +y. Column u of the map shows the direction of azimuth φ = 2π (½ − u), counted from +x counter-clockwise seen from
//! above (so +x is in the middle and −z a quarter to the left of it), row v that of the angle πv from the zenith. Texel centres
//! are at (i + ½) / width; between them the lookup is bilinear, across the seam, and above the first and below the last row of
//! centres it keeps that row's value.
//!
//! **Density.** The strips between rows of centres, cut at the columns of centres, are cells; in each the density per solid angle
//! is bilinear, in the azimuth and in the *height* cos θ, with the means over the lanes of the four texels at its corners. So it is
//! the lookup itself but for height in place of angle, within a strip: a factor between ⅔ and 2 next to the poles, 1 % away from it
//! 100 strips on. It is positive exactly where the lookup is, its integral over a cell is the cell's solid angle times the
//! mean of its corners, it is inverted in closed form, one number for each coordinate and both monotone, and to evaluate it
//! needs the same four texels. Nothing divides by the sine at a pole.
//!
//! Limits: numbers have 24 bits, as have the tables; cells rarer than 2⁻²⁴ share numbers with their neighbours.

use super::{End, LightSample};
use crate::defects::{Defect, planted};
use crate::numeric::BELOW_ONE;
use crate::pages::Pages;
use crate::sampling::{Density, Distribution, Pdf, SolidAngle, warp};
use crate::spectrum::Spectrum;
use crate::texture::RadianceMap;
use glam::Vec3;
use std::f32::consts::{PI, TAU};
use std::f64::consts;
use std::sync::Arc;

/// A map with less than this is dark: the inverse of [`RadianceMap::BRIGHTEST`], so that shares of it stay inside f32, too.
const DARK: f64 = 1e-30;

/// Columns in a block of the two-level search: a cache line of sums.
const BLOCK: usize = 16;

/// The light of a [`RadianceMap`].
#[derive(Debug)]
pub struct LatLong {
    map: Arc<RadianceMap>,
    scale: f32,
    /// How far the map is turned about the up axis, in turns from 0 to 1.
    turn: f32,
    strips: Vec<Strip>,
    choice: Distribution,
    /// Mean over each row of texels.
    rows: Vec<f32>,
    /// Sums over the cells of a row of centres up to and with each, row by row.
    sums: Pages<f32>,
    /// Those of them that end a block of cells.
    blocks: Vec<f32>,
    /// ∫ of the mean over the lanes, by the height-linear interpolation, before scaling.
    integral: f64,
}

/// What lies between the rows of centres j − 1 and j.
#[derive(Debug)]
struct Strip {
    /// Cosine to the zenith where it begins and where it ends.
    cosines: [f64; 2],
    /// 1 / (sin θ sin Δ/2), with the angle θ of its middle and its width Δ; 0 at the poles, where the rows are the same.
    slope: f32,
}

/// A cell, and a point in it.
struct Place {
    /// The texel rows above and below, and the columns left and right.
    rows: [usize; 2],
    columns: [usize; 2],
    /// From left to right.
    x: f32,
    /// From above to below, in the angle and in the height.
    angle: f32,
    height: f32,
}

impl LatLong {
    /// The light of `map` times `scale` (finite, not negative), turned by `degrees` about the up axis, counter-clockwise
    /// seen from above; `None` if it is dark.
    pub fn new(map: Arc<RadianceMap>, scale: f32, degrees: f64) -> Option<LatLong> {
        let [width, height] = map.size();
        let mut sums = Vec::with_capacity(width * height);
        let rows: Vec<f64> = (0..height).map(|y| add_row(&map, y, &mut sums)).collect();
        let strips: Vec<Strip> = (0..=height).map(|j| Strip::new(j, height)).collect();
        let weight = |(j, strip): (usize, &Strip)| {
            let [above, below] = neighbours(j, height);
            let height =
                if planted(Defect::MapRowsAlike) { 2.0 / strips.len() as f64 } else { strip.cosines[0] - strip.cosines[1] };
            consts::PI * height * (rows[above] + rows[below])
        };
        let weights: Vec<f64> = strips.iter().enumerate().map(weight).collect();
        let integral = weights.iter().sum::<f64>();
        if integral < DARK || scale <= 0.0 {
            return None;
        }
        let block_ends = |row: &[f32]| row.chunks(BLOCK).map(|block| block[block.len() - 1]).collect::<Vec<_>>();
        Some(LatLong {
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

    /// The radiance that arrives against the unit direction `w`, and the density of `w` in [`LatLong::sample`].
    #[inline]
    pub fn along(&self, w: Vec3) -> (Spectrum, Pdf<SolidAngle>) {
        let place = self.place(w);
        self.blend(&place, self.corners(&place))
    }

    /// A direction with a density close to proportional to its radiance's mean over the lanes.
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> Option<LightSample> {
        let [width, height] = self.map.size();
        let (strip, rest) = self.choice.sample_within(u[0]);
        let rows = neighbours(strip, height);
        let h = warp::linear(rest, [self.rows[rows[0]], self.rows[rows[1]]]);
        let (column, rest) = self.column(rows, h, u[1]);
        let (wi, angle) = self.polar(strip, h);
        let mut place = Place { rows, columns: [column, next(column, width)], x: 0.0, angle, height: h };
        let corners = self.corners(&place);
        let [left, right] = [0, 1].map(|side| mix(corners[0][side].mean(), corners[1][side].mean(), h));
        place.x = warp::linear(rest, [left, right]);
        let (radiance, pdf) = self.blend(&place, corners);
        let (sin, cos) = self.azimuth((column as f32 + 0.5 + place.x) / width as f32).sin_cos();
        let wi = Vec3::new(wi.x * cos, wi.y, -wi.x * sin);
        let sample = LightSample { wi, radiance, density: Density::Smooth(pdf), end: End::Infinity };
        (pdf.value() > 0.0 && !radiance.is_black()).then_some(sample)
    }

    /// What enters a sphere of `radius`: ∫ L dω through its cross-section.
    pub fn power(&self, radius: f32) -> f64 {
        consts::PI * f64::from(radius).powi(2) * f64::from(self.scale) * self.integral
    }

    /// That of the brightest texel, mean over the lanes.
    pub(super) fn largest_radiance(&self) -> f64 {
        let means = (0..self.map.size()[1]).flat_map(|y| self.map.row(y)).map(|&texel| Spectrum::from_rgb(texel).mean());
        f64::from(self.scale) * f64::from(means.fold(0.0, f32::max))
    }

    /// Bytes held, the map's with them.
    pub fn bytes(&self) -> usize {
        self.map.bytes() + std::mem::size_of_val(&self.sums[..]) + std::mem::size_of_val(&self.blocks[..])
    }

    /// Where the map shows `w`.
    #[inline]
    fn place(&self, w: Vec3) -> Place {
        let [width, height] = self.map.size();
        let half = if planted(Defect::MapHalfTexel) { 0.0 } else { 0.5 };
        let x = (0.5 + self.turn - (-w.z).atan2(w.x) / TAU) * width as f32 - half;
        let left = (x.floor() as i64).rem_euclid(width as i64) as usize;
        let theta = (w.x * w.x + w.z * w.z).sqrt().atan2(w.y);
        let v = theta / PI * height as f32 + 0.5;
        let strip = (v as usize).min(height);
        let angle = v - strip as f32;
        // (cos θ₀ − cos θ) / (cos θ₀ − cos θ₁) as products of sines, since near a pole the cosines say nothing.
        let half = 0.5 * PI / height as f32 * angle;
        let share = self.strips[strip].slope * (theta - half).sin() * half.sin();
        Place {
            rows: neighbours(strip, height),
            columns: [left, next(left, width)],
            x: x - x.floor(),
            angle,
            height: share.clamp(0.0, BELOW_ONE), // below 1, since the angle is
        }
    }

    /// The texels around a place, above and below, left and right.
    #[inline]
    fn corners(&self, place: &Place) -> [[Spectrum; 2]; 2] {
        let [left, right] = place.columns;
        let pair = |row: &[[f32; 3]]| [Spectrum::from_rgb(row[left]), Spectrum::from_rgb(row[right])];
        [pair(self.map.row(place.rows[0])), pair(self.map.row(place.rows[1]))]
    }

    /// Radiance and density at a place among `corners`.
    #[inline]
    fn blend(&self, place: &Place, [above, below]: [[Spectrum; 2]; 2]) -> (Spectrum, Pdf<SolidAngle>) {
        let (above, below) = (above[0].lerp(above[1], place.x), below[0].lerp(below[1], place.x));
        let density = mix(above.mean(), below.mean(), place.height) / self.integral as f32;
        (above.lerp(below, place.angle) * self.scale, Pdf::new(density))
    }

    /// The cell at `u` of the row in height `h` between two rows of centres, and where in it `u` lies.
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

    /// The direction of azimuth 0 in `strip` at height `h` of the way down, and how far down that is in the angle.
    #[inline]
    fn polar(&self, strip: usize, h: f32) -> (Vec3, f32) {
        let [top, bottom] = self.strips[strip].cosines;
        let cos = top + (bottom - top) * f64::from(h);
        let (sin, cos) = (((1.0 - cos) * (1.0 + cos)).sqrt() as f32, cos as f32);
        let v = sin.atan2(cos) / PI * self.map.size()[1] as f32 + 0.5;
        (Vec3::new(sin, cos, 0.0), (v - strip as f32).clamp(0.0, 1.0))
    }

    /// The azimuth that column `u` shows.
    #[inline]
    fn azimuth(&self, u: f32) -> f32 {
        let turns = 0.5 + if planted(Defect::MapTurnsBack) { -self.turn } else { self.turn } - u;
        (turns - turns.round()) * TAU
    }
}

impl Strip {
    fn new(j: usize, height: usize) -> Self {
        let edge = |j: usize| ((j as f64 - 0.5) / height as f64).clamp(0.0, 1.0) * consts::PI;
        let half = consts::FRAC_PI_2 / height as f64;
        let at_pole = j == 0 || j == height;
        let slope = if at_pole { 0.0 } else { ((2.0 * half * j as f64).sin() * half.sin()).recip() };
        Strip { cosines: [edge(j).cos(), edge(j + 1).cos()], slope: slope as f32 }
    }
}

/// Adds a row's sums; its mean. A cell's share is the mean of its two ends, the last one lies across the seam.
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

/// Where the mix of two growing rows, which grows, first exceeds `target`, or the last place. Counted and not bisected: eight are
/// compared at once, and no step waits for the memory of the one before.
#[inline]
fn first_above(target: f32, [above, below]: [&[f32]; 2], h: f32) -> usize {
    let passed: u32 = above.iter().zip(below).map(|(&a, &b)| u32::from(mix(a, b, h) <= target)).sum();
    (passed as usize).min(above.len() - 1)
}

/// The rows of centres above and below strip `j`.
#[inline]
fn neighbours(j: usize, height: usize) -> [usize; 2] {
    [j.saturating_sub(1), j.min(height - 1)]
}

/// The column after `x`, round the seam.
#[inline]
fn next(x: usize, width: usize) -> usize {
    let first = if planted(Defect::MapSeam) { x } else { 0 };
    if x + 1 == width { first } else { x + 1 }
}

#[inline]
fn mix(a: f32, b: f32, t: f32) -> f32 {
    a * (1.0 - t) + b * t
}
