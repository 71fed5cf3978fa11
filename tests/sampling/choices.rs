//! Discrete choices against the probabilities that they state: tables, lights, Dirac lobes, roulette.

use crate::models::{Model, direction, models};
use etendue::bsdf::{Bsdf, Lobes};
use etendue::geometry::{Local, Ray};
use etendue::light::{ChosenLight, Light, LightChoice, LightSampleContext, Lights, PointLight};
use etendue::path::{PreviousVertex, RandomWalk, TraceStats};
use etendue::sampling::{Address, Density, Distribution, IndependentSampler};
use etendue::spectrum::Spectrum;
use etendue::transport::TransportMode;
use etendue_testing::chi_square::{p_value, sidak};
use etendue_testing::random::{Random, samples};
use etendue_testing::worlds::{self, World};
use glam::Vec3;

const SAMPLES: u32 = 100_000;
/// Cells for the number that is left over.
const REST: usize = 16;

/// Zeros at both ends and inside, weights that differ by 1e5, many equal ones.
fn tables() -> [Vec<f64>; 4] {
    let many = (0..200).map(|i| f64::from(i % 7)).collect();
    [vec![1.0], vec![0.0, 3.0, 0.0, 1.0, 0.0], vec![1e-2, 1e3, 2.0, 0.0, 50.0], many]
}

fn counted(n: u32, cells: usize, seed: u64, choose: impl Fn(f32) -> usize) -> Vec<f64> {
    let (mut random, mut observed) = (Random::new(seed), vec![0.0; cells]);
    (0..n).for_each(|_| observed[choose(random.f32())] += 1.0);
    observed
}

#[test]
fn tables_choose_with_the_probabilities_that_they_state() {
    let n = samples(SAMPLES);
    let mut results = Vec::new();
    for (weights, seed) in tables().into_iter().zip(200..) {
        let table = Distribution::new(weights.iter().copied()).expect("positive weights");
        let total: f64 = weights.iter().sum();
        for (i, weight) in weights.iter().enumerate() {
            // a difference of f32 numbers up to 1
            assert!(
                (f64::from(table.pmf(i).value()) - weight / total).abs() < 2.0 * f64::from(f32::EPSILON),
                "{i} of {weights:?}"
            );
        }
        let observed = counted(n, weights.len(), seed, |u| table.sample(u).0);
        assert!(observed.iter().zip(&weights).all(|(o, w)| *w > 0.0 || *o <= 0.0), "a weight of zero was chosen");
        let expected: Vec<f64> = weights.iter().map(|w| w / total * f64::from(n)).collect();
        results.push(p_value(&observed, &expected));
        // What is left of the number is uniform in every interval.
        let cell = |u: f32| {
            let (i, _, rest) = table.sample_lanes::<f32>(u);
            let i = i as usize;
            assert!((0.0..1.0).contains(&rest));
            i * REST + (rest * REST as f32) as usize
        };
        let observed = counted(n, weights.len() * REST, seed + 50, cell);
        let expected: Vec<f64> = expected.iter().flat_map(|e| [e / REST as f64; REST]).collect();
        results.push(p_value(&observed, &expected));
    }
    assert!(results.iter().all(|&p| p > sidak(results.len())), "{results:?}");
    // Planted: a table that takes its first index twice as often.
    let table = Distribution::new([2.0, 3.0, 5.0]).expect("positive weights");
    let observed = counted(n, 3, 300, |u| table.sample(u).0);
    assert!(p_value(&observed, &[1.0, 3.0, 5.0].map(|w| w / 9.0 * f64::from(n))) < sidak(1));
}

/// Few lights, which are chosen by the first number of their point, and many. What is left of this number is uniform
/// for every light.
#[test]
fn lights_are_chosen_with_the_probability_that_is_asked_for_later() {
    let lamp = |i: f32| Light::Point(PointLight { position: Vec3::X * i, intensity: Spectrum::splat(i) });
    let at = LightSampleContext::new(Vec3::ZERO, Vec3::Y);
    let n = samples(SAMPLES);
    let mut results = Vec::new();
    for copies in [1, 3] {
        let lamps = [1.0, 0.0, 20.0, 3.0, 1e-3].repeat(copies);
        let lights = Lights::new(lamps.iter().copied().map(lamp).collect(), 1.0, LightChoice::Power);
        let (mut random, mut observed) = (Random::new(210), vec![0.0; lamps.len() * REST]);
        for _ in 0..n {
            let u: [f32; 3] = random.cube();
            let ChosenLight { index, pmf, u } = lights.choose(&at, [u[0], u[1]], || u[2]).expect("lights");
            assert_eq!(pmf, lights.pmf(&at, index));
            assert!(lamps[index] > 0.0, "a dark light was chosen");
            observed[index * REST + (u[0] * REST as f32) as usize] += 1.0;
        }
        let share = |i: usize| f64::from(lights.pmf(&at, i / REST).value()) / REST as f64 * f64::from(n);
        results.push(p_value(&observed, &(0..observed.len()).map(share).collect::<Vec<_>>()));
    }
    assert!(results.iter().all(|&p| p > sidak(results.len())), "{results:?}");
}

/// A lobe and the probability that it states; a mixture may mirror by its layer and by its glass, each with its own.
type Dirac = (Lobes, f32);

/// How often each Dirac lobe was drawn at `known`, how often a smooth one, and how often nothing.
fn drawn(model: &Model, known: Local, mode: TransportMode, n: u32, seed: u64) -> (Vec<(Dirac, f64)>, [f64; 2]) {
    let (mut random, mut dirac, mut rest) = (Random::new(seed), Vec::<(Dirac, f64)>::new(), [0.0; 2]);
    for _ in 0..n {
        match model.surface.sample(known, mode, random.cube()) {
            None => rest[1] += 1.0,
            Some(sample) => match sample.density {
                Density::Smooth(_) => rest[0] += 1.0,
                Density::Delta(p) => {
                    assert_eq!(
                        sample.lobe == Lobes::DIRAC_REFLECT,
                        known.same_side(sample.direction),
                        "{}",
                        model.name
                    );
                    match dirac.iter_mut().find(|(key, _)| *key == (sample.lobe, p)) {
                        Some((_, count)) => *count += 1.0,
                        None => dirac.push(((sample.lobe, p), 1.0)),
                    }
                }
            },
        }
    }
    (dirac, rest)
}

/// ∫ of the density over all directions, which here depends on the cosine alone and is linear in it: the midpoint rule.
fn smooth_share(model: &Model, known: Local, mode: TransportMode) -> f64 {
    const POINTS: u32 = 256;
    let cosine = |i: u32| (2.0 * f64::from(i) + 1.0) / f64::from(POINTS) - 1.0;
    let pdf = |z: f64| model.surface.pdf(known.cast(), Local::new((1.0 - z * z).sqrt(), 0.0, z), mode, Lobes::SMOOTH);
    std::f64::consts::TAU * 2.0 / f64::from(POINTS) * (0..POINTS).map(|i| pdf(cosine(i))).sum::<f64>()
}

/// Dirac lobes have the probability that comes with their samples, and what is left of 1 is the smooth lobes' integral.
#[test]
fn smooth_faces_choose_their_lobes_as_stated() {
    let n = samples(SAMPLES / 10);
    let mut results = Vec::new();
    for (i, model) in models(0.0).iter().enumerate() {
        for (j, cos) in [0.9, 0.5, 0.01, 1e-4, -0.7, -0.01].into_iter().enumerate() {
            let known = direction(cos, 0.7);
            for mode in [TransportMode::Radiance, TransportMode::Importance] {
                let seed = (i * 100 + j) as u64 + 1000 * (mode == TransportMode::Importance) as u64;
                let (dirac, rest) = drawn(model, known, mode, n, seed);
                let smooth = smooth_share(model, known, mode);
                let mut expected: Vec<f64> = dirac.iter().map(|((_, p), _)| f64::from(*p)).collect();
                expected.push(smooth);
                let total: f64 = expected.iter().sum();
                // the midpoint rule's error, and f32 probabilities
                assert!(total < 1.0 + 1e-6, "{} cos {cos}: {dirac:?} and {smooth}", model.name);
                expected.push((1.0 - total).max(0.0));
                expected.iter_mut().for_each(|p| *p *= f64::from(n));
                let observed: Vec<f64> = dirac.iter().map(|(_, count)| *count).chain(rest).collect();
                results.push((
                    p_value(&observed, &expected),
                    format!("{} cos {cos} {observed:?} {expected:?}", model.name),
                ));
            }
        }
    }
    let level = sidak(results.len());
    let failed: Vec<_> = results.into_iter().filter(|(p, _)| *p < level).collect();
    assert!(failed.is_empty(), "{failed:#?}");
}

/// What survives roulette is scaled by the inverse of the share that does: of walks that have lost most of their
/// throughput, and of long ones that have lost nothing.
#[test]
fn survivors_of_roulette_make_up_for_the_others() {
    let [World { scene, .. }, ..] = worlds::all();
    let n = samples(SAMPLES);
    let mut results = Vec::new();
    for (beta, scale, depth) in [(0.01, 1.0, 5), (2e-3, 40.0, 5), (1.0, 1.0, 300), (0.3, 1.0, 1000), (1.0, 1.0, 200)] {
        let (mut survivors, mut scaled) = (0u32, beta);
        for i in 0..n {
            let ray = Ray::new(Vec3::ZERO, Vec3::X);
            let beta = Spectrum::splat(beta);
            let mut walk = RandomWalk::resumed(&scene, ray, beta, PreviousVertex::Camera, depth, (false, scale));
            let mut sampler = IndependentSampler::new(Address::new(900).with(u64::from(i)));
            if walk.survives(&mut sampler, &mut TraceStats::default()) {
                (survivors, scaled) = (survivors + 1, walk.beta.mean());
            }
        }
        let (survivors, share) = (f64::from(survivors), f64::from(beta / scaled));
        if share >= 1.0 {
            assert_eq!(survivors, f64::from(n), "unscaled survivors of {beta} at event {depth}");
            continue;
        }
        let observed = [survivors, f64::from(n) - survivors];
        results.push(p_value(&observed, &[share, 1.0 - share].map(|p| p * f64::from(n))));
    }
    assert_eq!(results.len(), 4, "roulette of four kinds of walks");
    assert!(results.iter().all(|&p| p > sidak(results.len())), "{results:?}");
}
