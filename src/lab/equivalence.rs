//! Equivalence of two answers to one ray: equal, equal within rounding, or different.
//!
//! Backends use f32 and different orders of operations. With u = 2⁻²⁴ and L the distance from the ray's origin to a
//! triangle's farthest vertex, a backend that moves vertices to the ray's origin and shears them has an error of at
//! most 8 u L across the ray, and of 16 u L / |cos θ| + 4 u t along it. Two hits within these distances are a *tie*. A
//! triangle hit by one backend and missed by the other is a *graze* if the ray comes within 8 u L of one of its edges.
//! Everything else is a *true difference*.
//!
//! Products that underflow add half of the least f32 to each coordinate. Triangles of instances have the additional
//! error [`placement_error`]. Distances are computed in f64, whose own rounding is 2⁻²⁹ of these bounds. A ray without
//! a finite origin and direction has a unique correct answer; any other is a difference.

mod tally;

pub use tally::{Category, DifferenceCounts};

use crate::geometry::{Geometry, Hit, Ray, placement_error};
use glam::DVec3;

/// Unit roundoff u of f32.
const U: f64 = f32::EPSILON as f64 * 0.5;

/// Displacement of a vertex across the ray by products that underflow in f32: half of the least f32, 2⁻¹⁵⁰, in each of
/// two coordinates, hence the factor √2.
const UNDERFLOW: f64 = std::f64::consts::SQRT_2 * 0.5 * f32::from_bits(1) as f64;

/// Relation of two answers to a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Agreement {
    /// The same triangle, or both none.
    Same,
    /// Two triangles, or a triangle and an end of the ray, at distances equal within rounding.
    Tie,
    /// One answer misses a triangle that the ray hits within rounding of an edge.
    Graze,
    /// One of them is wrong.
    Different,
}

/// Compares two answers to `ray`.
///
/// # Panics
/// If a hit does not belong to `geometry`.
pub fn agreement(geometry: &Geometry, ray: &Ray, a: Option<Hit>, b: Option<Hit>) -> Agreement {
    if a == b {
        return Agreement::Same;
    }
    if !(ray.origin.is_finite() && ray.direction.is_finite()) {
        return Agreement::Different;
    }
    let [a, b] = [a, b].map(|hit| hit.map(|hit| Met::new(geometry, ray, hit)));
    match (a, b) {
        (Some(a), Some(b)) if (a.distance - b.distance).abs() <= a.along.max(b.along) => Agreement::Tie,
        // The other answer has missed the nearer one.
        (Some(a), Some(b)) => if a.distance < b.distance { a } else { b }.passed(ray),
        (Some(met), None) | (None, Some(met)) => met.passed(ray),
        (None, None) => Agreement::Same,
    }
}

/// A reported hit.
struct Met {
    /// Distance from the ray's origin, in the unit of the coordinates.
    distance: f64,
    /// Rounding error of the distance.
    along: f64,
    /// Distance of the ray's line from the nearest edge.
    to_edge: f64,
    /// Rounding error of the distance to the edge.
    across: f64,
}

impl Met {
    fn new(geometry: &Geometry, ray: &Ray, hit: Hit) -> Self {
        let d = ray.direction.as_dvec3().normalize();
        let (vertices, placing) = vertices(geometry, hit);
        let [a, b, c] = vertices.map(|v| v - ray.origin.as_dvec3());
        let normal = (b - a).cross(c - a);
        let distance = normal.dot(a) / normal.dot(d);
        let cosine = normal.dot(d).abs() / normal.length();
        let farthest = a.length().max(b.length()).max(c.length());
        let along = (16.0 * U * farthest + 2.0 * placing) / cosine + 4.0 * U * distance.abs();
        let flat = [a, b, c].map(|v| v - d * v.dot(d));
        let to_edge = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| from_segment(flat[i], flat[j]));
        let to_edge = to_edge.into_iter().fold(f64::INFINITY, f64::min);
        Met { distance, along, to_edge, across: 8.0 * U * farthest + UNDERFLOW + placing }
    }

    /// Returns the relation to an answer without this hit.
    fn passed(&self, ray: &Ray) -> Agreement {
        let length = ray.direction.as_dvec3().length();
        let is_end = |t: f32| (self.distance - f64::from(t) * length).abs() <= self.along;
        if is_end(ray.t_min) || is_end(ray.t_max) {
            Agreement::Tie
        } else if self.to_edge <= self.across {
            Agreement::Graze
        } else {
            Agreement::Different
        }
    }
}

/// Returns the world-space vertices of a triangle, and the placement error of a coordinate.
fn vertices(geometry: &Geometry, hit: Hit) -> ([DVec3; 3], f64) {
    let mesh = geometry.mesh_of(hit.object);
    let corners = mesh.corners(hit.primitive);
    match &geometry.objects[hit.object as usize].placement {
        None => (corners.map(|p| p.as_dvec3()), 0.0),
        Some(m) => {
            let most = corners.iter().fold(glam::Vec3::ZERO, |most, p| most.max(p.abs()));
            let exact = m.as_daffine3();
            (corners.map(|p| exact.transform_point3(p.as_dvec3())), f64::from(placement_error(m, most)))
        }
    }
}

/// Returns the distance of the origin from the segment between `p` and `q`.
fn from_segment(p: DVec3, q: DVec3) -> f64 {
    let along = q - p;
    let share = (-p.dot(along) / along.length_squared()).clamp(0.0, 1.0);
    if share.is_nan() { p.length() } else { (p + along * share).length() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Attributes, Object, TriangleMesh};
    use glam::Vec3;
    use std::sync::Arc;

    /// Three right triangles in planes z = 0, −`gap` and −1.
    fn planes(gap: f32) -> Geometry {
        let plane = |z: f32| {
            let positions = vec![Vec3::new(0.0, 0.0, z), Vec3::new(1.0, 0.0, z), Vec3::new(0.0, 1.0, z)];
            Arc::new(TriangleMesh::new("plane", positions, vec![[0, 1, 2]], Attributes::default()).unwrap())
        };
        let objects = (0..3).map(|mesh| Object { mesh, placement: None, filtered: false }).collect();
        Geometry { meshes: vec![plane(0.0), plane(-gap), plane(-1.0)], objects }
    }

    fn down(x: f32, y: f32) -> Ray {
        Ray::new(Vec3::new(x, y, 1.0), Vec3::NEG_Z * 3.0)
    }

    const fn hit(object: u32) -> Option<Hit> {
        Some(Hit { object, primitive: 0 })
    }

    #[test]
    fn ties_are_as_wide_as_rounding() {
        // L is √2 and more: the bound is 16 u L + 4 u, about 1.6e-6.
        for (gap, expected) in [(1e-6, Agreement::Tie), (4e-6, Agreement::Different)] {
            assert_eq!(agreement(&planes(gap), &down(0.25, 0.25), hit(0), hit(1)), expected, "{gap}");
            assert_eq!(agreement(&planes(gap), &down(0.25, 0.25), hit(1), hit(0)), expected, "{gap}");
        }
    }

    #[test]
    fn misses_are_excused_beside_an_edge_and_nowhere_else() {
        let geometry = planes(0.5);
        // 8 u L is about 7e-7.
        for (y, expected) in [(3e-7, Agreement::Graze), (-3e-7, Agreement::Graze), (3e-6, Agreement::Different)] {
            for other in [None, hit(2)] {
                assert_eq!(agreement(&geometry, &down(0.25, y), hit(0), other), expected, "{y} {other:?}");
            }
        }
        let beyond = down(1.25, 0.0);
        assert_eq!(
            agreement(&geometry, &beyond, hit(0), None),
            Agreement::Different,
            "beside the edge's line, past its end"
        );
    }

    #[test]
    fn a_hit_at_an_end_of_the_ray_is_a_tie_with_none() {
        let geometry = planes(0.5);
        let at_the_end = Ray { t_max: 1.0 / 3.0, ..down(0.25, 0.25) };
        assert_eq!(agreement(&geometry, &at_the_end, hit(0), None), Agreement::Tie);
        let beyond = Ray { t_max: 0.33, ..at_the_end };
        assert_eq!(agreement(&geometry, &beyond, hit(0), None), Agreement::Different);
    }

    #[test]
    fn equal_hits_are_the_same_and_invalid_rays_hit_nothing() {
        let geometry = planes(0.5);
        assert_eq!(agreement(&geometry, &down(0.25, 0.25), hit(0), hit(0)), Agreement::Same);
        assert_eq!(agreement(&geometry, &Ray::new(Vec3::NAN, Vec3::X), None, None), Agreement::Same);
        assert_eq!(agreement(&geometry, &Ray::new(Vec3::NAN, Vec3::X), None, hit(0)), Agreement::Different);
    }
}
