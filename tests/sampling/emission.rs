//! Rays that lights emit: they carry the light's power, and as much of it falls on a receiver as the receiver finds by
//! sampling the light.

use etendue::geometry::Triangle;
use etendue::light::{
    AreaLight, BoundingSphere, DirectionalLight, Emission, Environment, EnvironmentMap, LeRandom, Light,
};
use etendue::light::{ConstantEnvironment, LightSampleContext, PointLight, SpotLight};
use etendue::spectrum::Spectrum;
use etendue::stats::{Estimate, Moments};
use etendue::texture::RadianceMap;
use etendue_testing::chi_square::sidak;
use etendue_testing::random::{Random, samples};
use glam::Vec3;
use statrs::distribution::{ContinuousCDF, Normal};
use std::sync::Arc;

const SAMPLES: u32 = 100_000;
const BALL: BoundingSphere = BoundingSphere { centre: Vec3::new(0.1, -0.2, 0.3), radius: 1.0 };
/// A square within the ball that light falls on from above.
const HALF: f32 = 0.3;
const PATCH: f32 = -0.1;

fn lights() -> Vec<(&'static str, Light)> {
    let triangle = Triangle::new(Vec3::new(-0.2, 0.1, 0.5), Vec3::new(0.4, -0.1, 0.4), Vec3::new(0.1, 0.5, 0.6));
    let area = |two_sided: bool, winding: f64| {
        let emission = Emission {
            radiance: Spectrum([3.0, 2.0, 1.0]),
            texture: None,
            corners: None,
            two_sided,
            only_seen: false,
            coverage: None,
        };
        Light::Area(AreaLight::new(triangle, winding, emission))
    };
    let point = PointLight { position: Vec3::new(0.2, -0.1, 0.5), intensity: Spectrum([1.0, 2.0, 4.0]) };
    let spot = |inner, outer| Light::Spot(SpotLight::new(point, Vec3::new(-0.2, 0.1, -1.0).normalize(), inner, outer));
    let toward = Vec3::new(0.3, 0.2, 0.8).normalize();
    let mut random = Random::new(5);
    // All rows alike: the stated power of others is that of their density, which is linear in the height and not the
    // angle.
    let row: Vec<[f32; 3]> = (0..8).map(|_| random.cube()).collect();
    let texels = row.repeat(4);
    let map = EnvironmentMap::new(Arc::new(RadianceMap::new(8, 4, texels)), 2.0, 30.0).expect("a light");
    vec![
        ("downward triangle", area(false, -1.0)),
        ("upward triangle", area(false, 1.0)),
        ("two-sided triangle", area(true, 1.0)),
        ("point", Light::Point(point)),
        ("spot", spot(0.2, 0.6)),
        ("wide spot", spot(0.0, 1.5)),
        ("directional", Light::Directional(DirectionalLight { toward, irradiance: Spectrum([1.0, 0.5, 2.0]) })),
        ("sky", Light::Environment(Environment::Uniform(ConstantEnvironment { radiance: Spectrum([0.5, 0.7, 1.0]) }))),
        ("map", Light::Environment(Environment::Map(Box::new(map)))),
    ]
}

fn mean(mut one: impl FnMut() -> f64) -> Estimate {
    let all: Moments = (0..samples(SAMPLES)).map(|_| one()).collect();
    all.estimate().expect("samples")
}

/// Powers of emitted rays: of all, and of those that fall on the patch.
fn emitted(light: &Light, seed: u64) -> [Estimate; 2] {
    let ray = |random: &mut Random| {
        let [side, a, b, c, d] = random.cube();
        light.sample_le(&BALL, &LeRandom { side, position: [a, b], direction: [c, d] })
    };
    let falls = |r: &etendue::geometry::Ray| {
        let p = r.origin + r.direction * ((PATCH - r.origin.z) / r.direction.z);
        r.direction.z < 0.0 && r.origin.z > PATCH && p.x.abs() < HALF && p.y.abs() < HALF
    };
    let [mut all, mut some] = [Random::new(seed), Random::new(seed + 1)];
    [
        mean(|| ray(&mut all).map_or(0.0, |e| f64::from(e.power.mean()))),
        mean(|| ray(&mut some).filter(|e| falls(&e.ray)).map_or(0.0, |e| f64::from(e.power.mean()))),
    ]
}

/// What the patch receives by sampling the light from its points.
fn received(light: &Light, seed: u64) -> Estimate {
    let mut random = Random::new(seed);
    mean(|| {
        let [x, y, u, v] = random.cube();
        let at = LightSampleContext::new(Vec3::new((2.0 * x - 1.0) * HALF, (2.0 * y - 1.0) * HALF, PATCH), Vec3::Z);
        let Some(sample) = light.sample_li(&at, [u, v]) else { return 0.0 };
        f64::from(sample.radiance.mean() * sample.wi.z.max(0.0) / sample.density.value() * (2.0 * HALF).powi(2))
    })
}

/// Relative: a dozen roundings of each ray.
const ROUNDING: f64 = 16.0 * f32::EPSILON as f64;

fn agree(a: Estimate, b: Estimate, tests: usize) -> bool {
    let z = Normal::standard().inverse_cdf(1.0 - 0.5 * sidak(tests));
    (a.value - b.value).abs() <= z * a.standard_error.hypot(b.standard_error) + ROUNDING * a.value.abs()
}

#[test]
fn emitted_rays_carry_the_power_of_the_light_and_fall_where_it_is_seen() {
    let lights = lights();
    for (i, (name, light)) in (0..).zip(&lights) {
        let [all, fallen] = emitted(light, 3 * i);
        let stated = Estimate { value: light.power(BALL.radius), standard_error: 0.0, dof: f64::INFINITY };
        let found = received(light, 3 * i + 2);
        assert!(agree(all, stated, 2 * lights.len()), "{name}: {all:?} emitted, {stated:?} stated");
        assert!(agree(fallen, found, 2 * lights.len()), "{name}: {fallen:?} fell, {found:?} is found");
        // Planted: a fifth more; a patch in the dark has nothing to show.
        let more = Estimate { value: 1.2 * fallen.value, standard_error: 1.2 * fallen.standard_error, ..fallen };
        assert!(
            found.value == 0.0 && fallen.value == 0.0 || !agree(more, found, 1),
            "{name}: {more:?} is not told from {found:?}"
        );
    }
}

/// A ray leaves what it says that it leaves.
#[test]
fn emitted_rays_start_on_the_light() {
    let mut random = Random::new(9);
    for (name, light) in lights() {
        for _ in 0..samples(200) {
            let [side, a, b, c, d] = random.cube();
            let Some(e) = light.sample_le(&BALL, &LeRandom { side, position: [a, b], direction: [c, d] }) else {
                continue;
            };
            assert!((e.ray.direction.length() - 1.0).abs() < ROUNDING as f32, "{name}: {e:?}");
            let (start, slack) = match e.end {
                etendue::light::EmitterPoint::Surface { p, error, .. } => (p, 4.0 * error), // moved off the surface by √3 of it
                etendue::light::EmitterPoint::Point(p) => (p, 0.0),
                etendue::light::EmitterPoint::Distant => {
                    let (along, off) = (e.ray.direction.dot(BALL.centre - e.ray.origin), e.ray.origin - BALL.centre);
                    assert!((along - BALL.radius).abs() < 1e-5, "{name}: begins {along} before the middle"); // 80 half ulps
                    assert!(
                        off.reject_from(e.ray.direction).length() < BALL.radius * (1.0 + 1e-5),
                        "{name}: misses the scene"
                    );
                    (e.ray.origin, 0.0)
                }
            };
            assert!(e.ray.origin.distance(start) <= slack, "{name}: {e:?}");
        }
    }
}
