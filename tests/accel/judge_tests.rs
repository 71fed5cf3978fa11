//! The judge itself, on cases whose answer is known.

use crate::judge::{Judge, is_met};
use crate::scenes::{Random, icosphere, mesh, placed_cube, scene_of, triangle};
use etendue::geometry::{Geometry, Hit, Ray};
use etendue::numeric::{next_down, next_up};
use glam::{Affine3A, Mat3, Vec3};
use std::sync::Arc;

const fn hit(object: u32, primitive: u32) -> Hit {
    Hit { object, primitive }
}

/// A square of two triangles that share the diagonal from (0, 0) to (1, 1).
fn square() -> Geometry {
    let corners = vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
    scene_of(vec![mesh(corners, vec![[0, 1, 2], [0, 2, 3]])], vec![(0, None, false)])
}

fn down(x: f32, y: f32) -> Ray {
    Ray::new(Vec3::new(x, y, 1.0), -Vec3::Z)
}

#[test]
fn edge_ray_meets_both_triangles_and_its_float_neighbour_one() {
    let geometry = square();
    let judge = Judge::new(&geometry);
    for at in [0.1f32, 0.3, 0.7, 1e-30, f32::from_bits(1)] {
        assert_eq!(judge.nearest(&down(at, at)), [hit(0, 0), hit(0, 1)], "{at}");
        assert_eq!(judge.nearest(&down(at, next_down(at))), [hit(0, 0)], "{at}");
        assert_eq!(judge.nearest(&down(at, next_up(at))), [hit(0, 1)], "{at}");
    }
}

#[test]
fn vertex_ray_meets_its_triangles_and_its_outer_float_neighbour_none() {
    let geometry = square();
    let judge = Judge::new(&geometry);
    assert_eq!(judge.nearest(&down(1.0, 1.0)), [hit(0, 0), hit(0, 1)]);
    assert_eq!(judge.nearest(&down(next_up(1.0), 1.0)), []);
    assert_eq!(judge.nearest(&down(0.5, next_down(0.0))), [], "a subnormal below the edge");
    assert_eq!(judge.nearest(&down(0.5, 0.0)), [hit(0, 0)]);
}

/// o + t d is no f64 here: the ray passes (1, 1, 0) by 2⁻²⁴ of a unit of 2⁻²⁴, and f64's sums round it onto it.
#[test]
fn a_ray_is_not_rounded() {
    let geometry = square();
    let judge = Judge::new(&geometry);
    let far = Vec3::new(1.0, 1.0, 1e20);
    let aside = |x: f32| Ray::new(far, Vec3::new(x, 0.0, -1.0));
    assert_eq!(judge.nearest(&aside(0.0)).len(), 2);
    assert_eq!(judge.nearest(&aside(1e-45)), [], "1e-25 beside the vertex");
    assert_eq!(judge.nearest(&aside(-1e-45)), [hit(0, 1)], "on the upper edge, which the other triangle does not have");
}

#[test]
fn ray_ends_are_exact_and_degenerate_triangles_are_missed() {
    let flat = mesh(vec![Vec3::ZERO, Vec3::X, Vec3::X * 2.0], vec![[0, 1, 2], [0, 0, 1]]);
    let geometry = scene_of(vec![triangle(), flat], vec![(0, None, false), (1, None, false)]);
    let judge = Judge::new(&geometry);
    let ray = down(0.25, 0.25);
    assert_eq!(judge.nearest(&Ray { t_max: 1.0, ..ray }), [hit(0, 0)]);
    assert_eq!(judge.nearest(&Ray { t_max: next_down(1.0), ..ray }), []);
    assert_eq!(judge.nearest(&Ray { t_min: 1.0, ..ray }), [hit(0, 0)]);
    assert_eq!(judge.nearest(&Ray { t_min: next_up(1.0), ..ray }), []);
    assert_eq!(judge.nearest(&Ray::new(Vec3::new(-1.0, 0.25, 0.0), Vec3::X)), [], "along the plane");
    assert_eq!(judge.nearest(&down(1.5, 0.0)), [], "a line of no area");
    assert_eq!(judge.nearest(&Ray::new(ray.origin, Vec3::ZERO)), []);
    assert_eq!(judge.nearest(&Ray::new(Vec3::NAN, Vec3::X)), []);
    assert!(is_met(&geometry, &ray, hit(0, 0)) && !is_met(&geometry, &ray, hit(1, 0)));
}

#[test]
fn placed_vertices_are_not_rounded() {
    // 0.1 · 0.1 + 0.1 is no f32 and no f64, yet one triangle begins where the other ends.
    let m = Affine3A::from_mat3_translation(Mat3::from_diagonal(Vec3::new(-0.1, 0.1, 0.1)), Vec3::splat(0.1));
    let [a, b, c] = [Vec3::ZERO, Vec3::new(0.1, 0.0, 0.0), Vec3::new(0.0, 0.1, 0.0)];
    let placed = mesh(vec![a, b, c], vec![[0, 1, 2]]);
    let geometry = scene_of(vec![Arc::clone(&placed), placed], vec![(0, Some(m), false), (1, Some(m), false)]);
    let corner = m.translation.x;
    assert_eq!(Judge::new(&geometry).nearest(&down(corner, corner)), [hit(0, 0), hit(1, 0)]);
    assert_eq!(Judge::new(&geometry).nearest(&down(next_up(corner), corner)), []);
    assert_eq!(Judge::new(&geometry).nearest(&down(next_down(corner), next_up(corner))).len(), 2);
}

#[test]
fn a_closed_body_is_met_wherever_it_is_left() {
    let geometry = scene_of(vec![icosphere(2, 1.0, Vec3::ZERO)], vec![(0, None, false)]);
    let judge = Judge::new(&geometry);
    let mut random = Random(21);
    for &vertex in geometry.mesh_of(0).positions() {
        let origin = random.in_cube(0.3);
        assert!(!judge.nearest(&Ray::new(origin, vertex - origin)).is_empty(), "{vertex}");
        let through = judge.nearest(&Ray::new(Vec3::ZERO, vertex));
        assert!((5..=6).contains(&through.len()), "exactly through a vertex are all its triangles: {through:?}");
    }
}

/// The filter must not change what exact arithmetic says: for it, each triangle alone.
#[test]
fn float_filter_of_the_judge_excludes_no_hit() {
    let geometry = placed_cube();
    let judge = Judge::new(&geometry);
    let mut random = Random(22);
    let objects = || (0..).zip(&geometry.objects);
    for _ in 0..300 {
        let ray = random.ray(4.0);
        let every = objects().flat_map(|(object, _)| {
            (0..geometry.mesh_of(object).triangles().len() as u32).map(move |primitive| hit(object, primitive))
        });
        let met = every.filter(|&hit| is_met(&geometry, &ray, hit)).count();
        assert_eq!(met == 0, judge.nearest(&ray).is_empty(), "{ray:?}");
    }
}
