//! How fast errors fall with the number of samples.

use crate::picture::{Shot, render, scene};
use etendue::integrator::Method;
use etendue::sampling::SamplerKind;
use etendue::scene::Scene;
use etendue::scene::description::Description;
use etendue_testing::slope::slope;
use etendue_testing::studio::{add, add_room, camera, matte, narrow};
use glam::{DVec3, Vec3};

/// Slope of the mean squared error of 32 × 32 pixels over 4 to 256 samples.
fn fall(scene: &Scene, exact: f64, shot: Shot) -> f64 {
    let mse = |spp: u64| {
        let picture = render(scene, Shot { spp, ..shot });
        // All lanes are alike.
        picture.mean.iter().step_by(3).map(|m| (m - exact).powi(2)).sum::<f64>() / (shot.side * shot.side) as f64
    };
    let points: Vec<(f64, f64)> = (2..=8).map(|k| (f64::from(1 << k), mse(1 << k))).collect();
    println!("{points:?}");
    slope(&points)
}

/// Independent samples: −1. The logarithm of a mean over 1024 pixels deviates by √(2/1024) = 0.044 for normal errors
/// and by twice that for these skewed ones, the slope by 0.088 / (ln 2 √28) = 0.024: four of these, level 6e-5, are
/// within the survey's 0.1.
#[test]
fn the_error_of_independent_samples_falls_with_their_number() {
    let mut room = Description::default();
    add_room(&mut room, &matte(0.5, 0.5));
    room.cameras.push(camera(DVec3::new(0.3, -0.2, 0.5), DVec3::new(-1.0, 0.4, 0.1)));
    let shot = Shot { sampler: SamplerKind::Independent, ..Shot::new(Method::Path, 32, 4) };
    let slope = fall(&scene(room), 1.0, shot);
    println!("independent: slope {slope:.3}");
    assert!((slope + 1.0).abs() < 0.1, "{slope}");
}

/// Owen-scrambled points on a smooth integrand of two dimensions: −3 in the limit [Owen97]; steeper than −2 between 4
/// and 256, of which each of the four replicates takes a quarter. A lamp of one triangle leaves no choice but that of
/// its point.
#[test]
fn the_error_of_sobol_points_falls_faster_where_light_is_smooth() {
    let mut room = Description::default();
    let corners = [DVec3::new(-0.5, 1.0, -0.4), DVec3::new(0.6, 1.0, -0.3), DVec3::new(0.0, 1.0, 0.7)];
    add(&mut room, corners.map(|c| c.as_vec3()).to_vec(), vec![[0, 1, 2]], matte(0.0, 1.0));
    etendue_testing::studio::add_square(&mut room, Vec3::ZERO, Vec3::X, Vec3::NEG_Z, matte(0.5, 0.0));
    room.cameras.push(narrow(camera(DVec3::new(0.02, 0.4, 0.01), DVec3::ZERO), 1e-6)); // one point
    let edge = |i: usize| {
        let (a, b) = (corners[i].normalize(), corners[(i + 1) % 3].normalize());
        a.angle_between(b) * a.cross(b).normalize().y
    };
    let exact = 0.5 / std::f64::consts::PI * 0.5 * (0..3).map(edge).sum::<f64>().abs();
    let room = scene(room);
    let slope_of = |sampler| fall(&room, exact, Shot { sampler, depth: Some(1), ..Shot::new(Method::PathNee, 32, 4) });
    let [independent, sobol] = [SamplerKind::Independent, SamplerKind::Sobol].map(slope_of);
    println!("smooth light: slopes {independent:.3} and {sobol:.3}");
    assert!((independent + 1.0).abs() < 0.1, "{independent}");
    assert!(sobol < -2.0, "{sobol}");
}
