//! Triangles whose emission varies: light samples and rays are in proportion to it, and their density is that of the
//! point, on a texture with one bright spot.

use etendue::geometry::Triangle;
use etendue::light::{AreaLight, BoundingSphere, Emission, EmitterPoint, LeRandom, Light, LightSampleContext};
use etendue::sampling::Density;
use etendue::spectrum::Spectrum;
use etendue::stats::{Estimate, Moments};
use etendue::texture::{Bitmap, Encoding, Texels, Texture, TextureFilter, Wrap};
use etendue_testing::chi_square::{p_value, sidak};
use etendue_testing::random::{Random, samples};
use glam::{Affine2, DVec3, Vec2, Vec3};
use statrs::distribution::{ContinuousCDF, Normal};
use std::f64::consts::PI;
use std::sync::Arc;

const BALL: BoundingSphere = BoundingSphere { centre: Vec3::ZERO, radius: 2.0 };
const SAMPLES: u32 = 100_000;
const TRIANGLE: [Vec3; 3] = [Vec3::new(-0.4, -0.3, 0.5), Vec3::new(0.6, -0.2, 0.4), Vec3::new(0.0, 0.5, 0.6)];
/// Receiver below it that sees its front.
const AT: LightSampleContext = LightSampleContext::new(Vec3::new(0.1, 0.1, -0.3), Vec3::Z);
/// Points along a side of the grid of the reference: sixteen in a texel.
const GRID: u32 = 1024;

/// A lamp whose texture of 64² texels is dim but for a spot of 4².
fn lamp() -> (Triangle, Light) {
    let texel = |i: u32| if (16..20).contains(&(i % 64)) && (8..12).contains(&(i / 64)) { 255 } else { 1 };
    let texels: Vec<_> = (0..64 * 64).map(|i| [texel(i); 4]).collect();
    let texture = Texture {
        image: Arc::new(Bitmap::new(64, 64, Texels::Rgba8(texels.into()))),
        encoding: Encoding::Linear,
        wrap: [Wrap::Clamp; 2],
        filter: TextureFilter::Nearest,
        uv_set: 0,
        transform: Affine2::IDENTITY,
    };
    let [a, b, c] = TRIANGLE;
    let triangle = Triangle::new(a, b, c);
    let texture = Some(Box::new((Arc::new(texture), [Vec2::ZERO, Vec2::X, Vec2::Y])));
    let emission = Emission { radiance: Spectrum::splat(5.0), texture, ..Emission::NONE };
    (triangle, Light::Area(AreaLight::new(triangle, -1.0, emission)))
}

/// Mean over the triangle of f(position, radiance).
fn mean_over(light: &Light, triangle: &Triangle, f: impl Fn(DVec3, f64) -> f64) -> f64 {
    let Light::Area(area) = light else { panic!("an area light") };
    let [mut sum, n] = [0.0, f64::from(GRID)];
    for (i, j) in (0..GRID).flat_map(|i| (0..GRID - i).map(move |j| (i, j))) {
        for third in [1.0, 2.0] {
            if third > 1.0 && i + j == GRID - 1 {
                continue;
            }
            let barycentric = [i, j].map(|k| ((f64::from(k) + third / 3.0) / n) as f32);
            let p = triangle.point(barycentric).0;
            let toward = (AT.p - p).normalize();
            sum += f(p.as_dvec3(), f64::from(area.radiance(barycentric, toward).mean()));
        }
    }
    sum / (n * n)
}

/// Irradiance at the receiver per area at `p` with radiance 1.
fn geometry(p: DVec3, normal: DVec3) -> f64 {
    let to = p - AT.p.as_dvec3();
    (to.z * normal.dot(to)).abs() / to.length_squared().powi(2)
}

fn differs(found: Estimate, exact: f64, tests: usize) -> bool {
    let limit = Normal::standard().inverse_cdf(1.0 - sidak(tests) / 2.0) * found.standard_error;
    (found.value - exact).abs() > limit + 1e-3 * exact // the edge between the halves cuts the grid
}

#[test]
fn light_samples_of_a_bright_spot_have_its_irradiance_and_a_tenth_of_the_variance() {
    let (triangle, light) = lamp();
    let (normal, size) = (triangle.scaled_normal().normalize(), triangle.area());
    let value = |p: DVec3, l: f64| l * geometry(p, normal) * size;
    let exact = mean_over(&light, &triangle, value);
    let by_area = mean_over(&light, &triangle, |p, l| value(p, l).powi(2)) - exact * exact;
    let mut random = Random::new(100);
    let moments: Moments = (0..samples(SAMPLES))
        .map(|_| light.sample_li(&AT, random.cube()))
        .map(|s| s.map_or(0.0, |s| f64::from(s.radiance.mean() * s.wi.z / s.density.value())))
        .collect();
    let found = moments.estimate().expect("samples");
    assert!(!differs(found, exact, 1), "{found:?} for {exact}");
    assert!(differs(Estimate { value: 1.02 * found.value, ..found }, exact, 1), "two percent are not seen: {found:?}");
    let variance = found.standard_error.powi(2) * f64::from(samples(SAMPLES));
    assert!(variance < 0.1 * by_area, "variance {variance}, by area {by_area}");
}

/// The power of rays from each half, and the area as the mean of 1 / density.
#[test]
fn rays_of_a_bright_spot_have_its_power_and_the_density_that_they_state() {
    let (triangle, light) = lamp();
    let mut random = Random::new(101);
    let mut rays = Vec::new();
    for _ in 0..samples(SAMPLES) {
        let [side, a, b, c, d] = random.cube();
        let Some(ray) = light.sample_le(&BALL, &LeRandom { side, position: [a, b], direction: [c, d] }) else {
            continue;
        };
        let EmitterPoint::Surface { p, .. } = ray.end else { panic!("a point on a triangle") };
        let density = light.pdf_le(&BALL, &ray.end, ray.ray.direction).position;
        rays.push((p.as_dvec3(), f64::from(ray.power.mean()), density.recip()));
    }
    let estimate =
        |f: &dyn Fn(&(DVec3, f64, f64)) -> f64| rays.iter().map(f).collect::<Moments>().estimate().expect("samples");
    for right in [false, true] {
        let chosen = |p: DVec3| f64::from(u8::from((p.x > 0.0) == right));
        let power = mean_over(&light, &triangle, |p, l| chosen(p) * l) * PI * triangle.area();
        let area = mean_over(&light, &triangle, |p, _| chosen(p)) * triangle.area();
        let found = [estimate(&|(p, power, _)| chosen(*p) * power), estimate(&|(p, _, inverse)| chosen(*p) * inverse)];
        assert!(!differs(found[0], power, 4), "{:?} for the power {power}", found[0]);
        assert!(!differs(found[1], area, 4), "{:?} for the area {area}", found[1]);
    }
}

/// Points of light samples and of rays, in columns of the barycentric weights, against the density asked for there.
#[test]
fn points_on_a_textured_triangle_follow_their_density() {
    const CELLS: usize = 32; // twice as many as parts of the table, and a whole number of the grid
    let (triangle, light) = lamp();
    let Light::Area(area) = &light else { panic!("an area light") };
    let cell = |p: Vec3| {
        let [u, v] = triangle.barycentric(p).map(|x| ((x * CELLS as f64) as usize).min(CELLS - 1));
        CELLS * u + v
    };
    let mut expected = vec![0.0; CELLS * CELLS];
    for (i, j) in (0..GRID).flat_map(|i| (0..GRID - i).map(move |j| (i, j))) {
        for third in [1.0, 2.0].into_iter().filter(|&third| third < 2.0 || i + j < GRID - 1) {
            let p = triangle.point([i, j].map(|k| (k as f32 + third / 3.0) / GRID as f32)).0;
            let w = (p - AT.p).normalize();
            let cos = f64::from(w.dot(triangle.scaled_normal().normalize().as_vec3()).abs());
            let density = f64::from(area.pdf_li(AT.p, p, w).value()) * cos / f64::from(p.distance_squared(AT.p));
            expected[cell(p)] += density * triangle.area() / f64::from(GRID).powi(2);
        }
    }
    let total: f64 = expected.iter().sum();
    assert!((total - 1.0).abs() < 1e-4, "the density integrates to {total}"); // roundings of a million terms
    let mut random = Random::new(102);
    let mut observed = vec![vec![0.0; CELLS * CELLS]; 2];
    let n = samples(SAMPLES);
    for _ in 0..n {
        let [side, a, b, c, d] = random.cube();
        let ray = light.sample_le(&BALL, &LeRandom { side, position: [a, b], direction: [c, d] }).map(|ray| ray.end);
        let sample = light.sample_li(&AT, random.cube()).filter(|s| matches!(s.density, Density::Smooth(_)));
        for (counts, end) in observed.iter_mut().zip([ray, sample.map(|s| s.end)]) {
            let Some(EmitterPoint::Surface { p, .. }) = end else { panic!("the triangle is lit everywhere") };
            counts[cell(p)] += 1.0;
        }
    }
    let expected: Vec<f64> = expected.iter().map(|p| p * f64::from(n) / total).collect();
    let p = [p_value(&observed[0], &expected), p_value(&observed[1], &expected)];
    assert!(p.iter().all(|&p| p > sidak(2)), "{p:?}");
}
