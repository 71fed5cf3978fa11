//! Image metrics against a reference, over all channel values. These are interleaved (`RGBRGB…`) or in any other order
//! common to both images. Each metric is a mean over the values that are finite in both images; [`non_finite`] counts
//! the others. Without any such values a metric is NaN. Sums are f64 in a fixed order, independent of the number of
//! threads.
//!
//! The noise of the reference is included: its own MSE adds to the measured one.

pub mod flip;

use crate::{film, numeric};

use rayon::prelude::*;

/// Number of values per parallel chunk, fixed so that the order of additions does not depend on the threads.
const CHUNK: usize = 1 << 14;

/// Returns the mean squared error, mean (I − R)².
///
/// # Panics
/// Unless both have the same length.
pub fn mse(image: &[f32], reference: &[f32]) -> f64 {
    mean(image, reference, |i, r| (i - r) * (i - r))
}

/// Returns the mean absolute error, mean |I − R|.
///
/// # Panics
/// Unless both have the same length.
pub fn mae(image: &[f32], reference: &[f32]) -> f64 {
    mean(image, reference, |i, r| (i - r).abs())
}

/// Returns the mean squared error relative to the squared reference, mean (I − R)² / (R² + ε) [Rousselle11]. ε is in
/// squared units of the image. With ε = 0 the result is infinite if a pixel is black in the reference only.
///
/// # Panics
/// Unless both have the same length and ε ≥ 0.
pub fn relmse(image: &[f32], reference: &[f32], epsilon: f64) -> f64 {
    assert!(epsilon >= 0.0, "ε = {epsilon}");
    mean(image, reference, |i, r| ratio((i - r) * (i - r), r * r + epsilon))
}

/// Returns the default ε of relMSE for a reference, that of its mean over finite values.
pub fn relmse_epsilon(reference: &[f32]) -> f64 {
    let finite: Vec<f32> = reference.iter().copied().filter(|v| v.is_finite()).collect();
    let mean = numeric::mean(&finite);
    // A black image has no scale: any ε will do.
    film::relmse_epsilon(if mean > 0.0 { mean } else { 1.0 })
}

/// Returns the symmetric mean absolute error, mean |I − R| / (|I| + |R|), from 0 to 1 (other authors use twice this
/// value). A value of 0 in both images counts as no error [Vogels18].
///
/// # Panics
/// Unless both have the same length.
pub fn smape(image: &[f32], reference: &[f32]) -> f64 {
    mean(image, reference, |i, r| ratio((i - r).abs(), i.abs() + r.abs()))
}

/// Returns the peak signal-to-noise ratio in decibels, 10 log₁₀(peak² / MSE): infinite for equal images. `peak` is the
/// largest signal value: 1 for display values; high dynamic range images have no natural peak.
///
/// # Panics
/// Unless both have the same length and `peak` is positive.
pub fn psnr(image: &[f32], reference: &[f32], peak: f64) -> f64 {
    assert!(peak > 0.0, "peak = {peak}");
    10.0 * (peak * peak / mse(image, reference)).log10()
}

/// Returns the number of values that are infinite or NaN in either image; the metrics exclude them.
///
/// # Panics
/// Unless both have the same length.
pub fn non_finite(image: &[f32], reference: &[f32]) -> usize {
    assert_eq!(image.len(), reference.len());
    image.iter().zip(reference).filter(|(i, r)| !(i.is_finite() && r.is_finite())).count()
}

/// Returns the mean of `term` over the values that are finite in both images.
fn mean(image: &[f32], reference: &[f32], term: impl Fn(f64, f64) -> f64 + Sync) -> f64 {
    assert_eq!(image.len(), reference.len());
    let chunk_sum = |(image, reference): (&[f32], &[f32])| {
        let finite = image.iter().zip(reference).filter(|(i, r)| i.is_finite() && r.is_finite());
        finite.fold((0.0, 0_u64), |(sum, n), (&i, &r)| (sum + term(f64::from(i), f64::from(r)), n + 1))
    };
    let chunks: Vec<(f64, u64)> = image.par_chunks(CHUNK).zip(reference.par_chunks(CHUNK)).map(chunk_sum).collect();
    let (sum, n) = chunks.iter().fold((0.0, 0), |(sum, n), chunk| (sum + chunk.0, n + chunk.1));
    sum / n as f64
}

/// Returns `error` / `size`; 0 for a zero error, even if `size` is 0.
fn ratio(error: f64, size: f64) -> f64 {
    if error > 0.0 { error / size } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::test_random::Random;

    const IMAGE: [f32; 4] = [1.0, 2.0, 0.0, 0.5];
    const REFERENCE: [f32; 4] = [1.0, 1.0, 0.0, 1.0];

    /// All sums and quotients but those of the last two are exact in binary.
    #[test]
    fn metrics_of_four_known_values() {
        assert_eq!(mse(&IMAGE, &REFERENCE), 1.25 / 4.0);
        assert_eq!(mae(&IMAGE, &REFERENCE), 1.5 / 4.0);
        assert_eq!(relmse(&IMAGE, &REFERENCE, 1.0), 0.625 / 4.0);
        assert_eq!(relmse(&IMAGE, &REFERENCE, 0.0), 1.25 / 4.0);
        assert!((smape(&IMAGE, &REFERENCE) - (1.0 / 3.0 + 0.5 / 1.5) / 4.0).abs() < f64::EPSILON);
        assert!((psnr(&IMAGE, &REFERENCE, 2.0) - 10.0 * 12.8_f64.log10()).abs() < 20.0 * f64::EPSILON);
    }

    #[test]
    fn equal_images_have_no_error() {
        assert_eq!([mse, mae, smape].map(|figure| figure(&IMAGE, &IMAGE)), [0.0; 3]);
        assert_eq!(relmse(&IMAGE, &IMAGE, 0.0), 0.0);
        assert_eq!(psnr(&IMAGE, &IMAGE, 1.0), f64::INFINITY);
        assert_eq!(relmse(&[1.0], &[0.0], 0.0), f64::INFINITY);
    }

    #[test]
    fn non_finite_values_are_counted_and_left_out() {
        let (mut image, mut reference) = (IMAGE.to_vec(), REFERENCE.to_vec());
        image.extend([f32::NAN, 1.0, f32::INFINITY]);
        reference.extend([1.0, f32::NEG_INFINITY, f32::INFINITY]);
        assert_eq!(non_finite(&image, &reference), 3);
        assert_eq!(mse(&image, &reference), mse(&IMAGE, &REFERENCE));
        assert_eq!(smape(&image, &reference), smape(&IMAGE, &REFERENCE));
        assert!(mse(&[f32::NAN], &[0.0]).is_nan() && mae(&[], &[]).is_nan());
    }

    /// For uniform I and R the expectations are: MSE 1/6, MAE 1/3, SMAPE 2 ln 2 − 1. Two-sided z test of each at level
    /// 1e-6 (4.9 σ), σ below 0.3 for each term.
    #[test]
    fn means_run_over_all_chunks() {
        let mut random = Random::new(11);
        let n = 3 * CHUNK + 5;
        let mut uniform = || (0..n).map(|_| random.uniform() as f32).collect::<Vec<_>>();
        let (image, reference) = (uniform(), uniform());
        let slack = 4.9 * 0.3 / (n as f64).sqrt();
        for (figure, expected) in [
            (mse(&image, &reference), 1.0 / 6.0),
            (mae(&image, &reference), 1.0 / 3.0),
            (smape(&image, &reference), 2.0 * 2.0_f64.ln() - 1.0),
        ] {
            assert!((figure - expected).abs() < slack, "{figure} {expected}");
        }
    }

    #[test]
    #[should_panic(expected = "left == right")]
    fn images_of_other_sizes_are_refused() {
        mse(&IMAGE, &REFERENCE[1..]);
    }
}
