//! Selection by the tree against sums over all lights.

use super::{Descent, LightTree, Reach};
use crate::geometry::Triangle;
use crate::light::{AreaLight, Emission, Light, LightSampleContext, PointLight, SpotLight};
use crate::sampling::lanes::uniform_sphere;
use crate::sampling::{Address, IndependentSampler, Sampler, Slot};
use crate::spectrum::Spectrum;
use crate::transport::ScatteringOutline;
use glam::Vec3;

/// Random numbers in a row.
struct Numbers(IndependentSampler, u32);

impl Numbers {
    fn new(key: u64) -> Self {
        Numbers(IndependentSampler::new(Address::new(key)), 0)
    }

    fn next(&mut self) -> f32 {
        self.1 += 1;
        self.0.u1(self.1, Slot::Film)
    }

    fn direction(&mut self) -> Vec3 {
        uniform_sphere([self.next(), self.next()]).into()
    }

    /// Returns a point in the cube of side 2.
    fn point(&mut self) -> Vec3 {
        Vec3::from([self.next(), self.next(), self.next()]) * 2.0 - 1.0
    }
}

/// Triangles from a thousandth to one in size, one- and two-sided, points, and spots.
fn lights(count: usize, numbers: &mut Numbers) -> Vec<Light> {
    let mut light = |i: usize| {
        let (p, strength) = (numbers.point(), 10.0f32.powf(numbers.next() * 8.0 - 4.0));
        let point = PointLight { position: p, intensity: Spectrum::splat(strength) };
        match i % 4 {
            0 => Light::Point(point),
            1 => {
                let outer = 0.01 + 1.5 * numbers.next();
                Light::Spot(SpotLight::new(point, numbers.direction(), outer * numbers.next(), outer))
            }
            sides => {
                let size = 10.0f32.powf(-3.0 * numbers.next());
                let triangle = Triangle::new(p, p + numbers.direction() * size, p + numbers.direction() * size);
                let two_sided = sides == 3;
                let emission = Emission { radiance: Spectrum::splat(strength), two_sided, ..Emission::NONE };
                Light::Area(AreaLight::new(triangle, 1.0, emission))
            }
        }
    };
    (0..count).map(&mut light).collect()
}

fn select(tree: &LightTree, at: &LightSampleContext, u: f64) -> (u32, f64) {
    let mut descent = Descent::new(u, 1.0);
    loop {
        tree.step(at, &mut descent);
        if let Some(light) = descent.light() {
            return (light, descent.pmf);
        }
    }
}

fn tree(lights: &[Light]) -> LightTree {
    LightTree::new(&lights.iter().map(Light::reach).collect::<Vec<Option<Reach>>>()).expect("lights that shine")
}

/// A receiver anywhere, some without a normal, and some very near a light.
fn receiver(lights: &[Light], i: usize, numbers: &mut Numbers) -> LightSampleContext {
    let ng = if i % 5 == 0 { Vec3::ZERO } else { numbers.direction() };
    let near = lights[i % lights.len()].bounds().expect("a place").center();
    let p = if i % 3 == 0 { near + numbers.direction() * 10.0f32.powf(-6.0 * numbers.next()) } else { numbers.point() };
    LightSampleContext::new(p, ng).scattering(outline(i, ng, numbers))
}

/// Scattering of every kind, mostly about a normal beside `ng`.
fn outline(i: usize, ng: Vec3, numbers: &mut Numbers) -> ScatteringOutline {
    if i % 4 == 0 {
        return ScatteringOutline::UNKNOWN;
    }
    let glossy = if i % 4 == 1 { 1.0 } else { numbers.next() };
    ScatteringOutline {
        n: (ng + numbers.direction() * 0.3).normalize(),
        wo: numbers.direction(),
        diffuse: 1.0 - glossy,
        glossy,
        alpha2: 10.0f32.powf(-8.0 * numbers.next()),
        transmits: ng == Vec3::ZERO || i % 3 == 0,
    }
}

/// Whether light along the unit vector `wi` can be scattered.
fn is_scattered(at: &LightSampleContext, wi: Vec3) -> bool {
    at.scattering.transmits || wi.dot(at.ng) * at.scattering.wo.dot(at.ng) > 0.0
}

#[test]
fn probabilities_of_all_lights_sum_to_one() {
    let mut numbers = Numbers::new(1);
    for count in [1, 2, 7, 8, 9, 64, 65, 1000] {
        let lights = lights(count, &mut numbers);
        let tree = tree(&lights);
        for i in 0..50 {
            let at = receiver(&lights, i, &mut numbers);
            let sum: f64 = (0..count).map(|light| tree.pmf(&at, light, 1.0)).sum();
            // Rounding of products and sums of a thousand numbers below 1.
            assert!((sum - 1.0).abs() < 1e-12, "{count} lights: {sum}");
        }
    }
}

#[test]
fn samples_have_the_bits_of_their_probability() {
    let mut numbers = Numbers::new(2);
    let lights = lights(500, &mut numbers);
    let tree = tree(&lights);
    for i in 0..2000 {
        let at = receiver(&lights, i, &mut numbers);
        let (light, pmf) = select(&tree, &at, f64::from(numbers.next()));
        assert_eq!(pmf.to_bits(), tree.pmf(&at, light as usize, 1.0).to_bits());
    }
}

/// Sampled frequencies against probabilities, by χ² at one in a million.
#[test]
fn lights_are_selected_as_often_as_their_probability_says() {
    const DRAWS: u32 = 1 << 16;
    let mut numbers = Numbers::new(3);
    let lights = lights(20, &mut numbers);
    let tree = tree(&lights);
    for i in 0..5 {
        let at = receiver(&lights, i, &mut numbers);
        let mut counts = [0u32; 20];
        for _ in 0..DRAWS {
            let (light, _) = select(&tree, &at, f64::from(numbers.next()));
            counts[light as usize] += 1;
        }
        let expected = |light: usize| tree.pmf(&at, light, 1.0) * f64::from(DRAWS);
        let cells: Vec<usize> = (0..20).filter(|&light| expected(light) >= 10.0).collect();
        let term = |&light: &usize| (f64::from(counts[light]) - expected(light)).powi(2) / expected(light);
        let chi2: f64 = cells.iter().map(term).sum();
        // χ² of 20 degrees of freedom exceeds 69 with probability 2e-7 (each test).
        assert!(chi2 < 69.0, "{chi2} in {} cells", cells.len());
        assert!((0..20).all(|light| expected(light) > 0.0 || counts[light] == 0));
    }
}

/// Wherever a light sample carries light, its light has a probability.
#[test]
fn lights_that_contribute_have_a_probability() {
    let mut numbers = Numbers::new(4);
    let lights = lights(300, &mut numbers);
    let tree = tree(&lights);
    let mut lit = 0;
    for i in 0..3000 {
        let at = receiver(&lights, i, &mut numbers);
        for k in 0..10 {
            let light = (i * 7 + k * 31) % lights.len();
            let u = [numbers.next(), numbers.next()];
            let Some(sample) = lights[light].sample_li(&at, u).filter(|sample| !sample.radiance.is_black()) else {
                continue;
            };
            if !is_scattered(&at, sample.wi) {
                continue;
            }
            lit += 1;
            assert!(tree.pmf(&at, light, 1.0) > 0.0, "light {light} at {at:?}: {sample:?}");
        }
    }
    assert!(lit > 10_000, "{lit}");
}

/// Lamps over a surface with a narrow lobe: knowing the lobe, the tree selects those that it mirrors. The relative second
/// moment of the scattered light is 1 if lights are selected by what they contribute.
#[test]
fn lights_in_the_lobe_of_the_receiver_are_preferred() {
    let lamp = |i: usize| {
        let position = Vec3::new((i % 40) as f32 - 20.0, (i / 40) as f32 - 5.0, 2.0);
        Light::Point(PointLight { position, intensity: Spectrum::ONE })
    };
    let lights: Vec<Light> = (0..400).map(lamp).collect();
    let tree = tree(&lights);
    let wo = Vec3::new(-0.9, 0.0, 0.3).normalize();
    for alpha in [0.03f32, 0.1, 0.3] {
        let (n, alpha2) = (Vec3::Z, alpha * alpha);
        let outline = ScatteringOutline { n, wo, diffuse: 0.0, glossy: 1.0, alpha2, transmits: false };
        let at = LightSampleContext::new(Vec3::ZERO, n);
        let scattered = |light: usize| {
            let to = lights[light].bounds().expect("a place").center();
            let (d2, wi) = (to.length_squared(), to.normalize());
            f64::from(outline.reflected(wi.into(), 0.0f32) / d2)
        };
        let sum: f64 = (0..400).map(scattered).sum();
        let moment = |at: &LightSampleContext| {
            (0..400).map(|light| scattered(light).powi(2) / tree.pmf(at, light, 1.0)).sum::<f64>() / (sum * sum)
        };
        let (known, unknown) = (moment(&at.scattering(outline)), moment(&at));
        assert!(known < 0.5 * unknown, "{alpha}: {known} {unknown}");
    }
}

/// A light a hundred times as near as others of its kind is chosen almost always; one that faces away, never.
#[test]
fn near_lights_are_preferred_and_those_that_face_away_are_not_chosen() {
    let lamp = |z: f32, up: bool| {
        let (a, b) = if up { (Vec3::X, Vec3::Y) } else { (Vec3::Y, Vec3::X) };
        let p = Vec3::new(0.0, 0.0, z);
        let emission = Emission { radiance: Spectrum::ONE, ..Emission::NONE };
        Light::Area(AreaLight::new(Triangle::new(p, p + a * 0.01, p + b * 0.01), 1.0, emission))
    };
    let lights: Vec<Light> =
        (1..=20).map(|i| lamp(i as f32, false)).chain([lamp(0.1, false), lamp(0.05, true)]).collect();
    let tree = tree(&lights);
    let at = LightSampleContext::new(Vec3::ZERO, Vec3::Z);
    assert!(tree.pmf(&at, 20, 1.0) > 0.9, "{}", tree.pmf(&at, 20, 1.0));
    assert_eq!(tree.pmf(&at, 21, 1.0), 0.0);
}

/// A million coincident lights, and lights of 1e30 beside 1e-30.
#[test]
fn hard_lights_have_a_tree() {
    let point = |position, strength| Light::Point(PointLight { position, intensity: Spectrum::splat(strength) });
    let same: Vec<Light> = (0..1_000_000).map(|_| point(Vec3::ONE, 1.0)).collect();
    let same = tree(&same);
    let at = LightSampleContext::new(Vec3::ZERO, Vec3::Z);
    let (light, pmf) = select(&same, &at, 0.123_456_789);
    assert!((0.5..2.0).contains(&(pmf * 1e6)), "light {light}: {pmf}");
    let uneven: Vec<Light> =
        (0..100).map(|i| point(Vec3::X * (1 + i) as f32, if i % 2 == 0 { 1e30 } else { 1e-30 })).collect();
    let uneven = tree(&uneven);
    let pmf: Vec<f64> = (0..100).map(|light| uneven.pmf(&at, light, 1.0)).collect();
    assert!(pmf.iter().all(|&pmf| pmf > 0.0) && (pmf.iter().sum::<f64>() - 1.0).abs() < 1e-12);
}

/// Each light that can reach the receiver is in one group of a cut, and is selected there with the bits of its
/// probability.
#[test]
fn cuts_hold_each_light_once() {
    let mut numbers = Numbers::new(11);
    let lights = lights(300, &mut numbers);
    let tree = tree(&lights);
    for i in 0..300 {
        let at = receiver(&lights, i, &mut numbers);
        for size in [1, 8, 30, 1000] {
            let cut = tree.cut(&at, size);
            assert!(cut.len() <= size, "{} groups of {size}", cut.len());
            let sum: f64 = (0..lights.len()).map(|light| tree.cut_pmf(&cut, &at, light)).sum();
            // Rounding of products and sums of hundreds of numbers below 1.
            assert!((sum - cut.len() as f64).abs() < 1e-10, "{sum} of {} groups", cut.len());
            for group in 0..cut.len() {
                let (light, pmf) = tree.sample_group(&cut, group, &at, f64::from(numbers.next()));
                assert_eq!(pmf.to_bits(), tree.cut_pmf(&cut, &at, light as usize).to_bits());
            }
        }
        let whole = tree.cut(&at, usize::MAX);
        for (light, _) in lights.iter().enumerate().filter(|(k, _)| tree.cut_pmf(&whole, &at, *k) == 0.0) {
            let u = [numbers.next(), numbers.next()];
            let sample = lights[light].sample_li(&at, u).filter(|sample| is_scattered(&at, sample.wi));
            assert!(sample.is_none(), "light {light} is in no group and lights {at:?}");
        }
    }
}

/// The bounds of a group hold for each of its lights.
#[test]
fn no_light_is_above_the_bound_of_a_group() {
    let mut numbers = Numbers::new(12);
    let points = |numbers: &mut Numbers| Reach {
        bounds: crate::geometry::Bounds::around([numbers.point()]),
        normals: super::Cone { axis: numbers.direction().as_dvec3(), angle: 0.0 },
        spread: std::f64::consts::FRAC_PI_2,
        two_sided: numbers.next() < 0.3,
        intensity: 1.0,
    };
    let reaches: Vec<Option<Reach>> = (0..200).map(|_| Some(points(&mut numbers))).collect();
    let tree = LightTree::new(&reaches).expect("lights");
    let mut closest = 0.0f64;
    for i in 0..2000 {
        let at = LightSampleContext::new(numbers.point() * 2.0, numbers.direction());
        let (diffuse, glossy) = if i % 2 == 0 { (1.0, 0.0) } else { (0.3, 0.7) };
        let exact = |light: usize| {
            let Reach { bounds, normals, two_sided, .. } = reaches[light].expect("a light");
            let to = bounds.center().as_dvec3() - at.p.as_dvec3();
            let (d2, wi) = (to.length_squared(), to.normalize());
            let cos = -wi.dot(normals.axis);
            let cos = if two_sided { cos.abs() } else { cos.max(0.0) };
            cos * (f64::from(diffuse) * wi.dot(at.ng.as_dvec3()).abs() + f64::from(glossy)) / d2
        };
        let most = tree.joined(exact, f64::max);
        let mut groups = vec![(super::LightGroup::ALL, f32::INFINITY)];
        while let Some((group, upper)) = groups.pop() {
            let value = most.of(group, exact);
            assert!(value <= f64::from(upper), "{group:?} for {at:?}: {value} > {upper}");
            closest = closest.max(if upper.is_finite() { value / f64::from(upper) } else { 0.0 });
            if group.light().is_none() {
                let parts: Vec<_> = tree.parts(group, &at, [diffuse, glossy]).collect();
                // A part that is left out has no light.
                let kept = parts.iter().map(|part| most.of(part.0, exact)).fold(0.0, f64::max);
                assert_eq!(kept, value, "a part of {group:?} is missing");
                groups.extend(parts);
            }
        }
    }
    assert!(closest > 0.9, "no bound is close: {closest}");
}

/// A light and three points of its plane: the corners of a triangle, or places around a point.
fn placed(kind: usize, numbers: &mut Numbers) -> (Light, [Vec3; 3]) {
    let size = 10.0f32.powf(-7.0 * numbers.next());
    let p = numbers.point();
    let corners = [p, p + numbers.direction() * size, p + numbers.direction() * size];
    let point = PointLight { position: p, intensity: Spectrum::ONE };
    let light = match kind % 4 {
        0 => Light::Point(point),
        1 => Light::Spot(SpotLight::new(point, numbers.direction(), 0.2, 1.0 + 0.57 * numbers.next())),
        sides => {
            let emission = Emission { radiance: Spectrum::ONE, two_sided: sides == 3, ..Emission::NONE };
            Light::Area(AreaLight::new(Triangle::new(corners[0], corners[1], corners[2]), 1.0, emission))
        }
    };
    (light, corners)
}

/// A receiver on a light, in its plane or hardly beside it.
fn touching_receiver([a, b, c]: [Vec3; 3], i: usize, numbers: &mut Numbers) -> LightSampleContext {
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let (s, t) = match i % 4 {
        0 => (0.0, 0.0),
        1 => (0.5 * numbers.next(), 0.5 * numbers.next()),
        _ => (20.0 * numbers.next() - 10.0, 20.0 * numbers.next() - 10.0),
    };
    let above = [0.0, 1e-7, -1e-7, 1e-5, -1e-5, 0.3 * (b - a).length()][i % 6];
    let ng = [Vec3::ZERO, normal, -normal, (b - a).normalize_or_zero(), numbers.direction()][i % 5];
    let p = a + (b - a) * s + (c - a) * t + normal * above;
    LightSampleContext::new(p, ng).scattering(outline(i, ng, numbers))
}

/// The same where cosines and distances vanish, for groups of any size and lights one in the other. A light that is
/// never selected never shines.
#[test]
fn lights_without_a_probability_never_shine() {
    let mut numbers = Numbers::new(6);
    let (mut dark, mut lit) = (0, 0);
    for round in 0..400 {
        let count = 1 + round % 60;
        let placed: Vec<(Light, [Vec3; 3])> = (0..count)
            .map(|i| placed(if round % 3 == 0 { 2 } else { i }, &mut numbers))
            .chain((0..2).map(|_| placed(round, &mut Numbers::new(round as u64))))
            .collect();
        let (lights, corners): (Vec<Light>, Vec<[Vec3; 3]>) = placed.into_iter().unzip();
        let tree = tree(&lights);
        for i in 0..60 {
            let at = touching_receiver(corners[(i * 7) % corners.len()], i, &mut numbers);
            for (light, number) in lights.iter().zip(0..) {
                let never = tree.pmf(&at, number, 1.0) == 0.0;
                let mut shines = |_| {
                    let sample = light.sample_li(&at, [numbers.next(), numbers.next()]);
                    sample.is_some_and(|sample| !sample.radiance.is_black() && is_scattered(&at, sample.wi))
                };
                let shone = (0..4).any(&mut shines);
                assert!(!(never && shone), "light {number} of round {round} at {at:?}");
                (dark, lit) = (dark + usize::from(never), lit + usize::from(shone));
            }
        }
    }
    assert!(dark > 100_000 && lit > 100_000, "{dark} {lit}");
}

/// Small numbers do not vanish: lights of 1e-30 beside 1e30, weak and far and seen along their plane.
#[test]
fn no_light_vanishes_beside_others() {
    let point =
        |x: f32, intensity| Light::Point(PointLight { position: Vec3::X * x, intensity: Spectrum::splat(intensity) });
    let at = LightSampleContext::new(Vec3::ZERO, Vec3::Z);
    for (far, strong, weak) in [(1.0, 1e30, 1e-30), (1e10, 1e30, 1e-30), (1e17, 1e4, 1.0), (1e17, 1.0, 1e-10)] {
        let lights: Vec<Light> =
            (0..40).map(|i| point(if i < 20 { 1.0 } else { far }, if i % 2 == 0 { strong } else { weak })).collect();
        let tree = tree(&lights);
        let pmf: Vec<f64> = (0..40).map(|light| tree.pmf(&at, light, 1.0)).collect();
        assert!(pmf.iter().all(|&pmf| pmf > 0.0) && (pmf.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{far} {pmf:?}");
    }
}

/// A star as a point, 1e8 away, that is as bright as the lamps nearby.
#[test]
fn a_strong_light_far_away_counts_by_its_irradiance() {
    let point = |position, intensity| Light::Point(PointLight { position, intensity: Spectrum::splat(intensity) });
    let lamps = (0..20).map(|i| point(Vec3::new(i as f32, 1.0, 0.0) * 1e-8, 20e-16));
    let lights: Vec<Light> = lamps.chain([point(Vec3::X, 1.0)]).collect();
    let tree = tree(&lights);
    let at = LightSampleContext::new(Vec3::ZERO, Vec3::ZERO);
    // The star gives 1, the nearest lamp 20 and all lamps twice as much: 1/42, and a factor of 4 for bounds of groups.
    let star = tree.pmf(&at, 20, 1.0);
    assert!((0.006..0.1).contains(&star), "{star}");
}
