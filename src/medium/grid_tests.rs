use super::*;
use etendue_testing::random::Random;
use glam::{DMat3, DQuat, DVec3};

fn grid(size: [usize; 3], values: Vec<f32>, to_scene: &DAffine3) -> Grid {
    Grid::new(Arc::new(Blocks::new(size, &values)), to_scene)
}

/// A box of 5 × 4 × 6 cells with random values, a third of them 0.
fn random_grid(random: &mut Random, to_scene: &DAffine3) -> Grid {
    let size = [5, 4, 6];
    let value = |random: &mut Random| (random.f32() - 0.3).max(0.0) * 4.0;
    grid(size, (0..120).map(|_| value(random)).collect(), to_scene)
}

/// Turned, stretched and moved.
fn placement() -> DAffine3 {
    let turn = DMat3::from_quat(DQuat::from_rotation_x(0.7) * DQuat::from_rotation_z(1.9));
    DAffine3::from_mat3_translation(turn * DMat3::from_diagonal(DVec3::new(2.0, 0.5, 1.3)), DVec3::new(0.3, -1.0, 2.0))
}

/// The integral by the midpoint rule in f64.
fn by_steps(grid: &Grid, origin: Vec3, w: Vec3, length: f32) -> f64 {
    let steps = 40_000;
    let step = f64::from(length) / f64::from(steps);
    let at = |k: i32| origin.as_dvec3() + w.as_dvec3() * ((f64::from(k) + 0.5) * step);
    (0..steps).map(|k| f64::from(grid.density(at(k).as_vec3()))).sum::<f64>() * step
}

#[test]
fn depths_are_integrals_of_the_density() {
    let mut random = Random::new(11);
    let to_scene = placement();
    let grid = random_grid(&mut random, &to_scene);
    let inner =
        |random: &mut Random| to_scene.transform_point3(DVec3::from([(); 3].map(|()| random.f64() * 1.4 - 0.2)));
    for _ in 0..40 {
        let [a, b] = [inner(&mut random), inner(&mut random)];
        let (origin, w, length) = (a.as_vec3(), (b - a).normalize().as_vec3(), (b - a).length() as f32);
        let (found, expected) = (f64::from(grid.depth(origin, w, length)), by_steps(&grid, origin, w, length));
        // The box has an edge: a step at either end. Roundings of some twenty intervals in f32.
        let error = 8.0 * f64::from(grid.most()) * f64::from(length) / 40_000.0 + 1e-5 * expected;
        assert!((found - expected).abs() < error, "{found}, expected {expected}");
    }
}

/// The same through several blocks, some of them empty.
#[test]
fn depths_are_integrals_through_blocks() {
    let mut random = Random::new(13);
    let (to_scene, size) = (placement(), [30, 21, 18]);
    let value = |i: usize, random: &mut Random| if i % 30 > 18 { 0.0 } else { random.f32() };
    let grid = grid(size, (0..30 * 21 * 18).map(|i| value(i, &mut random)).collect(), &to_scene);
    let mut inner = || to_scene.transform_point3(DVec3::from([(); 3].map(|()| random.f64() * 1.4 - 0.2)));
    for _ in 0..40 {
        let [a, b] = [inner(), inner()];
        let (origin, w, length) = (a.as_vec3(), (b - a).normalize().as_vec3(), (b - a).length() as f32);
        let (found, expected) = (f64::from(grid.depth(origin, w, length)), by_steps(&grid, origin, w, length));
        // As above, with some seventy intervals at most.
        let error = 8.0 * f64::from(grid.most()) * f64::from(length) / 40_000.0 + 2e-5 * expected;
        assert!((found - expected).abs() < error, "{found}, expected {expected}");
    }
}

#[test]
fn flights_end_where_the_depth_is_theirs() {
    let mut random = Random::new(12);
    let to_scene = placement();
    let grid = random_grid(&mut random, &to_scene);
    let (a, b) = (to_scene.transform_point3(DVec3::splat(-0.1)), to_scene.transform_point3(DVec3::splat(1.1)));
    let (origin, w, length) = (a.as_vec3(), (b - a).normalize().as_vec3(), (b - a).length() as f32);
    let whole = grid.depth(origin, w, length);
    for _ in 0..200 {
        let depth = whole * 1.2 * random.f32();
        match grid.fly(origin, w, length, depth) {
            Reach::Ends(t, density) => {
                let found = grid.depth(origin, w, t);
                assert!((density - grid.density(origin + w * t)).abs() < 1e-4 * grid.most());
                // What the accuracy of the end is worth, and roundings.
                assert!((found - depth).abs() < 1e-5 * whole, "{found}, expected {depth}");
            }
            Reach::Passes(found) => assert!(depth >= found && found == whole, "{depth} of {found}"),
        }
    }
}

/// A linear field is its own interpolation but for half a cell at the border; its integral is known.
#[test]
fn a_linear_field_has_its_integral() {
    let size = [8, 8, 8];
    let value = |i: usize| 1.0 + (i % 8) as f32;
    let grid = grid(size, (0..512).map(value).collect(), &DAffine3::IDENTITY);
    let w = Vec3::new(0.6, 0.0, 0.8);
    let found = grid.depth(Vec3::new(0.2, 0.4, 0.1), w, 1.0);
    // Density 8 x + ½ between the outer centres.
    let expected = 8.0 * (0.2 + 0.3) + 0.5;
    assert!((found - expected).abs() < 1e-5, "{found}, expected {expected}");
}

#[test]
fn rays_beside_the_box_and_along_its_axes() {
    let grid = grid([1, 1, 1], vec![2.0], &DAffine3::IDENTITY);
    let centre = Vec3::splat(0.5);
    for w in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Z] {
        assert!((grid.depth(centre - w * 3.0, w, f32::INFINITY) - 2.0).abs() < 1e-6);
        assert!((grid.depth(centre, w, f32::INFINITY) - 1.0).abs() < 1e-6);
        assert!((grid.depth(centre, w, 0.25) - 0.5).abs() < 1e-6);
        assert_eq!(grid.depth(centre + w * 3.0, w, f32::INFINITY), 0.0);
        assert_eq!(grid.depth(centre + w.any_orthonormal_vector() * 2.0, w, f32::INFINITY), 0.0);
    }
}
