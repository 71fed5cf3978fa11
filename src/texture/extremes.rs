//! Bounds on texture values over a range of coordinates, without a lookup at every point.
//!
//! A bilinear value lies between those of its four texels. The extremes of all texels touched by a range of coordinates
//! therefore bound every lookup in it. An image stores the extremes of its blocks in encoded form; all encodings are
//! monotone.

use super::block_extremes::{BLOCK, Span, Stored, scan, span};
use super::{Bitmap, Texture, TextureFilter, Wrap};
use glam::Vec2;

/// Least and greatest value of each channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extremes {
    /// Least values.
    pub min: [f32; 4],
    /// Greatest values.
    pub max: [f32; 4],
}

impl Extremes {
    /// Extremes of the empty set, the identity of [`Extremes::united`].
    pub const NONE: Extremes = Extremes { min: [f32::INFINITY; 4], max: [f32::NEG_INFINITY; 4] };
    /// Extremes of an absent texture.
    pub const ONE: Extremes = Extremes { min: [1.0; 4], max: [1.0; 4] };

    /// Returns the extremes of the union.
    pub fn united(self, other: Self) -> Self {
        let pairs = |a: [f32; 4], b: [f32; 4], f: fn(f32, f32) -> f32| std::array::from_fn(|i| f(a[i], b[i]));
        Extremes { min: pairs(self.min, other.min, f32::min), max: pairs(self.max, other.max, f32::max) }
    }

    /// Includes one more value.
    pub fn with(self, value: [f32; 4]) -> Self {
        self.united(Extremes { min: value, max: value })
    }

    /// Returns whether each of the `channels` is constant.
    pub fn is_constant(&self, channels: &[usize]) -> bool {
        channels.iter().all(|&c| self.min[c].total_cmp(&self.max[c]).is_eq())
    }
}

/// Adds the extremes of a rectangle: those of complete blocks from the table, those of partial blocks by texel, unless
/// the block cannot extend the result.
fn rectangle(image: &Bitmap, columns: &Span, rows: &Span, found: &mut Stored) {
    let [width, height] = image.size();
    let known = image.blocks();
    let (across, common) =
        ((width as usize).div_ceil(BLOCK), |a: &Span, b: &Span| *a.start().max(b.start())..=*a.end().min(b.end()));
    for by in rows.start() / BLOCK..=rows.end() / BLOCK {
        for bx in columns.start() / BLOCK..=columns.end() / BLOCK {
            let (block, x, y) = (known[by * across + bx], span(bx, width), span(by, height));
            if found.holds(&block) {
                continue;
            }
            let (cut_x, cut_y) = (common(&x, columns), common(&y, rows));
            let whole = cut_x == x && cut_y == y;
            found.take(&if whole { block } else { scan(|x, y| image.stored(x, y), cut_x, cut_y) });
        }
    }
}

impl Texture {
    /// Returns bounds of the linear values of all channels, for coordinates (of the texture's own set) in the box
    /// around `uvs`; [`Extremes::NONE`] without coordinates.
    pub fn extremes(&self, uvs: impl Iterator<Item = Vec2>) -> Extremes {
        let place = |uv| self.transform.transform_point2(uv);
        let (mut low, mut high, mut finite) = (Vec2::INFINITY, Vec2::NEG_INFINITY, true);
        for p in uvs.map(place) {
            finite &= p.is_finite();
            (low, high) = (low.min(p), high.max(p));
        }
        if finite && low.x > high.x {
            return Extremes::NONE;
        }
        let whole = !finite;
        let size = self.image.size();
        let mut found = Stored::NONE;
        let spans = |axis: usize| {
            if whole { vec![0..=size[axis] as usize - 1] } else { self.touched(axis, low[axis], high[axis]) }
        };
        let columns = spans(0);
        for rows in spans(1) {
            columns.iter().for_each(|columns| rectangle(&self.image, columns, &rows, &mut found));
        }
        let linear = |stored| self.image.linear(stored, self.encoding);
        Extremes { min: linear(found.min), max: linear(found.max) }
    }

    /// Returns the texels along `axis` touched by lookups between the coordinates `low` and `high`. Rounding of a
    /// coordinate may select the next texel under nearest filtering. Under bilinear filtering the weight of the next
    /// texel is then no more than the rounding error.
    fn touched(&self, axis: usize, low: f32, high: f32) -> Vec<Span> {
        let side = self.image.size()[axis];
        let [a, b] = [low, high].map(|x| f64::from(x) * f64::from(side));
        let [first, last] = match self.filter {
            TextureFilter::Linear => [(a - 0.5).floor(), (b - 0.5).ceil()],
            TextureFilter::Nearest => {
                // Three products, two sums, the transform and the size: fewer than eight roundings.
                let rounding = 8.0 * f64::from(f32::EPSILON) * a.abs().max(b.abs());
                [(a - rounding).floor(), (b + rounding).floor()]
            }
        };
        self.wrap[axis].spans([first as i64, last as i64], side)
    }
}

impl Wrap {
    /// Returns the texels at the unwrapped positions from `first` to `last`.
    fn spans(self, [first, last]: [i64; 2], side: u32) -> Vec<Span> {
        let n = i64::from(side);
        let span = |a: i64, b: i64| a as usize..=b as usize;
        let whole = vec![span(0, n - 1)];
        match self {
            Wrap::Clamp => vec![span(first.clamp(0, n - 1), last.clamp(0, n - 1))],
            _ if last.saturating_sub(first) >= n - 1 => whole,
            Wrap::Repeat => match [first.rem_euclid(n), last.rem_euclid(n)] {
                [a, b] if a <= b => vec![span(a, b)],
                [a, b] => vec![span(a, n - 1), span(0, b)],
            },
            // Fewer than n positions lie in at most two copies of the image, one mirrored and one not.
            Wrap::Mirror => {
                let at = |i| i64::from(self.index(i, side));
                let seam = (first.div_euclid(n) + 1).saturating_mul(n);
                let ordered = |a: i64, b: i64| span(at(a).min(at(b)), at(a).max(at(b)));
                if last < seam {
                    vec![ordered(first, last)]
                } else {
                    vec![ordered(first, seam - 1), ordered(seam, last)]
                }
            }
        }
    }
}

#[cfg(test)]
#[path = "extremes_tests.rs"]
mod tests;
