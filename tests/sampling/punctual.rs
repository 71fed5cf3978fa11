//! Point, spot and directional lights: nothing about them is random, so every sample is the closed form.

use etendue::light::{DirectionalLight, EmitterPoint, Light, LightSampleContext, PointLight, SpotLight};
use etendue::sampling::Density;
use etendue::spectrum::Spectrum;
use etendue_testing::random::{Random, samples};
use glam::{DVec3, Vec3};

/// Roundings of a difference, two squares, a root and quotients; the ramp's square multiplies what its cosine is off.
const ROUNDING: f64 = 32.0 * f32::EPSILON as f64;

fn somewhere(random: &mut Random) -> Vec3 {
    let [x, y, z] = random.cube().map(|u: f32| 4.0 * u - 2.0);
    Vec3::new(x, y, z)
}

fn at(p: Vec3) -> LightSampleContext {
    LightSampleContext::new(p, Vec3::Y)
}

/// Intensity over the square of the distance, from where the light is, whatever the random numbers are.
#[test]
fn a_point_light_has_no_variance() {
    let (mut random, light) =
        (Random::new(90), PointLight { position: Vec3::new(0.3, -0.2, 0.6), intensity: Spectrum([1.0, 2.0, 3.0]) });
    for _ in 0..samples(1000) {
        let p = somewhere(&mut random);
        let sample = Light::Point(light).sample_li(&at(p), random.cube()).expect("a point elsewhere");
        let to = light.position.as_dvec3() - p.as_dvec3();
        assert!((sample.wi.as_dvec3() - to.normalize()).length() < ROUNDING / to.length().min(1.0));
        assert!(
            (f64::from(sample.radiance[1]) * to.length_squared() / 2.0 - 1.0).abs() < ROUNDING / to.length().min(1.0)
        );
        assert!(
            sample.density == Density::Delta(1.0)
                && matches!(sample.end, EmitterPoint::Point(q) if q == light.position)
        );
    }
}

/// KHR_lights_punctual: saturate((cos − cos outer) / max(0.001, cos inner − cos outer))².
#[test]
fn a_spot_has_the_profile_of_the_specification() {
    let point = PointLight { position: Vec3::new(0.3, -0.2, 0.6), intensity: Spectrum::splat(2.0) };
    let axis = Vec3::new(0.2, -0.9, 0.4).normalize();
    let (mut random, mut seen) = (Random::new(91), [0; 3]);
    for [inner, outer] in [[0.2f32, 0.9], [0.0, 1.5], [0.7, 0.7]] {
        let spot = Light::Spot(SpotLight::new(point, axis, inner, outer));
        for _ in 0..samples(2000) {
            let p = somewhere(&mut random);
            let away: DVec3 = p.as_dvec3() - point.position.as_dvec3();
            let cos = away.normalize().dot(axis.as_dvec3());
            let [start, end] = [f64::from(inner).cos(), f64::from(outer).cos()];
            let ramp = (start - end).max(1e-3); // the specification's
            let x = ((cos - end) / ramp).clamp(0.0, 1.0);
            let expected = 2.0 * x * x / away.length_squared();
            let got = spot.sample_li(&at(p), random.cube()).map_or(0.0, |s| f64::from(s.radiance[0]));
            let slack = ROUNDING * (2.0 / ramp + 1.0) / away.length_squared() / away.length().min(1.0) * 2.0;
            assert!((got - expected).abs() < slack, "{inner} {outer} {p}: {got} {expected}");
            seen[if x <= 0.0 {
                0
            } else if x < 1.0 {
                1
            } else {
                2
            }] += 1;
        }
    }
    assert!(seen.iter().all(|&n| n > 100), "{seen:?}");
}

#[test]
fn parallel_light_is_the_same_everywhere() {
    let toward = Vec3::new(0.1, 0.7, -0.3).normalize();
    let light = Light::Directional(DirectionalLight { toward, irradiance: Spectrum([1.0, 2.0, 3.0]) });
    let mut random = Random::new(92);
    for _ in 0..samples(100) {
        let sample = light.sample_li(&at(somewhere(&mut random)), random.cube()).expect("light");
        assert_eq!((sample.wi, sample.radiance), (toward, Spectrum([1.0, 2.0, 3.0])));
        assert!(sample.density == Density::Delta(1.0) && matches!(sample.end, EmitterPoint::Distant));
    }
}
