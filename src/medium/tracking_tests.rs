use super::*;
use crate::medium::Blocks;
use etendue_testing::random::Random;
use glam::{DAffine3, DMat3, DQuat, DVec3};
use std::sync::Arc;

/// Rays through each field.
const RAYS: usize = 16;

/// Flights or estimates of each ray.
const SAMPLES: usize = 20_000;

/// Of all tests here, some false alarm has at most this probability.
const SIGNIFICANCE: f64 = 1e-6;

/// Tests of hypotheses: one of flights and two of transmittances for each ray of two fields.
const TESTS: f64 = 3.0 * 2.0 * RAYS as f64;

/// Rotated, stretched and sheared.
fn placement() -> DAffine3 {
    let turn = DMat3::from_quat(DQuat::from_rotation_x(0.7) * DQuat::from_rotation_z(1.9));
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.6, 1.0, 0.0), DVec3::new(-0.2, 0.3, 1.0));
    let stretch = DMat3::from_diagonal(DVec3::new(2.0, 0.5, 1.3));
    DAffine3::from_mat3_translation(turn * shear * stretch, DVec3::new(0.3, -1.0, 2.0))
}

fn field([a, b, c]: [usize; 3], value: impl Fn(DVec3) -> f64) -> Grid {
    let centre = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
    let at = |i: usize| DVec3::new(centre(i % a, a), centre(i / a % b, b), centre(i / (a * b), c));
    let values: Vec<f32> = (0..a * b * c).map(|i| value(at(i)) as f32).collect();
    Grid::new(Arc::new(Blocks::new([a, b, c], &values)), &placement())
}

/// Smooth, and nowhere empty.
fn smooth() -> Grid {
    field([48, 61, 53], |p| 1.1 + (9.0 * p.x + 2.0 * (7.0 * p.y).sin()).sin() * (11.0 * p.z - 4.0 * p.y).cos())
}

/// Twelve blobs in empty space.
fn sparse() -> Grid {
    let mut random = Random::new(31);
    let blobs: Vec<_> =
        (0..12).map(|_| (DVec3::from(random.cube().map(f64::from)), 0.05 + 0.1 * random.f64())).collect();
    field([128, 70, 96], |p| blobs.iter().map(|(c, r)| 8.0 * (1.0 - (p - c).length() / r).max(0.0)).sum())
}

/// A ray that crosses much of the box, and the extinction with which its optical depth is that of the second number.
fn ray(grid: &Grid, random: &mut Random) -> ([Vec3; 2], f32, f32) {
    loop {
        let mut point = || placement().transform_point3(DVec3::from([(); 3].map(|()| random.f64() * 1.2 - 0.1)));
        let [a, b] = [point(), point()];
        let (ray, length) = ([a.as_vec3(), (b - a).normalize().as_vec3()], (b - a).length() as f32);
        let depth = grid.depth(ray[0], ray[1], length);
        if depth > 0.05 {
            return (ray, length, (0.2 + 3.0 * random.f32()) / depth);
        }
    }
}

/// The largest distance of the distribution of samples from the uniform one (Kolmogorov and Smirnov), times √n.
fn distance_to_uniform(mut samples: Vec<f64>) -> f64 {
    samples.sort_by(f64::total_cmp);
    let n = samples.len() as f64;
    let at = |(i, u): (usize, &f64)| (u - i as f64 / n).abs().max((u - (i as f64 + 1.0) / n).abs());
    samples.iter().enumerate().map(at).fold(0.0, f64::max) * n.sqrt()
}

#[test]
fn delta_tracking_has_the_distribution_of_regular_tracking() {
    // Massart's bound: larger distances have the probability 2 exp(−2 d²) at most.
    let bound = ((2.0 * TESTS / SIGNIFICANCE).ln() / 2.0).sqrt();
    for (grid, seed) in [(smooth(), 32), (sparse(), 33)] {
        let mut random = Random::new(seed);
        for _ in 0..RAYS {
            let ([origin, w], length, extinction) = ray(&grid, &mut random);
            let through = |t: f32| f64::from(-extinction * grid.depth(origin, w, t)).exp();
            let mut sample = || match delta(&grid, [origin, w], length, extinction, || random.f32()) {
                Some([t, density]) => {
                    let there = grid.density(origin + w * t);
                    // The distance is rounded, and the density changes over less than a cell.
                    assert!((density - there).abs() < 1e-3 * grid.most(), "{density}, expected {there}");
                    1.0 - through(t)
                }
                // The distribution has an atom where flights pass; spread it evenly.
                None => 1.0 - through(length) * random.f64(),
            };
            let found = distance_to_uniform((0..SAMPLES).map(|_| sample()).collect());
            assert!(found < bound, "{found} for {origin} {w}");
        }
    }
}

#[test]
fn ratio_tracking_has_the_mean_of_regular_tracking() {
    // The tail of the normal distribution beyond z is less than exp(−z² / 2) / 2, on two sides.
    let bound = (2.0 * (TESTS / SIGNIFICANCE).ln()).sqrt();
    for (grid, seed) in [(smooth(), 34), (sparse(), 35)] {
        let mut random = Random::new(seed);
        for _ in 0..RAYS {
            let ([origin, w], length, extinction) = ray(&grid, &mut random);
            let expected = f64::from(-extinction * grid.depth(origin, w, length)).exp();
            let mut next = || random.f32();
            let ratios = (0..SAMPLES).map(|_| ratio(&grid, [origin, w], length, extinction, &mut next)).collect();
            let ratios = z_score(ratios, expected);
            let residual = |_| residual_ratio(&grid, [origin, w], length, extinction, &mut next);
            let residuals = z_score((0..SAMPLES).map(residual).collect(), expected);
            assert!(ratios.abs() < bound && residuals.abs() < bound, "{ratios} and {residuals} for {origin} {w}");
        }
    }
}

/// Returns the error of the mean of estimates of a transmittance in standard errors.
fn z_score(estimates: Vec<f32>, expected: f64) -> f64 {
    assert!(estimates.iter().all(|t| (0.0..=1.0).contains(t)));
    let n = estimates.len() as f64;
    let mean = estimates.iter().map(|&t| f64::from(t)).sum::<f64>() / n;
    let variance = estimates.iter().map(|&t| (f64::from(t) - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean - expected) / (variance / n).sqrt()
}

/// The control of residual ratio tracking takes all of a uniform medium.
#[test]
fn residual_ratio_tracking_of_a_uniform_medium_is_exact() {
    let grid = field([20, 20, 20], |_| 1.5);
    let mut random = Random::new(36);
    for _ in 0..100 {
        let ([origin, w], length, extinction) = ray(&grid, &mut random);
        let found = residual_ratio(&grid, [origin, w], length, extinction, || 0.999);
        let expected = (-extinction * grid.depth(origin, w, length)).exp();
        assert!((found - expected).abs() < 1e-5 * expected, "{found}, expected {expected}");
    }
}

#[test]
fn rays_without_medium_pass() {
    let grid = field([9, 9, 9], |p| f64::from(u8::from(p.x > 0.5)));
    let outside = placement().transform_point3(DVec3::splat(9.0)).as_vec3();
    for w in [Vec3::X, Vec3::Y, Vec3::Z] {
        assert_eq!(delta(&grid, [outside, w], f32::INFINITY, 9.0, || 0.0), None);
        assert_eq!(ratio(&grid, [outside, w], f32::INFINITY, 9.0, || 0.0), 1.0);
    }
    let inside = placement().transform_point3(DVec3::splat(0.6)).as_vec3();
    assert_eq!(delta(&grid, [inside, Vec3::X], f32::INFINITY, 0.0, || 0.5), None);
    assert_eq!(residual_ratio(&grid, [inside, Vec3::X], f32::INFINITY, 0.0, || 0.5), 1.0);
}
