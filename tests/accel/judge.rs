//! What a ray meets, decided exactly: signs of edge functions and the order of distances in integers.
//!
//! An f32 is an integer times 2⁻¹⁴⁹, a coordinate of a placed vertex an integer times 2⁻²⁹⁸; so every determinant of
//! them is an integer, and nothing is rounded. A triangle is closed: a ray through its edge or vertex meets it. One
//! without area, or whose plane holds the ray, is met by none. Parameters count from `t_min` to `t_max`, both included.
//!
//! Most triangles are ruled out in f64 first, with the error bound that stands at [`Filtered`].

use super::exact::{Integers, difference, triple, units};
use etendue::geometry::{Geometry, Hit, Ray};
use glam::DVec3;
use num_bigint::{BigInt, Sign};
use std::cmp::Ordering;

/// One rounding in f64.
const ROUNDING: f64 = f64::EPSILON * 0.5;

struct Placed {
    hit: Hit,
    /// As f64 has them, each coordinate within `error`.
    vertices: [DVec3; 3],
    error: f64,
}

/// All triangles of a geometry, ready to be judged.
pub(crate) struct Judge<'a> {
    geometry: &'a Geometry,
    triangles: Vec<Placed>,
}

/// A hit and its exact parameter, `over` / `under`, with `under` > 0.
struct Met {
    hit: Hit,
    over: BigInt,
    under: BigInt,
}

/// What f64 can say of a ray's line and a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Filtered {
    Outside,
    Unsure,
}

impl<'a> Judge<'a> {
    pub(crate) fn new(geometry: &'a Geometry) -> Self {
        let mut triangles = Vec::new();
        for (object, placed) in (0..).zip(&geometry.objects) {
            let mesh = geometry.mesh_of(object);
            // Those with a repeated corner have no area: nothing meets them, and f64 would never be sure.
            let distinct = |&(_, &[a, b, c]): &(u32, &[u32; 3])| a != b && b != c && c != a;
            for (primitive, corners) in (0..).zip(mesh.triangles()).filter(distinct) {
                let corners = corners.map(|i| mesh.positions()[i as usize].as_dvec3());
                let (vertices, error) = match &placed.placement {
                    None => (corners, 0.0),
                    Some(m) => {
                        let m = m.as_daffine3();
                        let terms = |p: DVec3| {
                            let x = m.matrix3.x_axis.abs() * p.x.abs() + m.matrix3.y_axis.abs() * p.y.abs();
                            (x + m.matrix3.z_axis.abs() * p.z.abs() + m.translation.abs()).max_element()
                        };
                        // Products of f32 are exact in f64; their sum rounds three times, at most its terms each.
                        let error = corners.iter().map(|&p| terms(p)).fold(0.0, f64::max) * 4.0 * ROUNDING;
                        (corners.map(|p| m.transform_point3(p)), error)
                    }
                };
                triangles.push(Placed { hit: Hit { object, primitive }, vertices, error });
            }
        }
        Judge { geometry, triangles }
    }

    /// All nearest hits of `ray`, those at exactly the same distance; none for a ray that is not finite.
    pub(crate) fn nearest(&self, ray: &Ray) -> Vec<Hit> {
        if !(ray.origin.is_finite() && ray.direction.is_finite()) || ray.t_min.is_nan() || ray.t_max.is_nan() {
            return Vec::new();
        }
        let mut nearest: Vec<Met> = Vec::new();
        for placed in self.triangles.iter().filter(|placed| placed.filter(ray) == Filtered::Unsure) {
            let Some(met) = meet(&Integers::of(self.geometry, placed.hit, ray), placed.hit, ray) else { continue };
            match nearest.first().map_or(Ordering::Less, |held| order(&met, held)) {
                Ordering::Less => nearest = vec![met],
                Ordering::Equal => nearest.push(met),
                Ordering::Greater => {}
            }
        }
        nearest.into_iter().map(|met| met.hit).collect()
    }
}

impl Placed {
    /// Whether the line of the ray certainly passes the triangle.
    ///
    /// With D, B, C the largest components of d and of two vertices seen from the origin, and e their error, a triple
    /// product is a sum of 6 products. Its entries are off by e, which moves it by at most 6 D (e C + B e + e²); at
    /// most 5 roundings of each product and partial sum move it by 5 · 6 u D B C and terms of second order. 8 in place
    /// of 5 covers these and the bound's own rounding. Nothing underflows: f32 has no number between 0 and 2⁻¹⁴⁹, and
    /// 2⁻⁴⁴⁷ is normal in f64.
    fn filter(&self, ray: &Ray) -> Filtered {
        let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let [a, b, c] = self.vertices.map(|v| v - o);
        let size = |v: DVec3| v.abs().max_element();
        let most = size(a).max(size(b)).max(size(c));
        let error = self.error + 2.0 * ROUNDING * most;
        let bound = 6.0 * size(d) * (error * (2.0 * most + error) + 8.0 * ROUNDING * most * most) * (1.0 + 1e-9);
        let edges = [d.dot(b.cross(c)), d.dot(c.cross(a)), d.dot(a.cross(b))];
        let (above, below) = (edges.iter().any(|&x| x > bound), edges.iter().any(|&x| x < -bound));
        if above && below { Filtered::Outside } else { Filtered::Unsure }
    }
}

/// The exact hit, if there is one.
fn meet(integers: &Integers, hit: Hit, ray: &Ray) -> Option<Met> {
    let Integers { vertices: [a, b, c], direction, extra } = integers;
    let edges = [triple(direction, b, c), triple(direction, c, a), triple(direction, a, b)];
    let has = |sign: Sign| edges.iter().any(|x| x.sign() == sign);
    if has(Sign::Plus) && has(Sign::Minus) {
        return None;
    }
    // n·d is the sum of the edge functions, n·a the triple product of the vertices.
    let under: BigInt = edges.iter().sum::<BigInt>() << *extra;
    let over = triple(a, b, c);
    let (over, under) = match under.sign() {
        Sign::NoSign => return None,
        Sign::Minus => (-over, -under),
        Sign::Plus => (over, under),
    };
    let met = Met { hit, over, under };
    (against(&met, ray.t_min) != Ordering::Less && against(&met, ray.t_max) != Ordering::Greater).then_some(met)
}

/// How the parameter of a hit compares with `t`.
fn against(met: &Met, t: f32) -> Ordering {
    if t.is_infinite() {
        return if t > 0.0 { Ordering::Less } else { Ordering::Greater };
    }
    (&met.over << 149usize).cmp(&(units(t) * &met.under))
}

fn order(a: &Met, b: &Met) -> Ordering {
    (&a.over * &b.under).cmp(&(&b.over * &a.under))
}

/// Whether the exact line meets what `hit` names, whatever lies before it: for messages.
pub(crate) fn is_met(geometry: &Geometry, ray: &Ray, hit: Hit) -> bool {
    meet(&Integers::of(geometry, hit, ray), hit, ray).is_some()
}

#[test]
fn differences_of_numbers_far_apart_are_exact() {
    let [big, small] = [1e30f32, 1e-30].map(units);
    let [from, to] = [[big.clone(), small.clone(), BigInt::ZERO], [BigInt::ZERO, big.clone(), small.clone()]];
    assert_eq!(difference(&from, &to), [big.clone(), &small - &big, -small]);
}
