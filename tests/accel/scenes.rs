//! Small scenes and random rays.

use etendue::accel::{Accel, Backend, Build};
use etendue::geometry::{Attributes, Geometry, Object, Ray, TriangleMesh};
use etendue::lab::hard_cases::sphere;
use glam::{Affine3A, Mat3, Quat, Vec3};
use std::f32::consts::TAU;
use std::sync::Arc;

/// SplitMix64 [Steele14].
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u32 << 24) as f32
    }

    /// Uniform below `n`.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// Uniform on the unit sphere.
    pub(crate) fn direction(&mut self) -> Vec3 {
        let z = 1.0 - 2.0 * self.unit();
        let (sin, cos) = (TAU * self.unit()).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(r * cos, r * sin, z)
    }

    /// Uniform in a cube around the origin.
    pub(crate) fn in_cube(&mut self, half: f32) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * (2.0 * half) - Vec3::splat(half)
    }

    /// A ray between two points of a cube, its direction not of unit length.
    pub(crate) fn ray(&mut self, half: f32) -> Ray {
        let origin = self.in_cube(half);
        Ray::new(origin, self.in_cube(half) - origin)
    }
}

pub(crate) fn mesh(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Arc<TriangleMesh> {
    Arc::new(TriangleMesh::new("test", positions, triangles, Attributes::default()).expect("valid"))
}

pub(crate) fn triangle() -> Arc<TriangleMesh> {
    mesh(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]])
}

/// An icosahedron whose faces are split into four `levels` times, its vertices on a sphere.
pub(crate) fn icosphere(levels: u32, radius: f32, center: Vec3) -> Arc<TriangleMesh> {
    let (positions, triangles) = sphere(levels, radius, center);
    mesh(positions, triangles)
}

/// Objects of one mesh each.
pub(crate) fn scene_of(meshes: Vec<Arc<TriangleMesh>>, objects: Vec<(u32, Option<Affine3A>, bool)>) -> Geometry {
    let objects = objects.into_iter().map(|(mesh, placement, filtered)| Object { mesh, placement, filtered }).collect();
    Geometry { meshes, objects }
}

/// A 3×3×3 grid of turned, sheared, stretched, shrunk and mirrored icosahedra of radius up to 1 around the origin, the
/// same mesh once more where it is, and a large triangle; every third object is filtered.
pub(crate) fn placed_cube() -> Geometry {
    let mut random = Random(7);
    let floor = mesh(
        vec![Vec3::new(-9.0, -3.0, -9.0), Vec3::new(9.0, -3.0, -9.0), Vec3::new(0.0, -3.0, 12.0)],
        vec![[0, 1, 2]],
    );
    let mut objects = vec![(0, None, true), (1, None, false)];
    for i in (0..27).filter(|&i| i != 13) {
        let cell = Vec3::new((i % 3) as f32, (i / 3 % 3) as f32, (i / 9) as f32) - Vec3::ONE;
        let mirror = if i % 2 == 0 { -1.0 } else { 1.0 };
        let scale =
            Vec3::new(mirror * (0.4 + 0.5 * random.unit()), 0.4 + 0.5 * random.unit(), 0.4 + 0.5 * random.unit());
        let shear = Mat3::from_cols(Vec3::X, Vec3::new(0.3 * random.unit(), 1.0, 0.0), Vec3::Z);
        let turn = Mat3::from_quat(Quat::from_axis_angle(random.direction(), TAU * random.unit()));
        let linear = turn * shear * Mat3::from_diagonal(scale);
        objects.push((0, Some(Affine3A::from_mat3_translation(linear, cell * 2.2)), i % 3 == 0));
    }
    scene_of(vec![icosphere(0, 0.8, Vec3::ZERO), floor], objects)
}

pub(crate) const BUILDS: [Build; 4] = [Build::Fast, Build::Robust, Build::Compact, Build::High];

/// A backend and how it builds.
pub(crate) type Setup = (Backend, Build);

/// Every build of every backend that there is.
pub(crate) fn setups() -> Vec<Setup> {
    Backend::AVAILABLE.iter().flat_map(|&backend| BUILDS.map(|build| (backend, build))).collect()
}

pub(crate) fn built(geometry: &Geometry, (backend, build): Setup) -> Accel {
    Accel::build(geometry, backend, build, 1).expect("builds")
}

/// `geometry` under each backend's robust build.
pub(crate) fn each(geometry: &Geometry) -> Vec<Accel> {
    Backend::AVAILABLE.iter().map(|&backend| built(geometry, (backend, Build::Robust))).collect()
}
