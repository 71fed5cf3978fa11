//! Rays from inside a closed surface never leave it.

use crate::scenes::{Random, Setup, built, icosphere, scene_of, setups};
use etendue::accel::{Backend, Build, Intersector};
use etendue::geometry::{Geometry, Opaque, Ray};
use glam::{Affine3A, Mat3, Quat, Vec3};

const RAYS: usize = 200_000;

/// Those that promise watertight edges.
fn tight() -> impl Iterator<Item = Setup> {
    setups().into_iter().filter(|&setup| setup != (Backend::Embree, Build::Fast))
}

/// A point to aim at from an origin, given the corners of a random triangle.
type Aim = fn(&mut Random, Vec3, [Vec3; 3]) -> Vec3;

fn at_an_edge(random: &mut Random, _: Vec3, [a, b, _]: [Vec3; 3]) -> Vec3 {
    a.lerp(b, random.unit())
}

fn at_a_vertex(_: &mut Random, _: Vec3, [a, _, _]: [Vec3; 3]) -> Vec3 {
    a
}

/// Beside a vertex, as the ray sees it, by 20 ulps of its coordinates: above the error of the edges that meet there.
fn beside_a_vertex(random: &mut Random, origin: Vec3, [a, _, _]: [Vec3; 3]) -> Vec3 {
    let across = random.direction().cross(a - origin).normalize();
    a + across * (20.0 * f32::EPSILON * a.length().max(1.0))
}

/// A sphere at the origin, one far from it, and one that is turned, stretched, mirrored and moved.
fn spheres() -> Vec<(&'static str, Geometry, Vec3)> {
    let far = Vec3::new(100.0, -50.0, 30.0);
    let turn = Mat3::from_quat(Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 1.0));
    let linear = turn * Mat3::from_diagonal(Vec3::new(-1.3, 0.7, 1.1));
    let placed = Affine3A::from_mat3_translation(linear, Vec3::new(1.0, 2.0, 3.0));
    vec![
        ("centred", scene_of(vec![icosphere(4, 1.0, Vec3::ZERO)], vec![(0, None, false)]), Vec3::ZERO),
        ("far", scene_of(vec![icosphere(4, 1.0, far)], vec![(0, None, false)]), far),
        (
            "placed",
            scene_of(vec![icosphere(4, 1.0, Vec3::ZERO)], vec![(0, Some(placed), false)]),
            placed.translation.into(),
        ),
    ]
}

/// How many of the rays aimed at the surface leave it. Both queries are asked.
fn escapes(geometry: &Geometry, center: Vec3, setup: Setup, aim: Aim) -> (usize, usize) {
    let scene = built(geometry, setup);
    let (mesh, placement) = (geometry.mesh_of(0), geometry.objects[0].placement.unwrap_or(Affine3A::IDENTITY));
    let mut random = Random(3);
    let (mut missed, mut unoccluded) = (0, 0);
    for _ in 0..RAYS {
        let corners = mesh.triangles()[random.below(mesh.triangles().len())];
        let corners = corners.map(|i| placement.transform_point3(mesh.positions()[i as usize]));
        // Within 0.6 of the centre, which is inside each of the spheres.
        let origin = center + random.in_cube(0.34);
        let ray = Ray::new(origin, aim(&mut random, origin, corners) - origin);
        missed += usize::from(scene.closest(&ray, &Opaque).is_none());
        unoccluded += usize::from(!scene.occluded(&ray, &Opaque));
    }
    (missed, unoccluded)
}

#[test]
fn no_ray_slips_through_an_edge() {
    for (name, geometry, center) in spheres() {
        for setup in tight() {
            assert_eq!(escapes(&geometry, center, setup, at_an_edge), (0, 0), "{name} {setup:?}");
        }
    }
}

#[test]
fn no_ray_slips_through_beside_a_vertex() {
    for (name, geometry, center) in spheres() {
        for setup in tight() {
            assert_eq!(escapes(&geometry, center, setup, beside_a_vertex), (0, 0), "{name} {setup:?}");
        }
    }
}

/// Embree's edge functions agree between the two triangles of an edge, but not between the k edges of a vertex: aimed
/// at the vertex itself all are rounding noise, and a ray escapes if all have one sign. Were the signs fair coins, that
/// would be 2 of 2^k, at least 1 in 16 for the sphere's smallest k = 5; they are mostly exact, and the rate is below 1
/// in 200. Ours are exact: no ray escapes.
#[test]
fn few_rays_slip_through_a_vertex_itself() {
    for (name, geometry, center) in spheres() {
        for setup in tight() {
            let (missed, unoccluded) = escapes(&geometry, center, setup, at_a_vertex);
            println!("{name} {setup:?}: {missed} of {RAYS} rays escape through vertices");
            let allowed = if setup.0 == Backend::Obvhs { 0 } else { RAYS / 16 };
            assert!(missed.max(unoccluded) <= allowed, "{name} {setup:?}: {missed} {unoccluded}");
        }
    }
}
