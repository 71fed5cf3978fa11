//! Triangles as points see them: points on them that are uniform over the solid angle where they are near [Arvo95], and
//! uniform over the area where they are far or fill nearly a hemisphere.
//!
//! Let a, b, c be the unit directions to the vertices. The solid angle Ω is given by tan(Ω/2) = D / (Y + Z) with
//! D = |det(a, b, c)|, Y = (a + b)·c and Z = 1 + a·b [VanOosterom83]. Let c′ be a point of the side ac, and h = αa + βc
//! half way between a and c′. By the same formula the part s of the angle in the triangle a, b, c′ has
//! tan(s/2) = βD / (αZ + βY). So s determines h without arc cosines: α = D cos(s/2) − Y sin(s/2), β = Z sin(s/2). All
//! points are sums of the vertices with weights that are not negative, so that they lie on the triangle.
//!
//! In f32, the density has a relative error of a few roundings over δ. Here δ is the distance to the plane of the
//! triangle, as in a density by area, or to its outline, in units of the distance to the vertices. Small triangles cancel
//! nothing.

use crate::sampling::lanes::{half_turn, signed_turn, uniform_triangle};
use etendue_lanes::{Float, Mask, Vec3, filled};
use std::f32::consts::PI;

/// Solid angle up to which points are uniform over it. A receiver with a larger one is closer to the plane than a
/// ten-thousandth of the triangle's size, and roundings would change the density by some thousandths.
const MOST: f32 = 6.282;
/// Square of the distance to the nearest vertex, over the area, up to which points are uniform over the solid angle. The
/// relative variance of light samples of random triangles is .13 there and .5 by area; at half the distance .5 and 4.6.
/// Farther away it costs more time than it gains (docs/measurements.md).
const FARTHEST: f32 = 4.0;

/// Triangles, each seen from a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenTriangle<F: Float> {
    /// Density of points that are uniform over the area.
    density: F,
    is_by_angle: F::Mask,
    /// The triangles on the sphere, if any is to be sampled there.
    sphere: Option<SphericalTriangle<F>>,
}

/// Triangles on the unit sphere around a point each.
#[derive(Debug, Clone, Copy)]
struct SphericalTriangle<F: Float> {
    directions: [Vec3<F>; 3],
    distances: [F; 3],
    /// D, Y and Z.
    terms: [F; 3],
    solid_angle: F,
}

impl<F: Float> SeenTriangle<F> {
    /// Returns the triangles of these vertices, unit normals and densities per area, 1 / area, as seen from `p`.
    #[inline(always)]
    pub(super) fn new(vertices: [Vec3<F>; 3], ng: Vec3<F>, density: F, p: Vec3<F>) -> Self {
        let offsets = filled(vertices, |i| vertices[i] - p);
        let squares = filled([density; 3], |i| offsets[i].length_squared());
        let nearest = squares[0].min(squares[1]).min(squares[2]);
        let is_near = (nearest * density).below(F::splat(FARTHEST));
        if !is_near.any() {
            return SeenTriangle { density, is_by_angle: is_near, sphere: None };
        }
        let sphere = SphericalTriangle::new(offsets, squares, ng, density);
        let angle = sphere.solid_angle;
        let is_by_angle = is_near & angle.above(F::splat(0.0)) & angle.at_most(F::splat(MOST));
        SeenTriangle { density, is_by_angle, sphere: Some(sphere) }
    }

    /// Returns where points are uniform over the solid angle.
    #[inline(always)]
    pub(super) fn is_by_angle(&self) -> F::Mask {
        self.is_by_angle
    }

    /// Returns the density per solid angle of points at the squared distance `d2`, seen from them at the cosine `cos`.
    #[inline(always)]
    pub(super) fn pdf(&self, d2: F, cos: F) -> F {
        let by_area = self.density * d2 / cos;
        let pdf =
            self.sphere.map_or(by_area, |sphere| F::select(self.is_by_angle, sphere.solid_angle.recip(), by_area));
        pdf.min(F::splat(f32::MAX))
    }

    /// Samples points; returns the barycentric weights of the second and third vertex.
    #[inline(always)]
    pub(super) fn sample(&self, u: [F; 2]) -> [F; 2] {
        let by_area = uniform_triangle(u);
        let Some(sphere) = &self.sphere else { return by_area };
        let by_angle = sphere.sample(u);
        filled(by_area, |i| F::select(self.is_by_angle, by_angle[i], by_area[i]))
    }
}

impl<F: Float> SphericalTriangle<F> {
    /// Returns the triangles whose vertices have the offsets `offsets`, of squared lengths `squares`.
    #[inline(always)]
    fn new(offsets: [Vec3<F>; 3], squares: [F; 3], ng: Vec3<F>, density: F) -> Self {
        let distances = filled(squares, |i| squares[i].sqrt());
        let directions = filled(offsets, |i| offsets[i] * distances[i].recip());
        let ([a, b, c], [ra, rb, rc]) = (directions, distances);
        let det = F::splat(2.0) / (density * ra * rb) * (offsets[0].dot(ng).abs() / rc);
        let terms = [det, (a + b).dot(c), one_plus_dot(a, b)];
        let solid_angle = F::splat(4.0 * PI) * signed_turn(det, terms[1] + terms[2]);
        SphericalTriangle { directions, distances, terms, solid_angle }
    }

    /// Samples points; returns the barycentric weights of the second and third vertex.
    #[inline(always)]
    fn sample(&self, [u, v]: [F; 2]) -> [F; 2] {
        let ([a, b, c], [ra, rb, rc]) = (self.directions, self.distances);
        let [of_a, of_c] = self.on_side(u);
        let opposite = a * of_a + c * of_c;
        // The point of the arc from b to c′ at the height 1 − cos = v (1 − b·c′) above b, as a sum of both.
        let (one, two, most) = (F::splat(1.0), F::splat(2.0), one_plus_dot(b, -opposite));
        let height = v * most;
        let sines = (v * (two - height) / one_plus_dot(b, opposite).max(F::splat(f32::MIN_POSITIVE))).sqrt();
        let of_b = (one - height - sines * (one - most)).max(F::splat(0.0));
        let [wa, wb, wc] = [sines * of_a / ra, of_b / rb, sines * of_c / rc];
        let sum = wa + wb + wc;
        [wb / sum, wc / sum]
    }

    /// Returns c′ as a sum of a and c: see the module's head.
    #[inline(always)]
    fn on_side(&self, u: F) -> [F; 2] {
        let ([a, _, c], [det, y, z]) = (self.directions, self.terms);
        let (zero, two) = (F::splat(0.0), F::splat(2.0));
        let [cos, sin] = half_turn(self.solid_angle * u * F::splat(0.25 / PI));
        let (alpha, beta) = ((det * cos - y * sin).max(zero), z * sin);
        let difference = (alpha - beta).max(zero);
        let opposed = one_plus_dot(a, c);
        let length2 = (difference * difference + two * alpha * beta * opposed).max(F::splat(f32::MIN_POSITIVE));
        [difference * (alpha + beta) / length2, two * beta * (difference + beta * opposed) / length2]
    }
}

/// Returns 1 + a·b for unit vectors, which does not cancel where they are opposite.
#[inline(always)]
fn one_plus_dot<F: Float>(a: Vec3<F>, b: Vec3<F>) -> F {
    (a + b).length_squared() * F::splat(0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_lanes::{Array, Native};
    use etendue_testing::random::Random;

    fn same<F: Float>() {
        let mut random = Random::new(F::LANES as u64);
        let mut vector = || [0, 1, 2].map(|_| F::from_fn(|_| 2.0 * random.f32() - 1.0));
        for _ in 0..2000 {
            let [a, b, c, ng, p] = [0; 5].map(|_| Vec3::from_array(vector()));
            let [scale, u, v] = vector().map(|x| x.abs());
            // From far to near the first vertex.
            let p = Vec3::select(u.below(v), p, a + p * (scale * scale * scale));
            let seen = SeenTriangle::new([a, b, c], ng, scale, p);
            let (all, pdf) = (seen.sample([u, v]), seen.pdf(u, v));
            for lane in 0..F::LANES {
                let one = |v: Vec3<F>| Vec3::from_array(v.lane(lane));
                let seen = SeenTriangle::<f32>::new([a, b, c].map(one), one(ng), scale.lane(lane), one(p));
                let single = seen.sample([u.lane(lane), v.lane(lane)]);
                assert_eq!(single.map(f32::to_bits), all.map(|x| x.lane(lane).to_bits()));
                assert_eq!(seen.pdf(u.lane(lane), v.lane(lane)).to_bits(), pdf.lane(lane).to_bits());
            }
        }
    }

    #[test]
    fn lanes_have_the_bits_of_single_triangles() {
        same::<Native>();
        same::<Array<4>>();
    }
}
