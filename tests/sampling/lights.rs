//! What lights sample against the density that they state: χ² for triangles near and far and for the sky, the solid
//! angle for triangles seen edge-on and for needles, whose outline no quadrature resolves.

use etendue::geometry::Triangle;
use etendue::light::{AreaLight, ConstantEnvironment, Emission, Environment, Light, LightSampleContext};
use etendue::sampling::Density;
use etendue::spectrum::Spectrum;
use etendue_testing::chi_square::{SphereCells, p_value, sidak};
use etendue_testing::random::{Random, samples};
use glam::{DVec3, Vec3};
use statrs::distribution::{ContinuousCDF, Normal};

/// Absolute error of each cell's probability.
const TOLERANCE: f64 = 1e-6;
const SAMPLES: u32 = 40_000;

fn two_sided(vertices: [Vec3; 3]) -> (Triangle, Light) {
    let triangle = Triangle::new(vertices[0], vertices[1], vertices[2]);
    let emission = Emission {
        radiance: Spectrum::ONE,
        texture: None,
        corners: None,
        two_sided: true,
        only_seen: false,
        coverage: None,
    };
    (triangle, Light::Area(AreaLight::new(triangle, 1.0, emission)))
}

/// What `light` says of the unit direction `w` from the origin if it meets the triangle, by the plane and three edges.
fn density(triangle: &Triangle, light: &Light, w: DVec3) -> f64 {
    let [a, b, c] = triangle.vertices.map(Vec3::as_dvec3);
    let n = (b - a).cross(c - a);
    let p = w * (n.dot(a) / n.dot(w));
    let inside = [(a, b), (b, c), (c, a)].iter().all(|&(s, e)| (e - s).cross(p - s).dot(n) >= 0.0);
    let Light::Area(area) = light else { return 0.0 };
    let ahead = inside && p.dot(w) > 0.0;
    if ahead { f64::from(area.pdf_li(Vec3::ZERO, p.as_vec3(), w.as_vec3()).value()) } else { 0.0 }
}

/// p-value of directions from the origin to `light`, in cells around `axis` of width about `angle`.
fn follows(light: &Light, axis: DVec3, angle: f64, pdf: impl Fn(DVec3) -> f64, seed: u64) -> f64 {
    let cells = SphereCells::new(axis.normalize().to_array(), 0.25 * angle * angle);
    let mut expected = cells.integrate(TOLERANCE, &|w| pdf(DVec3::from(w)));
    let total: f64 = expected.iter().sum();
    assert!((total - 1.0).abs() < 2e-3, "the density integrates to {total}"); // jumps along edges are resolved to 2⁻⁸ of a cell
    expected.push(0.0);
    let (mut random, n) = (Random::new(seed), samples(SAMPLES));
    let mut observed = vec![0.0; expected.len()];
    let at = LightSampleContext::new(Vec3::ZERO, Vec3::Y);
    for _ in 0..n {
        let sample = light.sample_li(&at, random.cube());
        let cell = sample.map_or(cells.count(), |s| {
            let stated = if let Density::Smooth(pdf) = s.density { f64::from(pdf.value()) } else { 0.0 };
            let w = s.wi.as_dvec3();
            // Where a rounded direction still meets the light, it has the density that came with it.
            let again = pdf(w.normalize());
            assert!(again <= 0.0 || (again / stated - 1.0).abs() < 1e-2, "{stated} stated, {again} asked"); // edge-on: 6e-8 / cos
            cells.index(w.to_array())
        });
        observed[cell] += 1.0;
    }
    let expected: Vec<f64> = expected.iter().map(|p| p * f64::from(n) / total).collect();
    p_value(&observed, &expected)
}

type Named = (&'static str, [Vec3; 3]);

const FAR: Named = ("small and far", [Vec3::new(3.0, 9.0, 1.0), Vec3::new(3.1, 9.0, 1.0), Vec3::new(3.0, 9.02, 1.1)]);
const NEAR: Named = ("near", [Vec3::new(-2.0, 0.3, -1.0), Vec3::new(1.0, 0.5, -2.0), Vec3::new(0.5, 0.4, 3.0)]);
const EDGE_ON: Named =
    ("edge-on", [Vec3::new(1.0, 0.001, 0.0), Vec3::new(2.0, 0.002, 0.3), Vec3::new(2.0, 0.05, -0.3)]);
const NEEDLE: Named = ("a needle", [Vec3::new(-1.0, 1.0, 0.0), Vec3::new(1.0, 1.0, 0.0), Vec3::new(1.0, 1.0, 1e-5)]);

#[test]
fn directions_to_a_triangle_follow_its_density() {
    let test = |((name, vertices), seed): (Named, u64)| {
        let (triangle, light) = two_sided(vertices);
        let centre = vertices.iter().map(|v| v.as_dvec3()).sum::<DVec3>() / 3.0;
        let angle = vertices.iter().map(|v| v.as_dvec3().angle_between(centre)).fold(0.0, f64::max);
        (name, follows(&light, centre, angle, |w| density(&triangle, &light, w), seed))
    };
    let results = [FAR, NEAR].into_iter().zip(50..).map(test);
    let results: Vec<_> = results.collect();
    assert!(results.iter().all(|(_, p)| *p > sidak(results.len())), "{results:?}");
}

/// The solid angle of a triangle seen from the origin.
fn solid_angle(vertices: [Vec3; 3]) -> f64 {
    let [a, b, c] = vertices.map(|v| v.as_dvec3().normalize());
    2.0 * a.dot(b.cross(c)).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

/// The mean of 1 / density over samples is the solid angle, at the family's level; `factor` is planted.
fn measures_its_solid_angle(vertices: [Vec3; 3], factor: f64, tests: usize) -> Result<(), String> {
    let (_, light) = two_sided(vertices);
    let at = LightSampleContext::new(Vec3::ZERO, Vec3::Y);
    let (mut random, n) = (Random::new(70), f64::from(samples(SAMPLES)));
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..samples(SAMPLES) {
        let sample = light.sample_li(&at, random.cube()).ok_or("nothing sampled")?;
        let inverse = factor / f64::from(sample.density.value());
        sum += inverse;
        squares += inverse * inverse;
    }
    let (mean, exact) = (sum / n, solid_angle(vertices));
    let error = ((squares / n - mean * mean).max(0.0) / n).sqrt(); // constant by solid angle
    let limit = Normal::standard().inverse_cdf(1.0 - sidak(tests) / 2.0);
    // positions of the light's points are f32, against their distance and its height above the plane
    let rounding = 1e-4 * exact;
    let right = (mean - exact).abs() < limit * error + rounding;
    if right { Ok(()) } else { Err(format!("{mean} for {exact}, standard error {error:e}")) }
}

#[test]
fn samples_of_a_triangle_measure_its_solid_angle() {
    let all = [FAR, NEAR, EDGE_ON, NEEDLE];
    for (name, vertices) in all {
        measures_its_solid_angle(vertices, 1.0, all.len()).unwrap_or_else(|e| panic!("{name}: {e}"));
        for wrong in [0.95, 1.05] {
            assert!(measures_its_solid_angle(vertices, wrong, all.len()).is_err(), "{name}: {wrong} is not convicted");
        }
    }
}

/// Planted: without the cosine the density is not one.
#[test]
fn a_density_without_the_cosine_is_convicted() {
    let vertices = [Vec3::new(-2.0, 0.3, -1.0), Vec3::new(1.0, 0.5, -2.0), Vec3::new(0.5, 0.4, 3.0)];
    let (triangle, light) = two_sided(vertices);
    let normal = triangle.scaled_normal().normalize();
    let wrong = |w: DVec3| density(&triangle, &light, w) * normal.dot(w).abs();
    let p = std::panic::catch_unwind(|| follows(&light, DVec3::Y, 1.5, wrong, 1));
    assert!(p.is_err(), "such a density does not integrate to 1: {p:?}");
}

#[test]
fn directions_to_the_sky_follow_its_density() {
    let sky = ConstantEnvironment { radiance: Spectrum::ONE };
    let pdf = f64::from(sky.pdf().value());
    let p = follows(&Light::Environment(Environment::Uniform(sky)), DVec3::new(0.6, 0.0, 0.8), 2.0, |_| pdf, 60);
    assert!(p > sidak(1), "{p}");
}
