//! Rays that leave a surface do not meet it again, at any scale, and pass nothing that lies close to it.

use crate::scenes::{Random, built, each, icosphere, mesh, scene_of};
use etendue::accel::{Accel, Backend, Build, Intersector};
use etendue::geometry::{Geometry, Hit, Opaque, Ray, Triangle, spawn_ray};
use etendue::lab::hard_cases;
use etendue_testing::deep;
use glam::{Affine3A, Mat3, Vec3};
use rayon::prelude::*;

const TRIANGLES: u64 = 1000;
/// The gap between two sheets above which a ray from one meets the other, in error bounds e of a point on the first. A
/// spawned ray begins up to √3 e + e off the point, the sum's and the point's rounding included. A backend finds the
/// other's plane within 16 u L, L being at most √3 times the sum of the edges, of which e is 12 u at least: 2.4 e. The
/// second sheet's own vertices are rounded by e / 4. Together 5.4.
const GAP: f32 = 5.5;

fn rays_each() -> usize {
    if deep() { 1000 } else { 100 }
}

/// A number from 1e-8 to 1e8.
fn scale(random: &mut Random) -> f32 {
    10f32.powf(16.0 * random.unit() - 8.0)
}

/// Corners at the given scale, up to a hundred times as far from the origin as they are apart.
fn somewhere(random: &mut Random) -> Vec<Vec3> {
    let size = scale(random);
    let distance = size * 100f32.powf(random.unit());
    let center = random.in_cube(distance);
    (0..3).map(|_| center + random.in_cube(size)).collect()
}

/// One triangle; one in four is placed by a map that turns, shears, mirrors and moves.
fn one_triangle(index: u64, random: &mut Random) -> Geometry {
    let linear = Mat3::from_cols(Vec3::new(-1.1, 0.2, 0.3), Vec3::new(0.4, 0.8, -0.5), Vec3::new(0.1, 0.6, 0.9));
    let corners = somewhere(random);
    let shift = corners[0] * random.unit();
    let placement = (index % 4 == 3).then(|| Affine3A::from_mat3_translation(linear, shift));
    scene_of(vec![mesh(corners, vec![[0, 1, 2]])], vec![(0, placement, false)])
}

fn unit_normal(triangle: &Triangle) -> Vec3 {
    triangle.scaled_normal().normalize_or_zero().as_vec3()
}

fn inside(random: &mut Random) -> [f32; 2] {
    let (u, v) = (random.unit(), random.unit());
    if u + v < 1.0 { [u, v] } else { [1.0 - u, 1.0 - v] }
}

/// Any direction; one time in four nearly along the surface.
fn leaving(random: &mut Random, ng: Vec3) -> Vec3 {
    let d = random.direction();
    if random.below(4) > 0 { d } else { d - ng * (d.dot(ng) * (1.0 - 1e-6 * random.unit())) }
}

/// How many rays that leave a triangle, moved off it by `share` of the bound, meet it again.
fn met_again(backend: Backend, share: f32) -> usize {
    let of_one = |index: u64| {
        let mut random = Random(1000 + index);
        let geometry = one_triangle(index, &mut random);
        let accel = built(&geometry, (backend, Build::Robust));
        let triangle = geometry.triangle(Hit { object: 0, primitive: 0 });
        let ng = unit_normal(&triangle);
        let again = |_: &usize| {
            let (p, error) = triangle.point(inside(&mut random));
            let ray = spawn_ray(p, error * share, ng, leaving(&mut random, ng));
            accel.closest(&ray, &Opaque).is_some() || accel.occluded(&ray, &Opaque)
        };
        (0..rays_each()).filter(again).count()
    };
    (0..TRIANGLES).into_par_iter().map(of_one).sum()
}

#[test]
fn a_spawned_ray_never_meets_the_triangle_it_leaves() {
    for &backend in Backend::AVAILABLE {
        assert_eq!(met_again(backend, 1.0), 0, "{backend:?}");
    }
}

/// What the test above would see of a renderer whose rays begin on the surface.
#[test]
fn without_the_bound_rays_meet_the_triangle_they_leave() {
    for &backend in Backend::AVAILABLE {
        let asked = TRIANGLES as usize * rays_each();
        let met = met_again(backend, 0.0);
        println!("{backend:?}: {met} of {asked}");
        assert!(met > asked / 100, "{backend:?}: {met} of {asked}");
    }
}

/// How many rays from a sheet toward another, `gaps` bounds away, do not meet it first; and how many were asked.
fn passed_the_wall(backend: Backend, gaps: f32) -> [usize; 2] {
    let mut count = [0, 0];
    for index in 0..TRIANGLES / 4 {
        let mut random = Random(5000 + index);
        let corners = somewhere(&mut random);
        let triangle = Triangle::new(corners[0], corners[1], corners[2]);
        let ng = unit_normal(&triangle);
        let (_, error) = triangle.point([0.3, 0.3]);
        let edges = [corners[1] - corners[0], corners[2] - corners[1], corners[0] - corners[2]].map(Vec3::length);
        // A sliver is narrower than its bound.
        if triangle.area() < 1e-2 * f64::from(edges[0].max(edges[1]).max(edges[2])).powi(2) {
            continue;
        }
        // The bound at the farthest corner is that of no inner point, but not below any.
        let most = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|b| triangle.point(b).1).into_iter().fold(error, f32::max);
        let moved = corners.iter().map(|&p| p + ng * (gaps * most)).collect();
        let [near, far] = [corners, moved].map(|corners| mesh(corners, vec![[0, 1, 2]]));
        let accel =
            built(&scene_of(vec![near, far], vec![(0, None, false), (1, None, false)]), (backend, Build::Robust));
        for _ in 0..rays_each() {
            let b = [0.2 + 0.4 * random.unit(), 0.2 + 0.15 * random.unit()];
            let (p, error) = triangle.point(b);
            // Within 60 degrees of the normal, so that it cannot pass beside.
            let d = (ng + random.direction() * 0.8).normalize();
            count[0] +=
                usize::from(accel.closest(&spawn_ray(p, error, ng, d), &Opaque).map(|hit| hit.object) != Some(1));
            count[1] += 1;
        }
    }
    count
}

#[test]
fn a_wall_beyond_the_bound_is_met_and_one_within_it_is_not() {
    for &backend in Backend::AVAILABLE {
        for gaps in [GAP, 10.0, 100.0] {
            let [passed, asked] = passed_the_wall(backend, gaps);
            assert!(passed == 0 && asked > 10_000, "{backend:?}: {passed} of {asked} pass a wall at {gaps} bounds");
        }
        let [passed, asked] = passed_the_wall(backend, 0.5);
        assert!(passed > asked / 2, "the limit that the bound documents: {passed} of {asked}");
    }
}

/// 27 boxes with common faces: from any face, inward or into the neighbour, there is always a next wall.
#[test]
fn nothing_leaks_between_touching_boxes() {
    let case = hard_cases::by_name("adjoining-cubes").expect("a case");
    let geometry = case.geometry();
    for accel in each(geometry) {
        let mut random = Random(31);
        for _ in 0..1000 * rays_each() {
            let hit = Hit { object: random.below(27) as u32, primitive: random.below(12) as u32 };
            let triangle = geometry.triangle(hit);
            let (p, error) = triangle.point(inside(&mut random));
            let (ng, d) = (unit_normal(&triangle), random.direction());
            // From the faces of the whole only inward.
            let leaves_all = p.dot(ng) > 0.999 && d.dot(ng) > 0.0;
            let ray = spawn_ray(p, error, ng, if leaves_all { -d } else { d });
            assert!(
                accel.closest(&ray, &Opaque).is_some() && accel.occluded(&ray, &Opaque),
                "{:?} {ray:?}",
                accel.backend()
            );
        }
    }
}

/// A sphere of radius 1 that touches a square of 20 by 20, and the sphere alone.
fn resting() -> [Geometry; 2] {
    let lowest = icosphere(5, 1.0, Vec3::ZERO).bounds().min.z;
    let sphere = icosphere(5, 1.0, Vec3::Z * -lowest);
    let at = |x: f32, y: f32| Vec3::new(x, y, 0.0) * 10.0;
    let floor = mesh(vec![at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)], vec![[0, 1, 2], [0, 2, 3]]);
    let alone = scene_of(vec![sphere.clone()], vec![(0, None, false)]);
    [scene_of(vec![floor, sphere], vec![(0, None, false), (1, None, false)]), alone]
}

/// How high the sphere is above a point of the floor.
fn height(alone: &Accel, geometry: &Geometry, p: Vec3) -> Option<f64> {
    let ray = Ray::new(p - Vec3::Z, Vec3::Z);
    let meet = geometry.triangle(alone.closest(&ray, &Opaque)?).meet(&ray)?;
    Some(f64::from(meet.t) - 1.0)
}

#[test]
fn nothing_passes_between_a_sphere_and_the_floor_it_rests_on() {
    let [both, one] = resting();
    for &backend in Backend::AVAILABLE {
        let [accel, alone] = [&both, &one].map(|geometry| built(geometry, (backend, Build::Robust)));
        let (mut asked, mut random) = (0, Random(32));
        for _ in 0..1000 * rays_each() {
            // Crowded at the contact.
            let aside = 0.9 * random.unit().powi(4);
            let around = random.direction() * Vec3::new(1.0, 1.0, 0.0) * aside;
            let floor = Hit { object: 0, primitive: u32::from(around.y > around.x) };
            let (_, error) = both.triangle(floor).point([0.5, 0.0]);
            let Some(height) = height(&alone, &one, around) else { continue };
            if height < f64::from(GAP * error) {
                continue;
            }
            asked += 1;
            let up = accel.closest(&spawn_ray(around, error, Vec3::Z, Vec3::Z), &Opaque);
            assert_eq!(up.map(|hit| hit.object), Some(1), "{backend:?} from {around}");
        }
        assert!(asked > 10_000, "{asked}");
    }
}
