//! Coverage of intervals of relMSE with correlated pixels.

use super::*;
use crate::film::{Film, ImageError, Layout, PassFilm, Units};
use crate::stats::test_random::Random;
use rayon::prelude::*;

const SIDE: usize = 16;
const CHANNELS: usize = 3 * SIDE * SIDE;

/// Errors of the pixels of a replicate, channel by channel, with expectation 0 and equal variances.
type Draw = fn(&mut Random) -> Vec<f64>;

/// Independent pixels.
fn apart(random: &mut Random) -> Vec<f64> {
    (0..CHANNELS).map(|_| random.normal()).collect()
}

/// One value for each block of `side` × `side` pixels.
fn blobs(side: usize, mut draw: impl FnMut() -> f64) -> Vec<f64> {
    let across = SIDE.div_ceil(side);
    let values: Vec<f64> = (0..across * across).map(|_| draw()).collect();
    (0..CHANNELS).map(|i| i / 3).map(|p| values[p / SIDE / side * across + p % SIDE / side]).collect()
}

/// Correlated neighbours: blobs of 2 × 2 pixels, as from splats under a filter.
fn splats(random: &mut Random) -> Vec<f64> {
    blobs(2, || random.normal())
}

fn skewed_blobs(random: &mut Random) -> Vec<f64> {
    blobs(4, || random.exponential() - 1.0)
}

/// An event with probability 0.3 in each of 16 blobs.
fn rare_blobs(random: &mut Random) -> Vec<f64> {
    blobs(4, || f64::from(u8::from(random.uniform() < 0.3)) - 0.3)
}

/// Fully correlated pixels, as from the scale that a Metropolis method estimates once per image.
fn as_one(random: &mut Random) -> Vec<f64> {
    blobs(SIDE, || random.normal())
}

/// Independent pixels in replicates of different noise levels.
fn uneven(random: &mut Random) -> Vec<f64> {
    let scale = (0.25 * (0..4).map(|_| random.exponential()).sum::<f64>()).sqrt();
    apart(random).into_iter().map(|error| scale * error).collect()
}

/// Magnitude of the errors relative to the image, which is 1 everywhere: the bias from denominators, 3 v, stays below
/// 1e-3.
const SIZE: f64 = 0.01;

/// Returns the error of a film of one pass per replicate.
fn error(independent: Independent, replicates: u32, seed: u64, draw: Draw) -> ImageError {
    let layout = Layout::new(SIDE as u32, SIDE as u32, None, &[]);
    let mut film = Film::new(layout.clone(), replicates, seed, Units::from_exponents(-24, 0).unwrap());
    let (mut pass, mut random) = (PassFilm::new(&layout), Random::new(seed));
    for k in 0..u64::from(replicates) {
        let errors = draw(&mut random);
        pass.par_chunks(1).for_each(|(p, out)| {
            out.iter_mut().zip(&errors[3 * p..]).for_each(|(out, error)| *out = (1.0 + SIZE * error) as f32);
        });
        film.commit(k, &pass);
    }
    film.image_error(independent).unwrap()
}

/// Returns how many of `films` films have the mean relMSE over all of them in their interval, and the ratio of the
/// variance of their values to the estimated one.
fn covered(independent: Independent, replicates: u32, films: u64, draw: Draw) -> (f64, f64) {
    let seed = |i: u64| 77_000 + 1_000_000 * u64::from(replicates) + i;
    let errors: Vec<ImageError> =
        (0..films).into_par_iter().map(|i| error(independent, replicates, seed(i), draw)).collect();
    let values: Moments = errors.iter().map(|e| e.relmse.value).collect();
    let stated: Moments = errors.iter().map(|e| e.relmse.standard_error.powi(2)).collect();
    let holds = |e: &&ImageError| (e.relmse.low..=e.relmse.high).contains(&values.mean());
    (errors.iter().filter(holds).count() as f64, values.variance().unwrap() / stated.mean())
}

/// The interval covers in 93 to 97 % of films: two-sided binomial tests of the two rates at level 1e-3/30 (4.0 σ), for
/// at most thirty of them. The true value is the mean over the same films. With 600 films its error is a 24th of a
/// standard error: far less than 1 % of coverage.
#[track_caller]
fn holds(independent: Independent, replicates: u32, draw: Draw) {
    let films = 600.0_f64;
    let (hits, ratio) = covered(independent, replicates, films as u64, draw);
    println!("R = {replicates}: {:.1} %, variance over the stated one {ratio:.2}", 100.0 * hits / films);
    let sigma = |rate: f64| (films * rate * (1.0 - rate)).sqrt();
    assert!(hits > 0.93 * films - 4.0 * sigma(0.93), "too narrow: {hits} of {films}");
    assert!(hits < 0.97 * films + 4.0 * sigma(0.97), "too wide: {hits} of {films}");
}

#[test]
fn replicate_interval_covers_under_any_pixel_correlation() {
    for replicates in [8, 16] {
        for draw in [apart, splats, skewed_blobs, rare_blobs, as_one, uneven] {
            holds(Independent::Replicates, replicates, draw);
        }
    }
}

#[test]
fn block_interval_covers_under_neighbour_correlation() {
    for replicates in [4, 8] {
        for draw in [apart, splats] {
            holds(Independent::Blocks, replicates, draw);
        }
    }
}

/// Four replicates do not determine their own variance, and are reported as too few.
#[test]
fn fewer_than_eight_correlated_replicates_are_untrusted() {
    let trusted = |replicates| error(Independent::Replicates, replicates, 1, as_one).distrust().is_none();
    assert!(!trusted(2) && !trusted(4) && trusted(8) && trusted(16));
    assert!(error(Independent::Replicates, 2, 1, apart).relmse.high.is_infinite());
    assert!(error(Independent::Blocks, 4, 1, apart).distrust().is_none());
}

/// The closed form of pseudo-values equals leaving out one replicate at a time, to rounding.
#[test]
fn replicate_noise_matches_leave_one_out_jackknife() {
    let mut random = Random::new(5);
    let values: Vec<f64> = (0..16).map(|_| random.exponential()).collect();
    let variance = |values: &[f64]| values.iter().copied().collect::<Moments>().variance().unwrap();
    let without = |r: usize| [&values[..r], &values[r + 1..]].concat();
    let left_out: Vec<f64> = (0..16).map(|r| variance(&without(r))).collect();
    let expected = (15.0 * 15.0 / 16.0 * variance(&left_out)).sqrt();
    let mean = values.iter().sum::<f64>() / 16.0;
    let squares: Vec<f64> = values.iter().map(|v| (v - mean).powi(2)).collect();
    let found = Noise::between_replicates(&squares, variance(&values));
    assert!((found.standard_error / expected - 1.0).abs() < 1e-12, "sixteen sums of a few roundings of 1e-16 each");
    assert_eq!(found.dof, 15.0);
}
