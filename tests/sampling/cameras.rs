//! Cameras: where rays begin and go against the density that a uniform film position has there.

use etendue::camera::{ApertureShape, Camera, LensPoint, Orthographic, Pinhole, Pose, ThinLens};
use etendue_testing::chi_square::{SphereCells, p_value, sidak};
use etendue_testing::random::{Random, samples};
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};

const SAMPLES: u32 = 40_000;
/// Width and height in pixels.
const SIZE: [u32; 2] = [30, 20];
const ASPECT: f64 = 1.5;

fn pose() -> Pose {
    let backward = Vec3::new(0.3, -0.4, 0.5).normalize();
    let right = Vec3::Y.cross(backward).normalize();
    Pose { position: Vec3::new(1.0, 2.0, -3.0), right, up: backward.cross(right), backward }
}

fn film(random: &mut Random) -> [f32; 2] {
    let [x, y] = random.cube();
    [x * SIZE[0] as f32, y * SIZE[1] as f32]
}

/// Film area becomes solid angle by cos³: the density of `w` is 1 / (A cos³) with the image's area A in the distance 1.
fn pinhole_density(w: DVec3, yfov: f64, power: i32) -> f64 {
    let pose = pose();
    let along = |axis: Vec3| w.dot(axis.as_dvec3());
    let (cos, top) = (-along(pose.backward), (0.5 * yfov).tan());
    let inside = cos > 0.0 && (along(pose.up) / cos).abs() < top && (along(pose.right) / cos).abs() < top * ASPECT;
    if inside { (4.0 * top * top * ASPECT * cos.powi(power)).recip() } else { 0.0 }
}

/// p-value of a pinhole camera's directions against cos^−`power`.
fn directions_follow(yfov: f64, power: i32, seed: u64) -> f64 {
    let camera = Camera::Pinhole(Pinhole::new(pose(), yfov, SIZE[0], SIZE[1]));
    let cells = SphereCells::new((-pose().backward).as_dvec3().to_array(), 0.25 * (0.5 * yfov).powi(2));
    let expected = cells.integrate(1e-6, &|w| pinhole_density(DVec3::from(w), yfov, power)); // of a probability
    let total: f64 = expected.iter().sum();
    let (mut random, n) = (Random::new(seed), samples(SAMPLES));
    let mut observed = vec![0.0; cells.count()];
    for _ in 0..n {
        let ray = camera.ray(film(&mut random));
        assert_eq!(ray.origin, pose().position);
        assert!((ray.direction.length() - 1.0).abs() < 4.0 * f32::EPSILON);
        observed[cells.index(ray.direction.as_dvec3().to_array())] += 1.0;
    }
    let expected: Vec<f64> = expected.iter().map(|p| p * f64::from(n) / total).collect();
    p_value(&observed, &expected)
}

#[test]
fn directions_of_a_pinhole_have_the_density_of_its_film() {
    let results: Vec<f64> =
        [0.3, 1.0, 2.4].iter().zip(80..).map(|(&yfov, seed)| directions_follow(yfov, 3, seed)).collect();
    assert!(results.iter().all(|&p| p > sidak(results.len())), "{results:?}");
    // Planted: a cosine less.
    assert!(directions_follow(1.0, 2, 83) < sidak(1));
}

#[test]
fn an_orthographic_camera_covers_its_rectangle_evenly() {
    const YMAG: f64 = 0.7;
    let camera = Camera::Orthographic(Orthographic::new(pose(), YMAG, SIZE[0], SIZE[1]));
    let (mut random, n) = (Random::new(84), samples(SAMPLES));
    let mut observed = vec![0.0; 400];
    for _ in 0..n {
        let ray = camera.ray(film(&mut random));
        assert_eq!(ray.direction, -pose().backward);
        let offset = (ray.origin - pose().position).as_dvec3();
        let [x, y] = [(pose().right, YMAG * ASPECT), (pose().up, YMAG)]
            .map(|(axis, half)| 0.5 + 0.5 * offset.dot(axis.as_dvec3()) / half);
        // Rays begin on the camera's plane, to the rounding of positions of magnitude 4.
        assert!(offset.dot(pose().backward.as_dvec3()).abs() < 16.0 * f64::from(f32::EPSILON));
        let cell = |t: f64| ((t * 20.0).floor().clamp(0.0, 19.0)) as usize;
        observed[cell(y) * 20 + cell(x)] += 1.0;
    }
    let p = p_value(&observed, &vec![f64::from(n) / 400.0; 400]);
    assert!(p > sidak(1), "{p}");
}

/// A point on a ray is seen where the ray came from, and a pixel's square of film covers the area that the
/// magnification says.
#[test]
fn cameras_see_points_where_their_rays_go() {
    let cameras = [
        Camera::Pinhole(Pinhole::new(pose(), 1.0, SIZE[0], SIZE[1])),
        Camera::Orthographic(Orthographic::new(pose(), 0.7, SIZE[0], SIZE[1])),
        thin_lens(0),
        thin_lens(5),
    ];
    // Side of the square of film, in pixels: small enough for its projection to be a parallelogram to 1e-4 of a
    // pinhole's pixels of
    // 2.5 degrees, large enough for roundings of 2e-6 pixels at its corners to be 4e-4 of it.
    const SIDE: f32 = 0.02;
    let mut random = Random::new(85);
    for camera in cameras {
        for _ in 0..samples(300) {
            let (film, distance) = (film(&mut random), 0.5 + 3.0 * random.f32());
            let lens = camera.sample_lens(|| random.cube());
            let along = |x: f32, y: f32| camera.sample_ray([film[0] + x, film[1] + y], lens, 0.0).ray;
            let ray = along(0.0, 0.0);
            let p = ray.origin + ray.direction * distance;
            let seen = camera.sample_wi(p, lens).expect("in front");
            // Positions of magnitude 4 are rounded; a pixel is 1/20 of the view.
            let off = (seen.film[0] - film[0]).hypot(seen.film[1] - film[1]);
            assert!(off < 64.0 * f32::EPSILON * 20.0 / distance.min(1.0), "{camera:?} {film:?}: {:?}", seen.film);
            assert!(seen.wi.distance(-ray.direction) < 16.0 * f32::EPSILON / distance.min(1.0));
            assert!((seen.eye.p - ray.origin).length() < 32.0 * f32::EPSILON);
            let meet = |x: f32, y: f32| {
                let (r, d) = (along(x, y), ray.direction.as_dvec3());
                let (o, w) = (r.origin.as_dvec3(), r.direction.as_dvec3());
                o + w * ((p.as_dvec3() - o).dot(d) / w.dot(d))
            };
            let half = 0.5 * SIDE;
            let (across, down) = (meet(half, 0.0) - meet(-half, 0.0), meet(0.0, half) - meet(0.0, -half));
            let area = across.cross(down).length();
            let covered = area * f64::from(seen.importance) / f64::from(SIDE * SIDE);
            assert!((covered - 1.0).abs() < 2e-3, "{camera:?} {film:?}: {covered}");
            assert!(camera.sample_wi(ray.origin - ray.direction, lens).is_none());
        }
    }
}

/// x runs to the right, y down, and a smaller image of the view has the same rays at the same places.
#[test]
fn film_positions_mean_the_same_at_any_size() {
    let cameras = [
        Camera::Pinhole(Pinhole::new(pose(), 1.0, SIZE[0], SIZE[1])),
        Camera::Orthographic(Orthographic::new(pose(), 0.7, SIZE[0], SIZE[1])),
    ];
    // Positions of magnitude 4 and directions of 1, a few roundings each.
    const ROUNDING: f32 = 32.0 * f32::EPSILON;
    for camera in cameras {
        let small = camera.resized(SIZE, [15, 4]);
        let corner = |c: &Camera, x: f32, y: f32| {
            let ray = c.ray([x, y]);
            ray.origin + ray.direction
        };
        let [left, right] = [0.0, 30.0].map(|x| corner(&camera, x, 10.0).dot(pose().right));
        let [top, bottom] = [0.0, 20.0].map(|y| corner(&camera, 15.0, y).dot(pose().up));
        assert!(right > left && top > bottom, "{camera:?}");
        for [u, v] in [[0.0, 0.0], [0.3, 0.8], [1.0, 0.5]] {
            let (a, b) = (camera.ray([u * 30.0, v * 20.0]), small.ray([u * 15.0, v * 4.0]));
            let off = a.origin.distance(b.origin) + a.direction.distance(b.direction);
            assert!(off < ROUNDING, "{camera:?} {u} {v}: {off}");
        }
    }
}

/// Radius of the lens and distance of its plane of focus.
const RADIUS: f64 = 0.1;
const FOCUS: f64 = 2.0;

fn thin_lens(blades: u32) -> Camera {
    let pinhole = Pinhole::new(pose(), 1.0, SIZE[0], SIZE[1]);
    Camera::ThinLens(ThinLens::new(pinhole, ApertureShape::new(RADIUS as f32, blades, 0.3), FOCUS as f32))
}

/// All rays through a raster position meet in the plane of focus, where the pinhole's ray goes.
#[test]
fn rays_of_a_lens_meet_in_the_plane_of_focus() {
    let (camera, pinhole) = (thin_lens(0), Camera::Pinhole(Pinhole::new(pose(), 1.0, SIZE[0], SIZE[1])));
    let (mut random, axis) = (Random::new(86), -pose().backward);
    for _ in 0..samples(300) {
        let film = film(&mut random);
        let in_focus = |camera: &Camera, lens: LensPoint| {
            let ray = camera.sample_ray(film, lens, 0.0).ray;
            let along =
                (f64::from(axis.dot(pose().position - ray.origin)) + FOCUS) / f64::from(axis.dot(ray.direction));
            ray.origin.as_dvec3() + ray.direction.as_dvec3() * along
        };
        let lens = camera.sample_lens(|| random.cube());
        let off = in_focus(&camera, lens).distance(in_focus(&pinhole, LensPoint::CENTRE));
        // Positions of magnitude 4 and a direction, a few roundings each, along a ray of length 3.
        assert!(off < 64.0 * f64::from(f32::EPSILON), "{film:?}: {off:e}");
    }
}

/// p-value of the images of a point at distance `z` for being even over a disk of `radius` pixels; 0 if one lies
/// outside. Cells are 8 rings of equal area by 8 sectors.
fn image_is_even(blades: u32, z: f64, radius: f64, seed: u64) -> f64 {
    let (camera, mut random, n) = (thin_lens(blades), Random::new(seed), samples(SAMPLES));
    let chief = camera.ray([11.0, 4.0]);
    let p = chief.origin + chief.direction * (z as f32 / chief.direction.dot(-pose().backward));
    let centre = camera.sample_wi(p, LensPoint::CENTRE).expect("in front").film;
    let mut observed = vec![0.0; 64];
    for _ in 0..n {
        let lens = camera.sample_lens(|| random.cube());
        let film = camera.sample_wi(p, lens).expect("in front").film;
        let [x, y] = [0, 1].map(|i| f64::from(film[i] - centre[i]) / radius);
        // A position on the film has a dozen roundings of 30 pixels.
        if x.hypot(y) > 1.0 + 12.0 * 30.0 * f64::from(f32::EPSILON) / radius {
            return 0.0;
        }
        let (ring, sector) = ((x * x + y * y) * 8.0, (y.atan2(x) + PI) / TAU * 8.0);
        observed[(ring as usize).min(7) * 8 + (sector as usize).min(7)] += 1.0;
    }
    p_value(&observed, &vec![f64::from(n) / 64.0; 64])
}

/// The image of a point out of focus is an even disk of diameter A |z − f| / z on the plane of focus.
#[test]
fn the_image_of_a_point_out_of_focus_is_an_even_disk() {
    // Side of a pixel at distance 1.
    let pixel = 2.0 * 0.5f64.tan() / f64::from(SIZE[1]);
    let radius = |z: f64| RADIUS * (z - FOCUS).abs() / z / (FOCUS * pixel);
    let results: Vec<f64> =
        [0.7, 1.5, 9.0].iter().zip(87..).map(|(&z, seed)| image_is_even(0, z, radius(z), seed)).collect();
    assert!(results.iter().all(|&p| p > sidak(results.len())), "{results:?}");
    // Planted: a disk that is 2 % wider or narrower.
    for wrong in [1.02, 0.98] {
        assert!(image_is_even(0, 9.0, wrong * radius(9.0), 90) < sidak(1), "{wrong}");
    }
    assert!(image_is_even(5, 9.0, radius(9.0), 91) < sidak(1), "a pentagon is no disk");
}

/// A polygon of n sides has the area of the disk: its mean square distance from the centre is
/// (π / 3) (2 + cos 2π/n) / (n sin 2π/n) r².
#[test]
fn blades_are_a_polygon_of_the_same_area() {
    for (blades, seed) in [(3u32, 92), (4, 93), (6, 94), (9, 95)] {
        let (camera, mut random, n) = (thin_lens(blades), Random::new(seed), samples(SAMPLES));
        assert!((camera.lens_pdf() * PI * RADIUS * RADIUS - 1.0).abs() < 1e-6, "its density is that of the disk");
        let step = TAU / f64::from(blades);
        let expected = PI / 3.0 * (2.0 + step.cos()) / (f64::from(blades) * step.sin());
        let squares: Vec<f64> = (0..n)
            .map(|_| {
                let lens = camera.sample_lens(|| random.cube());
                let at = camera.sample_ray([0.0; 2], lens, 0.0).ray.origin - pose().position;
                assert!(at.dot(pose().backward).abs() < 32.0 * f32::EPSILON, "{at}");
                f64::from(at.length_squared()) / (RADIUS * RADIUS)
            })
            .collect();
        let mean = squares.iter().sum::<f64>() / f64::from(n);
        let variance = squares.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / f64::from(n);
        // 4.5 standard errors: a level of 7e-6, 3e-5 for all four.
        let bound = 4.5 * (variance / f64::from(n)).sqrt();
        assert!((mean - expected).abs() < bound, "{blades}: {mean} of {expected} ± {bound}");
    }
}
