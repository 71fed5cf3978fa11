use super::*;
use crate::film::{PassFilm, Units};
use crate::stats::test_random::Random;
use crate::stats::{Moments, t_test};

/// The true mean of a pixel: a ramp from 0.5 to 1.5 over the image.
fn truth(pixel: usize, pixels: usize) -> f64 {
    0.5 + pixel as f64 / (pixels - 1) as f64
}

/// Returns a film whose samples are `truth` times random factors, independent in every channel.
fn film(layout: &Layout, replicates: u32, passes: u64, seed: u64, draw: impl Fn(&mut Random) -> f64) -> Film {
    film_of(layout, replicates, passes, seed, |_, random| draw(random))
}

/// The same with factors that differ between pixels.
fn film_of(layout: &Layout, replicates: u32, passes: u64, seed: u64, draw: impl Fn(usize, &mut Random) -> f64) -> Film {
    let mut film = Film::new(layout.clone(), replicates, seed, Units::from_exponents(-24, 0).unwrap());
    let mut random = Random::new(seed);
    let (mut pass, pixels) = (PassFilm::new(layout), layout.pixels());
    for k in 0..passes {
        let values: Vec<f32> =
            (0..pixels * 3).map(|i| (truth(i / 3, pixels) * draw(i / 3, &mut random)) as f32).collect();
        pass.par_chunks(1).for_each(|(p, out)| out.copy_from_slice(&values[p * 3..p * 3 + 3]));
        film.commit(k, &pass);
    }
    film
}

/// relMSE of N passes whose samples have relative variance `variance`.
fn true_relmse(layout: &Layout, passes: u64, variance: f64) -> f64 {
    let pixels = layout.pixels();
    let relative = |p: usize| truth(p, pixels).powi(2) / (truth(p, pixels).powi(2) + relmse_epsilon(1.0));
    (0..pixels).map(relative).sum::<f64>() / pixels as f64 * variance / passes as f64
}

fn normal(random: &mut Random) -> f64 {
    1.0 + 0.1 * random.normal()
}

fn exponential(random: &mut Random) -> f64 {
    random.exponential()
}

/// The mean estimate over independent films is the true value: t test at level 1e-6. The residual bias, half the square
/// of 3 × 0.01/8 here, is far below the 2 % that the test can detect.
#[test]
fn relmse_and_standard_error_are_unbiased() {
    let layout = Layout::new(16, 16, None, &[]);
    for (replicates, passes) in [(2, 8), (3, 12), (4, 16), (4, 10), (16, 32)] {
        let (mut relmse, mut squares, mut mean) = (Moments::new(), Moments::new(), Moments::new());
        for seed in 0..60 {
            let film = film(&layout, replicates, passes, seed * 64 + u64::from(replicates), normal);
            let error = film.image_error(Independent::Pixels).unwrap();
            relmse.push(error.relmse.value);
            mean.push(error.mean_standard_error.powi(2));
            squares.extend(film.standard_error().unwrap().iter().map(|&e| f64::from(e).powi(2)));
            let rmse =
                (film.standard_error().unwrap().iter().map(|&e| f64::from(e).powi(2)).sum::<f64>() / 768.0).sqrt();
            assert!((error.rmse / rmse - 1.0).abs() < 1e-6, "f32 standard errors round to 6e-8 each");
        }
        let mean_square = (0..256).map(|p| truth(p, 256).powi(2)).sum::<f64>() / 256.0;
        let variance = 0.01 * mean_square / passes as f64;
        for (name, found, expected) in [
            ("relmse", relmse, true_relmse(&layout, passes, 0.01)),
            ("variance", squares, variance),
            ("variance of the mean", mean, variance / 768.0),
        ] {
            let test = t_test(&found.estimate().unwrap(), expected);
            assert!(test.p_value > 1e-6, "{name} R={replicates}: {found:?} {expected} {test:?}");
        }
    }
}

/// Returns how many of `films` films have the true value in their interval.
fn covered(films: u64, passes: u64, variance: f64, draw: fn(&mut Random) -> f64) -> f64 {
    let layout = Layout::new(64, 32, None, &[]);
    let expected = true_relmse(&layout, passes, variance);
    let holds = |seed| {
        let relmse = film(&layout, 4, passes, seed, draw).image_error(Independent::Pixels).unwrap().relmse;
        (relmse.low..=relmse.high).contains(&expected)
    };
    (0..films).into_par_iter().filter(|&seed| holds(seed + 1000)).count() as f64
}

/// 95 % intervals cover the true value for normal pixels in 95 % of 500 films: two-sided binomial test at level 1e-4
/// (3.9 σ).
#[test]
fn interval_covers_for_normal_pixels() {
    let hits = covered(500, 4, 0.01, normal);
    println!("{hits} of 500");
    assert!((hits - 475.0).abs() < 3.9 * (500.0_f64 * 0.95 * 0.05).sqrt(), "{hits} of 500");
}

/// Where one pixel of 32 dominates the error, its estimate and that of its noise are skewed: log-normal intervals cover
/// the true value in 87 % only. One-sided binomial test at level 1e-4 (3.7 σ).
#[test]
fn interval_covers_where_few_pixels_make_the_error() {
    let layout = Layout::new(16, 16, None, &[]);
    let pixels = layout.pixels();
    let relative = |p: usize| truth(p, pixels).powi(2) / (truth(p, pixels).powi(2) + relmse_epsilon(1.0));
    let expected = (0..pixels).step_by(32).map(relative).sum::<f64>() / pixels as f64 * 0.01 / 4.0;
    let draw = |pixel: usize, random: &mut Random| if pixel % 32 == 0 { normal(random) } else { 1.0 };
    let holds = |seed| {
        let relmse = film_of(&layout, 4, 4, seed, draw).image_error(Independent::Pixels).unwrap().relmse;
        (relmse.low..=relmse.high).contains(&expected)
    };
    let hits = (0..1000).into_par_iter().filter(|&seed| holds(seed + 9000)).count() as f64;
    println!("{hits} of 1000");
    assert!(hits > 950.0 - 3.7 * (1000.0_f64 * 0.95 * 0.05).sqrt(), "{hits} of 1000");
}

/// The same for exponential samples, 64 of them: one-sided binomial test at level 1e-4 (3.7 σ), since the bound on the
/// residual bias widens the interval.
#[test]
fn interval_covers_for_skewed_pixels() {
    let hits = covered(300, 64, 1.0, exponential);
    println!("{hits} of 300");
    assert!(hits > 285.0 - 3.7 * (300.0_f64 * 0.95 * 0.05).sqrt(), "{hits} of 300");
}

/// The residual bias is below the bound that widens the interval, for images of normal samples with two replicates and
/// relative variances of the denominators of .02 (where it must be within 2 %) and of .045. The statistical error of 40
/// films is 0.4 % (6 σ: 2.4 %).
#[test]
fn noise_in_the_denominator_is_corrected() {
    let layout = Layout::new(32, 32, None, &[]);
    for (deviation, most) in [(0.2, 0.02), (0.3, f64::INFINITY)] {
        let errors: Vec<RelMse> = (0..40)
            .map(|seed| film(&layout, 4, 4, seed + 5000, |random| 1.0 + deviation * random.normal()))
            .map(|film| film.image_error(Independent::Pixels).unwrap().relmse)
            .collect();
        let estimate = errors.iter().map(|e| e.value).collect::<Moments>().estimate().unwrap();
        let bound = errors.iter().map(|e| e.bias_bound / e.value).sum::<f64>() / 40.0;
        let ratio = estimate.value / true_relmse(&layout, 4, deviation * deviation);
        let noise = 6.0 * estimate.standard_error / estimate.value;
        println!("bias {:.4} ± {:.4}, bound {bound:.4}", ratio - 1.0, noise / 6.0);
        assert!((ratio - 1.0).abs() < bound.min(most) + noise, "{ratio} ± {noise}: {bound}");
    }
}

/// Samples of which one in a hundred is a hundred times as bright: divided by their own mean they hide most of their
/// error. Tolerance: six standard errors, and the 10 % of skewness bias that extrapolation leaves.
#[test]
fn rare_samples_do_not_hide_their_own_error() {
    let layout = Layout::new(16, 16, None, &[]);
    let draw = |random: &mut Random| if random.uniform() < 0.01 { 50.5 } else { 0.5 };
    let found = (0..10)
        .map(|seed| film(&layout, 4, 1024, seed + 7000, draw).image_error(Independent::Pixels).unwrap().relmse.value);
    let estimate = found.collect::<Moments>().estimate().unwrap();
    let ratio = estimate.value / true_relmse(&layout, 1024, 0.0099 * 2500.0);
    println!("ratio {ratio:.4} ± {:.4}", estimate.standard_error / estimate.value);
    assert!((ratio - 1.0).abs() < 0.1 + 6.0 * estimate.standard_error / estimate.value, "{ratio}");
}

#[test]
fn fewer_than_two_replicates_have_no_error_estimate() {
    let layout = Layout::new(4, 4, None, &[]);
    assert!(film(&layout, 1, 4, 0, normal).image_error(Independent::Pixels).is_none());
    assert!(film(&layout, 4, 3, 0, normal).standard_error().is_none());
    assert!(film(&layout, 4, 4, 0, normal).standard_error().is_some());
}

#[test]
fn edge_images_have_sane_errors() {
    let black = film(&Layout::new(9, 9, None, &[]), 4, 4, 0, |_| 0.0).image_error(Independent::Pixels).unwrap();
    assert_eq!(
        black.trust().reasons.iter().map(|distrust| distrust.reason).collect::<Vec<_>>(),
        [crate::film::Reason::NoLight]
    );
    assert!(black.relmse.value.to_bits() == 0 && black.relmse.high.to_bits() == 0 && black.max_share.to_bits() == 0);
    let one = Layout::new(8, 8, Some(crate::film::Crop { x0: 3, y0: 3, x1: 4, y1: 4 }), &[]);
    let mut pass = PassFilm::new(&one);
    let mut single = Film::new(one, 2, 0, Units::from_exponents(-24, 0).unwrap());
    for k in 0..2 {
        pass.par_chunks(1).for_each(|(_, v)| v.fill(k as f32));
        single.commit(k, &pass);
    }
    let error = single.image_error(Independent::Pixels).unwrap();
    assert!(error.relmse.high.is_infinite() && (error.mean - 0.5).abs() < f64::EPSILON);
    let json = serde_json::to_string(&error).unwrap();
    assert!(json.contains("\"high\":null"), "{json}");
    let back: ImageError = serde_json::from_str(&json).unwrap();
    assert!(back.relmse.high.is_infinite() && (back.relmse.value - error.relmse.value).abs() < f64::EPSILON);
}

/// A single outlier pixel is detected.
#[test]
fn firefly_dominates_max_share() {
    let layout = Layout::new(64, 64, None, &[]);
    let mut pass = PassFilm::new(&layout);
    let mut film = Film::new(layout, 4, 0, Units::from_exponents(-24, 0).unwrap());
    for k in 0..8 {
        pass.par_chunks(1).for_each(|(p, v)| v.fill(if p == 77 && k == 3 { 1e6 } else { 1.0 + 0.001 * k as f32 }));
        film.commit(k, &pass);
    }
    assert!(film.image_error(Independent::Pixels).unwrap().max_share > 0.99);
}
