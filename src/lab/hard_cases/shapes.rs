//! Meshes of the cases. Closed meshes share vertex indices, so that rounding cannot open them.

use super::numbers::Numbers;
use crate::geometry::{Attributes, Geometry, Object, TriangleMesh};
use glam::{Affine3A, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Vertex positions and triangles.
pub type Faces = (Vec<Vec3>, Vec<[u32; 3]>);

/// Returns a mesh of valid faces.
pub(super) fn mesh((positions, triangles): Faces) -> Arc<TriangleMesh> {
    let mesh = TriangleMesh::new("hard case", positions, triangles, Attributes::default());
    Arc::new(mesh.expect("finite positions and indices in range"))
}

/// Returns a world with each of `meshes` once, without placement.
pub(super) fn world(meshes: impl IntoIterator<Item = Faces>) -> Geometry {
    let meshes: Vec<_> = meshes.into_iter().map(mesh).collect();
    let objects = (0..meshes.len() as u32).map(|mesh| Object { mesh, placement: None, filtered: false }).collect();
    Geometry { meshes, objects }
}

/// Returns a world with one mesh at several placements.
pub(super) fn instances(shape: Faces, placements: Vec<Affine3A>) -> Geometry {
    let object = |m| Object { mesh: 0, placement: Some(m), filtered: false };
    Geometry { meshes: vec![mesh(shape)], objects: placements.into_iter().map(object).collect() }
}

/// Returns an icosahedron with its 20 faces subdivided into four `levels` times, and its vertices projected to the
/// sphere; wound outward.
pub fn sphere(levels: u32, radius: f32, center: Vec3) -> Faces {
    let golden = (1.0 + 5.0f32.sqrt()) / 2.0;
    let corners = |axis: usize| {
        [(1.0, golden), (1.0, -golden), (-1.0, golden), (-1.0, -golden)].map(|(a, b)| {
            let p = [0.0, a, b];
            Vec3::new(p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]).normalize()
        })
    };
    let mut points: Vec<Vec3> = (0..3).flat_map(corners).collect();
    // Edges of the icosahedron in the unit sphere have length 1.05, its other chords 1.7 and more.
    let near = |i: usize, j: usize| points[i].distance(points[j]) < 1.3;
    let mut faces = Vec::new();
    for (i, j, k) in (0..12).flat_map(|i| (0..12).flat_map(move |j| (0..12).map(move |k| (i, j, k)))) {
        let is_first = i < j && i < k;
        let outward = |a: Vec3, b: Vec3, c: Vec3| (b - a).cross(c - a).dot(a) > 0.0;
        if is_first && near(i, j) && near(j, k) && near(k, i) && outward(points[i], points[j], points[k]) {
            faces.push([i as u32, j as u32, k as u32]);
        }
    }
    for _ in 0..levels {
        faces = cut(&mut points, &faces);
    }
    (points.into_iter().map(|p| center + p * radius).collect(), faces)
}

/// Subdivides each face into four at the edge midpoints, which are projected to the unit sphere.
fn cut(points: &mut Vec<Vec3>, faces: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut middles = HashMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            points.push((points[a as usize] + points[b as usize]).normalize());
            points.len() as u32 - 1
        })
    };
    let cut_one = |&[a, b, c]: &[u32; 3]| {
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    };
    faces.iter().flat_map(cut_one).collect()
}

/// Returns a closed box from `least` to `most`, with `cells`² squares of two triangles per face.
pub(super) fn solid(cells: u32, least: Vec3, most: Vec3) -> Faces {
    let (mut positions, mut triangles, mut indices) = (Vec::new(), Vec::new(), HashMap::new());
    let share = |i: u32| i as f32 / cells as f32;
    let mut vertex = |at: [u32; 3]| {
        *indices.entry(at).or_insert_with(|| {
            let shares = Vec3::from(at.map(share));
            // Exact at both ends, so that adjacent boxes share faces.
            positions.push(least * (Vec3::ONE - shares) + most * shares);
            positions.len() as u32 - 1
        })
    };
    for (axis, far) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
        for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
            let mut corner = |di: u32, dj: u32| {
                let mut at = [0; 3];
                (at[axis], at[(axis + 1) % 3], at[(axis + 2) % 3]) = (if far { cells } else { 0 }, i + di, j + dj);
                vertex(at)
            };
            let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            triangles.extend(if far { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
        }
    }
    (positions, triangles)
}

/// Returns a square of half-width `half` at height `z`, with `cells`² squares of two triangles.
pub(super) fn plane(cells: u32, half: f32, z: f32) -> Faces {
    let side = cells + 1;
    let at = |i: u32| half * (2.0 * i as f32 / cells as f32 - 1.0);
    let positions = (0..side * side).map(|n| Vec3::new(at(n % side), at(n / side), z)).collect();
    let square = |n: u32| {
        let a = n / cells * side + n % cells;
        [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]]
    };
    (positions, (0..cells * cells).flat_map(square).collect())
}

/// Returns `count` random triangles in the cube from −1 to 1, with sizes between two bounds.
pub(super) fn soup(count: u32, least: f32, most: f32) -> Faces {
    let mut numbers = Numbers::new("soup", 0);
    let mut positions = Vec::new();
    for _ in 0..count {
        let (center, size) = (numbers.in_cube(1.0), numbers.magnitude(least, most));
        positions.extend([0; 3].map(|_| center + numbers.in_cube(size)));
    }
    (positions, apart(count))
}

/// Returns the indices of `count` triangles without shared vertices.
pub(super) fn apart(count: u32) -> Vec<[u32; 3]> {
    (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect()
}
