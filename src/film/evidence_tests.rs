use super::*;
use crate::film::{Independent, Layout, PassFilm, Prior, Units};
use crate::stats::pareto::UNTRUSTED_SHAPE;
use crate::stats::test_random::Random;
use rayon::prelude::*;

const SIDE: u32 = 16;

fn film(passes: u64, seed: u64, draw: impl Fn(&mut Random) -> f64) -> Film {
    let layout = Layout::new(SIDE, SIDE, None, &[]);
    let mut film = Film::new(layout.clone(), 4, seed, Units::from_exponents(-24, 0).unwrap());
    let (mut random, mut pass) = (Random::new(seed), PassFilm::new(&layout));
    for k in 0..passes {
        let values: Vec<f32> = (0..layout.pixels()).map(|_| draw(&mut random) as f32).collect();
        pass.par_chunks(1).for_each(|(p, out)| out.fill(values[p]));
        film.commit(k, &pass);
    }
    film
}

/// Returns how many of 40 films are trusted, and how many of these intervals cover relMSE, given the samples' true mean
/// and variance.
fn trusted(passes: u64, mean: f64, variance: f64, known: Known, draw: fn(&mut Random) -> f64) -> [usize; 2] {
    let expected = variance / passes as f64 / (1.01 * mean * mean);
    let errors = (0..40).map(|seed| film(passes, 700 + seed, draw).image_error(known).unwrap());
    let trusted: Vec<_> = errors.filter(|error| error.trust.trusted).collect();
    let holds = trusted.iter().filter(|e| (e.relmse.low..=e.relmse.high).contains(&expected)).count();
    [trusted.len(), holds]
}

fn nothing_known() -> Known {
    Independent::Pixels.into()
}

/// Uniform and exponential samples: nearly all are trusted, and their intervals cover (8 or more misses of 40 at 95 %:
/// P < 1e-3).
#[test]
fn light_tails_are_trusted() {
    for (mean, variance, draw) in [
        (0.5, 1.0 / 12.0, (|r: &mut Random| r.uniform()) as fn(&mut Random) -> f64),
        (1.0, 1.0, |r: &mut Random| r.exponential()),
    ] {
        let [trusted, holds] = trusted(64, mean, variance, nothing_known(), draw);
        assert!(trusted >= 36 && holds + 7 >= trusted, "{trusted} {holds}");
    }
}

/// u^(−k) has tail shape k: at .1 most films are trusted, at .6 few and at .9 (infinite variance) none.
#[test]
fn heavy_tails_are_not_trusted() {
    let pareto = |k: f64| move |r: &mut Random| (1.0 - r.uniform()).powf(-k);
    let error = |k: f64, seed: u64| film(64, 900 + seed, pareto(k)).image_error(nothing_known()).unwrap();
    let count = |k: f64| (0..40).filter(|&seed| error(k, seed).trust.trusted).count();
    let (light, middle, heavy) = (count(0.1), count(0.6), count(0.9));
    println!("trusted at .1: {light}, at .6: {middle}, at .9: {heavy}");
    assert!(light >= 34 && middle <= 8 && heavy == 0, "{light} {middle} {heavy}");
}

/// The estimate of a shape of .6 is mostly below the limit, its upper confidence limit is not.
#[test]
fn tail_shape_is_judged_by_its_upper_confidence_limit() {
    let error =
        |seed: u64| film(64, 900 + seed, |r| (1.0 - r.uniform()).powf(-0.6)).image_error(nothing_known()).unwrap();
    let reasons = |seed| error(seed).trust.reasons.iter().any(|d| d.reason == Reason::HeavyTail);
    let estimates = (0..40).filter(|&seed| error(seed).tail.unwrap().shape <= UNTRUSTED_SHAPE).count();
    let limits = (0..40).filter(|&seed| reasons(seed)).count();
    assert!(estimates >= 20 && limits >= 30, "{estimates} {limits}");
}

/// One sample in 10,000 contributes half of the mean. Films with such samples are rejected because of them, films
/// without by prior knowledge: the verdict does not depend on chance.
#[test]
fn known_rare_paths_make_the_interval_untrusted() {
    let draw = |r: &mut Random| if r.uniform() < 1e-4 { 5000.0 } else { 0.75 + 0.5 * r.uniform() };
    let prior = Prior { blind: false, rare_radiance: 5000.0 };
    let known = Known { independent: Independent::Pixels, prior };
    for passes in [8, 16, 64] {
        let errors: Vec<_> = (0..40).map(|seed| film(passes, 300 + seed, draw).image_error(known).unwrap()).collect();
        let lucky = errors.iter().filter(|e| e.largest.is_some_and(|largest| largest.value < 2.0)).count();
        let trusted = errors.iter().filter(|e| e.trust.trusted).count();
        println!("{passes}: {lucky} met none, {trusted} trusted");
        assert_eq!(trusted, 0, "{passes}");
    }
}

/// The true mean exceeds that of the samples by at most the bound on unseen samples, with error probability 5 %: 20 or
/// more exceptions in 200 films have a probability of .002.
#[test]
fn unseen_rare_paths_are_bounded() {
    let lottery = |r: &mut Random| if r.uniform() < 1e-4 { 5000.0 } else { 0.75 + 0.5 * r.uniform() };
    let pareto = |r: &mut Random| (1.0 - r.uniform()).powf(-0.8);
    let prior = Prior { blind: false, rare_radiance: 5000.0 };
    let known = |prior: Prior| Known { independent: Independent::Pixels, prior };
    for (mean, known, draw) in
        [(1.5, known(prior), &lottery as &dyn Fn(&mut Random) -> f64), (5.0, known(Prior::default()), &pareto)]
    {
        let pixels = (SIDE * SIDE) as usize;
        let errors = (0..200).map(|seed| film(8, 5000 + seed, draw).image_error(known).unwrap());
        let beyond = errors.filter(|e| e.mean * (1.0 + e.unseen_share(pixels, 0.05)) < mean).count();
        assert!(beyond < 20, "{beyond}");
    }
}

/// Events that are rare per pixel are frequent in a large image: after enough samples without one, their possible
/// contribution is small relative to the error.
#[test]
fn enough_samples_without_rare_paths_are_trusted() {
    let draw = |r: &mut Random| r.exponential();
    let known =
        |rare_radiance| Known { independent: Independent::Pixels, prior: Prior { blind: false, rare_radiance } };
    let relmse = 1.0 / 256.0 / 1.01;
    let limit = (MOST_RARE * relmse * 256.0 / 3.0).sqrt() * 256.0;
    let film = film(256, 5, draw);
    assert!(film.image_error(known(0.8 * limit)).unwrap().trust.trusted);
    let refused = film.image_error(known(1.25 * limit)).unwrap();
    assert_eq!(refused.trust.reasons.iter().map(|d| d.reason).collect::<Vec<_>>(), [Reason::RarePaths]);
}

#[test]
fn blind_method_is_untrusted_with_its_reason_in_json() {
    let prior = Prior { blind: true, rare_radiance: f64::INFINITY };
    let error = film(16, 1, |r| r.uniform()).image_error(Known { independent: Independent::Blocks, prior }).unwrap();
    let json = serde_json::json!(error);
    assert_eq!(json["trusted"], false);
    assert_eq!(json["reasons"][0], serde_json::json!({ "reason": "blind-method", "value": 1.0, "limit": 0.0 }));
    assert_eq!(json["reasons"][1]["reason"], "rare-paths");
    let back: crate::film::ImageError = serde_json::from_value(json).unwrap();
    assert!(back.trust == error.trust && back.trust.why_not() == Some(Reason::BlindMethod.sentence()));
}
