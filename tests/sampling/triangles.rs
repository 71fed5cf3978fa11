//! Light samples of triangles by solid angle: irradiance against Lambert's formula from tiny to huge triangles, and the
//! same density in all that state it, across the switch between sampling by solid angle and by area.

use etendue::geometry::Triangle;
use etendue::light::{AreaLight, BoundingSphere, Emission, EmitterPoint, Light, LightSample, LightSampleContext};
use etendue::sampling::Density;
use etendue::spectrum::Spectrum;
use etendue::stats::{Estimate, Moments};
use etendue_testing::chi_square::sidak;
use etendue_testing::random::{Random, samples};
use glam::{DVec3, Vec3};
use statrs::distribution::{ContinuousCDF, Normal};

const BALL: BoundingSphere = BoundingSphere { centre: Vec3::ZERO, radius: 10.0 };
/// Half an ulp of 1.
const HALF_ULP: f64 = 0.5 * f32::EPSILON as f64;

fn light([a, b, c]: [Vec3; 3]) -> Light {
    let emission = Emission { radiance: Spectrum::ONE, two_sided: true, ..Emission::NONE };
    Light::Area(AreaLight::new(Triangle::new(a, b, c), 1.0, emission))
}

fn density(sample: &LightSample) -> f32 {
    let Density::Smooth(pdf) = sample.density else { panic!("a triangle has an extent") };
    pdf.value()
}

/// Irradiance at `p` with normal `n` under a triangle above the horizon that emits radiance 1 (Lambert 1760).
fn irradiance(vertices: [Vec3; 3], p: Vec3, n: DVec3) -> f64 {
    let w = vertices.map(|v| (v.as_dvec3() - p.as_dvec3()).normalize());
    let edge = |i: usize| {
        let (a, b) = (w[i], w[(i + 1) % 3]);
        let normal = a.cross(b);
        normal.length().atan2(a.dot(b)) * normal.normalize().dot(n)
    };
    (0..3).map(|i| 0.5 * edge(i)).sum::<f64>().abs()
}

const SAMPLES: u32 = 40_000;
/// A triangle of about unit size in the plane z = 0 and turned out of it by a little, which rounds.
const UNIT: [Vec3; 3] = [Vec3::new(0.1, 0.0, 0.01), Vec3::new(1.1, 0.1, -0.02), Vec3::new(0.0, 1.05, 0.03)];

/// A name, a receiver by the barycentric weights of its foot and its height, and the distance on the sphere from the
/// outline of the triangle to its centre: the least distance at which roundings count.
type Case = (&'static str, [f32; 2], f32);

const CASES: [Case; 7] = [
    ("of 5e-9 sr", [0.3, 0.3], 1e4),
    ("of 1e-6 sr", [0.3, 0.3], 700.0),
    ("far and oblique", [90.0, 20.0], 5.0),
    ("middle", [0.3, 0.3], 0.7),
    ("near", [0.3, 0.3], 0.03),
    ("nearly a hemisphere", [0.3, 0.3], 1e-4),
    ("near the outline", [0.5, 3e-3], 1e-3),
];

#[test]
fn irradiance_is_that_of_lambert_from_tiny_to_huge_triangles() {
    let (all, light) = (CASES.len(), light(UNIT));
    let [a, b, c] = UNIT.map(|v| v.as_dvec3());
    let n = (b - a).cross(c - a).normalize();
    for (seed, (name, foot, height)) in (80..).zip(CASES) {
        let [u, v] = foot.map(f64::from);
        let p = (a + (b - a) * u + (c - a) * v - n * f64::from(height)).as_vec3();
        let (mut random, at) = (Random::new(seed), LightSampleContext::new(p, n.as_vec3()));
        let moments: Moments = (0..samples(SAMPLES))
            .map(|_| {
                light.sample_li(&at, random.cube()).map_or(0.0, |s| s.wi.as_dvec3().dot(n) / f64::from(density(&s)))
            })
            .collect();
        let (exact, Estimate { value, standard_error, .. }) =
            (irradiance(UNIT, p, n), moments.estimate().expect("samples"));
        // Eight roundings against the height above the plane and the distance to the outline, in sizes of the triangle
        // seen: see the head of src/light/solid_angle.rs.
        let reach = a.distance(p.as_dvec3()).max(b.distance(p.as_dvec3()));
        let off_plane = n.dot(a - p.as_dvec3()).abs() / reach;
        let rounding = 8.0 * HALF_ULP / off_plane * exact;
        let limit = Normal::standard().inverse_cdf(1.0 - sidak(all) / 2.0) * standard_error + rounding;
        assert!((value - exact).abs() <= limit, "{name}: {value} for {exact}, within {limit}");
        // Uniform over the solid angle, only the receiver's cosine varies: its variance is at most a third of the square.
        let most = exact * (f64::from(samples(SAMPLES)) * 3.0).sqrt().recip();
        assert!(standard_error <= 1.05 * most, "{name}: {standard_error} is noisier than {most}"); // a hundredth by chance
    }
}

/// Random triangles and receivers: sizes and heights of eight and seven decades, so that both sides of the switch occur.
fn scene(random: &mut Random) -> ([Vec3; 3], Vec3) {
    let mut vector = || Vec3::from(random.cube::<3>().map(|x| 2.0 * x - 1.0));
    let vertices = [vector(), vector(), vector()];
    let [a, b, c] = vertices;
    let n = (b - a).cross(c - a).normalize_or_zero();
    let [u, v, height, side] = random.cube();
    let foot = if side < 0.5 { a + (b - a) * (0.5 * u) + (c - a) * (0.5 * v) } else { 4.0 * vector_of(random) };
    (vertices, foot + n * 10f32.powf(2.0 - 7.0 * height))
}

fn vector_of(random: &mut Random) -> Vec3 {
    Vec3::from(random.cube::<3>().map(|x| 2.0 * x - 1.0))
}

/// Both come from the same operations on the same numbers, so that they are equal; the density of the endpoint is the
/// product of five factors with a rounding each.
#[test]
fn all_state_the_density_of_a_sample_on_both_sides_of_the_switch() {
    let (mut random, mut by_area, mut by_angle) = (Random::new(90), 0, 0);
    for _ in 0..100_000 {
        let (vertices, p) = scene(&mut random);
        let light = light(vertices);
        let (Light::Area(area), at) = (&light, LightSampleContext::new(p, Vec3::Z)) else { panic!("an area light") };
        let Some(sample) = light.sample_li(&at, random.cube()) else { continue };
        let EmitterPoint::Surface { p: q, ng, .. } = sample.end else { panic!("a point on a triangle") };
        let stated = density(&sample);
        assert_eq!(area.pdf_li(p, q, sample.wi).value(), stated, "{vertices:?} from {p}");
        let position = light.pdf_le(&BALL, &sample.end, -sample.wi).position;
        let ratio = light.end_pdf_ratio(&at, &sample.end, sample.wi);
        let per_area = f64::from(stated) * f64::from(sample.wi.dot(ng).abs()) / f64::from(q.distance_squared(p));
        assert!((position * ratio / per_area - 1.0).abs() < 10.0 * HALF_ULP, "{vertices:?} from {p}: {ratio}");
        *(if ratio == 1.0 { &mut by_area } else { &mut by_angle }) += 1;
    }
    assert!(by_area > 1000 && by_angle > 10_000, "{by_area} by area, {by_angle} by solid angle");
}
