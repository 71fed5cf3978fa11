//! A node of a light tree: bounds of eight children side by side, whose importance is computed at once.

use super::reach::Reach;
use crate::light::LightSampleContext;
use etendue_lanes::{Float, Native, Vec3};

/// Number of children.
pub(super) const WIDTH: usize = 8;

/// A child that is a light.
pub(super) const LEAF: u32 = 1 << 31;

/// Margin of cosines, above their rounding: bounds are wider by it, so that no light is taken for invisible that is
/// not.
const MARGIN: f32 = 1e-5;

/// Least squared distance, in scene units; it keeps importance finite.
const LEAST_D2: f32 = 1e-30;

/// Bounds of up to eight children.
#[derive(Debug, Clone)]
pub(super) struct Node {
    centre: [[f32; WIDTH]; 3],
    /// Radius around the centre.
    radius: [f32; WIDTH],
    axis: [[f32; WIDTH]; 3],
    /// Cosine and sine of the angle of the cone of normals.
    normals: [[f32; WIDTH]; 2],
    /// Cosine of the angle to a normal up to which light leaves.
    spread: [f32; WIDTH],
    /// −1 where light leaves along both directions of a normal, else 1.
    other_side: [f32; WIDTH],
    /// Inverse square of the radius.
    nearest: [f32; WIDTH],
    /// Relative intensity; 0 without a child.
    intensity: [f32; WIDTH],
    /// Node numbers, or light numbers with [`LEAF`].
    pub(super) children: [u32; WIDTH],
    /// Number of the parent, and the place in it.
    pub(super) parent: (u32, u32),
}

/// Weights of the selection of a child.
pub(super) struct Weights {
    pub(super) of: [f32; WIDTH],
    /// Sums of the first 0 to 8.
    sums: [f64; WIDTH + 1],
}

impl Weights {
    #[inline(always)]
    fn new(of: [f32; WIDTH]) -> Self {
        // Two chains of additions side by side. A child without weight leaves the sum as it is.
        let [mut low, mut high] = [[0.0; WIDTH / 2 + 1]; 2];
        for k in 0..WIDTH / 2 {
            low[k + 1] = low[k] + f64::from(of[k]);
            high[k + 1] = high[k] + f64::from(of[k + WIDTH / 2]);
        }
        let mut sums = [0.0; WIDTH + 1];
        for k in 0..=WIDTH / 2 {
            (sums[k], sums[k + WIDTH / 2]) = (low[k], low[WIDTH / 2] + high[k]);
        }
        Weights { of, sums }
    }

    #[inline(always)]
    pub(super) fn total(&self) -> f64 {
        self.sums[WIDTH]
    }

    /// Returns the child at `target`, from 0 to the total, and the sum of the weights before it.
    #[inline(always)]
    pub(super) fn find(&self, target: f64) -> (usize, f64) {
        // Without branches: children without weight end where they begin.
        let slot = self.sums[1..].iter().map(|&end| usize::from(end <= target)).sum::<usize>();
        if slot < WIDTH { (slot, self.sums[slot]) } else { self.last() }
    }

    /// The last child with a weight, if rounding takes the target to the end.
    #[cold]
    fn last(&self) -> (usize, f64) {
        let slot = self.of.iter().rposition(|&weight| weight > 0.0).unwrap_or(0);
        (slot, self.sums[slot])
    }
}

impl Node {
    /// Returns a node of `children` and their bounds, with intensities in units of `unit`.
    pub(super) fn new(children: &[(u32, Reach)], unit: f64) -> Self {
        let zero = [0.0; WIDTH];
        let mut node = Node {
            centre: [zero; 3],
            radius: zero,
            axis: [zero; 3],
            normals: [zero; 2],
            spread: zero,
            other_side: zero,
            nearest: zero,
            intensity: zero,
            children: [0; WIDTH],
            parent: (0, 0),
        };
        for (slot, (child, reach)) in children.iter().enumerate() {
            let (centre, axis) = (reach.bounds.center(), reach.normals.axis);
            for k in 0..3 {
                (node.centre[k][slot], node.axis[k][slot]) = (centre[k], axis[k] as f32);
            }
            let extent = (reach.bounds.max - centre).max(centre - reach.bounds.min);
            node.radius[slot] = extent.length() * (1.0 + MARGIN);
            let (sin, cos) = reach.normals.angle.sin_cos();
            (node.normals[0][slot], node.normals[1][slot]) = (cos as f32, sin as f32);
            node.spread[slot] = reach.spread.cos() as f32;
            node.other_side[slot] = if reach.two_sided { -1.0 } else { 1.0 };
            node.nearest[slot] = (node.radius[slot] * node.radius[slot]).max(LEAST_D2).recip();
            node.intensity[slot] = (reach.intensity / unit) as f32;
            node.children[slot] = *child;
        }
        node
    }

    /// Returns the node with all numbers of nodes `by` higher.
    pub(super) fn renumbered(mut self, by: u32) -> Self {
        self.children = self.children.map(|child| if child & LEAF == 0 { child + by } else { child });
        self.parent.0 += by;
        self
    }

    /// Returns the children that exist.
    pub(super) fn occupied(&self) -> impl Iterator<Item = u32> {
        self.children.into_iter().zip(self.intensity).filter(|child| child.1 > 0.0).map(|(child, _)| child)
    }

    /// Returns the weights of the children for the receiver `at`: their importance, or their intensity if no light can
    /// arrive from any of them.
    #[inline]
    pub(super) fn weights(&self, at: &LightSampleContext) -> Weights {
        let weights = Weights::new(self.importance(at));
        if weights.total() > 0.0 { weights } else { Weights::new(self.intensity) }
    }

    /// Returns the importance of each child for the receiver `at`: an estimate of the light that it scatters, of its
    /// irradiance if nothing is known of that. It is 0 only where no light can arrive [ContyKulla18 §4.2].
    #[inline]
    pub(super) fn importance(&self, at: &LightSampleContext) -> [f32; WIDTH] {
        let (seen, margin) = (self.seen(at), Lane::splat(MARGIN));
        let near = (seen.inverse * seen.inverse).min(row(&self.nearest));
        let outline = &at.scattering;
        let mut scattered = Lane::splat(outline.diffuse) * seen.arriving.max(margin);
        if outline.glossy > 0.0 {
            scattered = scattered + Lane::splat(outline.glossy) * outline.reflected(seen.wi, seen.sin_seen);
        }
        let importance = row(&self.intensity) * seen.leaving.max(margin) * scattered * near;
        seen.where_lit(importance)
    }

    /// Returns an upper bound of cos (`diffuse` cos_x + `glossy`) / d² for each child, over all its points, where cos is
    /// the cosine to a normal of the child and cos_x that to the receiver `at`.
    #[inline]
    pub(super) fn upper(&self, at: &LightSampleContext, [diffuse, glossy]: [f32; 2]) -> [f32; WIDTH] {
        let seen = self.seen(at);
        let [zero, one, margin] = [0.0, 1.0, MARGIN].map(Lane::splat);
        let [leaving, arriving] = [seen.leaving, seen.arriving].map(|cos| (cos + margin).min(one));
        // The least distance over the distance of the centre. Without one it is 0, and the bound infinite.
        let share = (one - margin - row(&self.radius) * seen.inverse).max(zero);
        let nearest = share / seen.inverse;
        let scattered = Lane::splat(diffuse) * arriving + Lane::splat(glossy);
        seen.where_lit(leaving * scattered / (nearest * nearest))
    }

    /// Returns how the children are seen from the receiver `at`. Cosines are bounded by cos (a − b) ≤ max(cos a, cos a
    /// cos b) + sin b for the angle b under which a child is seen.
    #[inline(always)]
    fn seen(&self, at: &LightSampleContext) -> Seen {
        type F = Lane;
        let rows = |values: &[[f32; WIDTH]; 3]| Vec3::new(row(&values[0]), row(&values[1]), row(&values[2]));
        let all = |v: glam::Vec3| Vec3::new(F::splat(v.x), F::splat(v.y), F::splat(v.z));
        let [zero, one, margin] = [0.0, 1.0, MARGIN].map(F::splat);
        let to = rows(&self.centre) - all(at.p);
        let inverse = to.length_squared().max(F::splat(LEAST_D2)).sqrt().recip();
        let wi = to * inverse;
        let sin_seen = row(&self.radius) * inverse;
        let inside = one.at_most(sin_seen);
        let along = -wi.dot(rows(&self.axis));
        let along = along.max(along * row(&self.other_side));
        let off_normals = less(along, [row(&self.normals[0]), row(&self.normals[1])]);
        // cos b ≥ 1 − sin² b.
        let off_box = off_normals.max(off_normals * (one - sin_seen * sin_seen)) + sin_seen;
        let leaving = F::select(inside, one, off_box.min(one));
        let everywhere = if at.ng == glam::Vec3::ZERO { one } else { zero };
        let (along_normal, [side, other]) = (wi.dot(all(at.ng)), at.sides().map(F::splat));
        let arriving = ((along_normal * side).max(along_normal * other) + sin_seen + everywhere).min(one);
        let lit = leaving.above(row(&self.spread) - margin) & arriving.above(-margin);
        Seen { wi, sin_seen, inverse, leaving, arriving, lit: lit & row(&self.intensity).above(zero) }
    }
}

/// A number for each child.
type Lane = Native;

#[inline(always)]
fn row(values: &[f32; WIDTH]) -> Lane {
    Lane::load(values, 0)
}

/// The children of a node as a receiver sees them.
struct Seen {
    /// Unit directions to their centres.
    wi: Vec3<Lane>,
    /// Sines of the angles under which their radii appear, above 1 inside.
    sin_seen: Lane,
    /// Inverse distances of their centres.
    inverse: Lane,
    /// Upper bounds of the cosines to their normals.
    leaving: Lane,
    /// Upper bounds of the cosines to the receiver's normal.
    arriving: Lane,
    /// Which may reach the receiver.
    lit: <Lane as Float>::Mask,
}

impl Seen {
    /// Returns `values` for children that may reach the receiver, and 0 for others.
    #[inline(always)]
    fn where_lit(&self, values: Lane) -> [f32; WIDTH] {
        // Weak, far and grazing light has a product below the range.
        let values = values.max(Lane::splat(f32::MIN_POSITIVE));
        let mut each = [0.0; WIDTH];
        Lane::select(self.lit, values, Lane::splat(0.0)).store(&mut each, 0);
        each
    }
}

/// Returns the cosine of an angle from 0 to π less that of `cos_b` and `sin_b`, 1 if that is negative.
#[inline(always)]
fn less<F: Float>(cos: F, [cos_b, sin_b]: [F; 2]) -> F {
    let one = F::splat(1.0);
    let sin = (one - cos * cos).max(F::splat(0.0)).sqrt();
    F::select(cos.above(cos_b), one, cos * cos_b + sin * sin_b)
}
