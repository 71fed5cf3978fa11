//! Tests of the verdict on images with known means.

use super::*;
use crate::film::Crop;
use crate::lab::compare::side::Origin;
use crate::stats::test_random::Random;

const SIZE: [usize; 2] = [32, 24];
const SPP: u64 = 64;
const REPLICATES: usize = 4;

fn side(name: &str, seed: u64, colors: Vec<f32>, errors: Option<Vec<f32>>) -> Side {
    let origin = Origin {
        path: name.into(),
        method: Some("path".into()),
        spp: Some(SPP),
        seed: Some(seed),
        replicates: errors.as_ref().map(|_| REPLICATES as u64),
        scene: None,
        settings: None,
        relmse: None,
        pixel_hash: String::new(),
        hash_matches: None,
    };
    let size = SIZE.map(|s| s as u32);
    Side { origin, size, crop: Crop { x0: 0, y0: 0, x1: size[0], y1: size[1] }, colors, errors, record: None }
}

/// An image of exponential samples with mean `mean(i, c)` at pixel i and channel c, with its standard errors.
fn render(seed: u64, mean: impl Fn(usize, usize) -> f64) -> Side {
    let mut random = Random::new(seed);
    let mut replicate = || (0..16).map(|_| random.exponential()).sum::<f64>() / 16.0;
    let pixel = |i: usize| {
        let replicates: [f64; REPLICATES] = std::array::from_fn(|_| replicate() * mean(i / 3, i % 3));
        let m = replicates.iter().sum::<f64>() / 4.0;
        let variance = replicates.iter().map(|r| (r - m) * (r - m)).sum::<f64>() / 12.0;
        (m as f32, variance.sqrt() as f32)
    };
    let (colors, errors) = (0..3 * SIZE[0] * SIZE[1]).map(pixel).unzip();
    side("image", seed, colors, Some(errors))
}

fn verdict(image: Side, reference: Side, level: f64) -> Verdict {
    Verdict::of(&ImagePair::of(image, reference), level)
}

fn plain(i: usize, c: usize) -> f64 {
    0.1 + 0.01 * (i % 7) as f64 + c as f64
}

/// The false-rejection rate at level 5 % is at most 5 %, since Holm's method is exact or conservative. One-sided
/// binomial test of 400 trials at level 1e-6 (4.75 σ).
#[test]
fn equal_means_are_not_rejected() {
    let trials: u64 = 400;
    let differ =
        |k: &u64| verdict(render(2 * k, plain), render(2 * k + 1, plain), 0.05).outcome == CompareOutcome::Differ;
    let rejected = (0..trials).filter(differ).count() as f64;
    let n = trials as f64;
    assert!(rejected < 0.05 * n + 4.75 * (n * 0.05 * 0.95).sqrt(), "{rejected}");
    assert!(rejected > 0.0, "a test that never rejects tests nothing: at 5 % this has a chance below 1e-8");
}

/// A pixel's relative error is 1/8. The error of a difference is thus 2.2 % for tiles and 0.6 % for images. A channel
/// that is 5 % too bright deviates by 2 standard errors of a tile and 8 of the image. A tile that is 20 % too bright
/// deviates by 8 of its own. 39 tests at 1e-3 reject beyond 4.2.
#[test]
fn different_means_are_rejected_and_located() {
    let global = verdict(render(1, |i, c| plain(i, c) * if c == 1 { 1.05 } else { 1.0 }), render(2, plain), 1e-3);
    assert_eq!(global.outcome, CompareOutcome::Differ);
    let worst = &global.rejections[0];
    assert!(worst.channel == "G" && worst.tile.is_none() && worst.difference > 0.0, "{worst:?}");
    assert!(global.means[1].interval[0] > 0.0 && global.sentence().contains("differ at level 0.001"));
    let spot = |i: usize, c: usize| {
        plain(i, c) * if (8..16).contains(&(i % 32)) && (16..24).contains(&(i / 32)) { 1.2 } else { 1.0 }
    };
    let local = verdict(render(3, spot), render(4, plain), 1e-3);
    assert_eq!((local.outcome, local.tile), (CompareOutcome::Differ, 8));
    assert_eq!(local.rejections[0].tile, Some([8, 16]), "{local:?}");
}

/// A single firefly that dominates a tile's error does not make the tile differ. A differing tile without noise does.
#[test]
fn fireflies_are_not_rejected_and_exact_tiles_are() {
    let mut image = render(5, plain);
    image.colors[300] += 1000.0;
    image.errors.as_mut().unwrap()[300] = 1000.0;
    assert_eq!(verdict(image, render(6, plain), 1e-3).outcome, CompareOutcome::NoDifference);
    let exact = |value: f32, seed| {
        let n = 3 * SIZE[0] * SIZE[1];
        side("exact", seed, vec![value; n], Some(vec![0.0; n]))
    };
    assert_eq!(verdict(exact(1.0, 7), exact(1.001, 8), 1e-3).outcome, CompareOutcome::Differ);
    // A difference of one ulp is rounding.
    assert_eq!(verdict(exact(1.0, 7), exact(1.0 + f32::EPSILON, 8), 1e-3).outcome, CompareOutcome::NoDifference);
}

#[test]
fn equal_seeds_or_missing_standard_errors_are_untested() {
    let same = verdict(render(9, plain), render(9, |i, c| plain(i, c) * 2.0), 1e-3);
    assert!(same.outcome == CompareOutcome::Untested && same.sentence().contains("both have seed 9"), "{same:?}");
    let colors = render(10, plain).colors;
    let bare = verdict(render(11, plain), side("bare.exr", 12, colors, None), 1e-3);
    assert!(
        bare.outcome == CompareOutcome::Untested && bare.sentence().contains("bare.exr has no standard errors"),
        "{bare:?}"
    );
    let mut foreign = render(13, plain);
    foreign.origin.replicates = None;
    assert!(verdict(foreign, render(14, plain), 1e-3).sentence().contains("has no number of replicates"));
    assert_eq!(verdict(render(15, plain), render(15, plain), 1e-3).outcome, CompareOutcome::Identical);
}

#[test]
fn non_finite_pixels_are_left_out() {
    let mut image = render(16, plain);
    image.colors[0] = f32::NAN;
    image.errors.as_mut().unwrap()[5] = f32::INFINITY;
    let verdict_ = verdict(image, render(17, plain), 1e-3);
    assert_eq!((verdict_.outcome, verdict_.pixels_left_out), (CompareOutcome::NoDifference, 2));
    let mut nothing = render(18, plain);
    nothing.colors.fill(f32::NAN);
    assert_eq!(verdict(nothing, render(19, plain), 1e-3).outcome, CompareOutcome::Untested);
}

/// If the pixels of a method are not independent, pixel errors are insufficient. Of unknown methods nothing is known.
#[test]
fn correlated_pixels_are_tested_by_their_record() {
    let with = |method: &str, seed| {
        let mut side = render(seed, plain);
        side.origin.method = Some(method.into());
        side
    };
    for method in ["bdpt", "light", "mlt", "mmlt", "pssmlt"] {
        let found = verdict(with(method, 20), with(method, 21), 1e-3);
        assert!(found.outcome == CompareOutcome::Untested && found.sentence().contains("no sound record"), "{found:?}");
    }
    let found = verdict(with("photons", 20), render(21, plain), 1e-3);
    assert!(found.outcome == CompareOutcome::Untested && found.sentence().contains("no known method"), "{found:?}");
    let mut few = render(22, plain);
    few.origin.replicates = Some(2);
    let found = verdict(few, render(23, plain), 1e-3);
    assert!(found.outcome == CompareOutcome::Untested && found.sentence().contains("has 2 replicates"), "{found:?}");
}
