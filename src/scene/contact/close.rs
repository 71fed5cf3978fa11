//! Proximity of triangles.

use crate::geometry::Triangle;
use glam::{DVec3, Vec3};

/// Shrinking of adjacent triangles toward their centroids before the test: a shared vertex or edge is no contact.
const SHRINK: f64 = 1.0 / 16.0;

/// Returns whether two triangles are within `distance` of each other. Conservative: near corners also slightly beyond
/// it. Triangles of a mesh that share a vertex (`neighbours`) must be close away from it, like the sheets of a fold.
pub(super) fn are_close(a: &Triangle, b: &Triangle, neighbours: bool, distance: f32) -> bool {
    let shrink = if neighbours && a.shares_vertex(b) { SHRINK } else { 0.0 };
    let [a, b] = [a, b].map(|t| shrunk(t, shrink));
    !axes(&a, &b).any(|axis| separates(axis, &a, &b, f64::from(distance)))
}

fn shrunk(triangle: &Triangle, by: f64) -> [DVec3; 3] {
    let corners = triangle.vertices.map(Vec3::as_dvec3);
    let centroid = (corners[0] + corners[1] + corners[2]) / 3.0;
    corners.map(|p| p.lerp(centroid, by))
}

fn edges(t: &[DVec3; 3]) -> [DVec3; 3] {
    [t[1] - t[0], t[2] - t[1], t[0] - t[2]]
}

/// Returns the axes that can separate two triangles: normals, products of edges, and normals of edges within each
/// plane.
fn axes(a: &[DVec3; 3], b: &[DVec3; 3]) -> impl Iterator<Item = DVec3> {
    let (ea, eb) = (edges(a), edges(b));
    let [na, nb] = [ea, eb].map(|e| e[0].cross(e[1]));
    let across = ea.into_iter().flat_map(move |x| eb.map(|y| x.cross(y)));
    let within = ea.map(|e| e.cross(na)).into_iter().chain(eb.map(|e| e.cross(nb)));
    [na, nb].into_iter().chain(within).chain(across)
}

/// Returns whether the projections on `axis` are farther apart than `distance`.
fn separates(axis: DVec3, a: &[DVec3; 3], b: &[DVec3; 3], distance: f64) -> bool {
    let Some(axis) = axis.try_normalize() else { return false };
    let span = |t: &[DVec3; 3]| {
        let heights = t.map(|p| p.dot(axis));
        (heights[0].min(heights[1]).min(heights[2]), heights[0].max(heights[1]).max(heights[2]))
    };
    let ((a0, a1), (b0, b1)) = (span(a), span(b));
    b0 - a1 > distance || a0 - b1 > distance
}

/// Returns whether the plane and the bounding box of a triangle are within `distance` of `p`.
pub(super) fn to_point(triangle: &Triangle, p: Vec3, distance: f32) -> bool {
    let [a, b, c] = triangle.vertices;
    let (min, max) = (a.min(b).min(c), a.max(b).max(c));
    let in_box = p.cmpge(min - distance) & p.cmple(max + distance);
    in_box.all() && (triangle.project(p.as_dvec3()) - p.as_dvec3()).length() <= f64::from(distance)
}

/// Returns whether the projection of `p` along the normal lies in the triangle.
pub(super) fn over(triangle: &Triangle, p: Vec3) -> bool {
    let n = triangle.scaled_normal();
    let corners = triangle.vertices.map(Vec3::as_dvec3);
    (0..3).all(|i| (corners[(i + 1) % 3] - corners[i]).cross(p.as_dvec3() - corners[i]).dot(n) > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(height: f32) -> Triangle {
        Triangle::new(Vec3::new(0.0, 0.0, height), Vec3::new(1.0, 0.0, height), Vec3::new(0.0, 1.0, height))
    }

    #[test]
    fn sheets_are_close_within_the_distance_only() {
        assert!(are_close(&flat(0.0), &flat(0.5), false, 0.5) && !are_close(&flat(0.0), &flat(0.5), false, 0.49));
        let aside = Triangle::new(Vec3::new(1.0, 1.0, 0.0), Vec3::new(2.0, 1.0, 0.0), Vec3::new(1.0, 2.0, 0.0));
        assert!(!are_close(&flat(0.0), &aside, false, 0.7) && are_close(&flat(0.0), &aside, false, 0.71));
    }

    #[test]
    fn neighbours_in_a_mesh_are_close_where_they_fold_only() {
        let other = |corner: Vec3| Triangle::new(Vec3::X, Vec3::Y, corner);
        assert!(!are_close(&flat(0.0), &other(Vec3::new(1.0, 1.0, 0.0)), true, 1e-3));
        assert!(are_close(&flat(0.0), &other(Vec3::new(0.1, 0.1, 1e-4)), true, 1e-3));
        assert!(are_close(&flat(0.0), &flat(0.0), true, 1e-3));
    }
}
