//! Error metrics of a comparison.

use super::ImagePair;
use crate::io::png::ToneCurve;
use crate::lab::image::{self, flip};
use serde::Serialize;

/// Error metrics of an image against its reference. Infinite values are `null` in JSON.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Metrics {
    /// Number of values (three per pixel) that are infinite or NaN in either image. All metrics but FLIP leave them
    /// out.
    pub non_finite: usize,
    /// Mean squared error.
    pub mse: f64,
    /// Mean absolute error.
    pub mae: f64,
    /// Mean of (I − R)² / (R² + ε).
    pub relmse: f64,
    /// The ε of relMSE.
    pub relmse_epsilon: f64,
    /// Mean of |I − R| / (|I| + |R|).
    pub smape: f64,
    /// Peak signal-to-noise ratio in decibels, of display values (sRGB, clipped, peak 1).
    pub psnr: f64,
    /// Mean LDR ꟻLIP of display values.
    pub flip_ldr: f64,
    /// Mean HDR ꟻLIP over exposures.
    pub flip_hdr: f64,
    /// Lowest and highest exposure of HDR ꟻLIP, in stops.
    pub flip_exposures: [f32; 2],
    /// Number of exposures.
    pub flip_steps: u32,
    /// Viewing distance of ꟻLIP, in pixels per degree.
    pub flip_pixels_per_degree: f32,
}

impl Metrics {
    pub(super) fn of(pair: &ImagePair, epsilon: Option<f64>) -> Metrics {
        let (colors, reference) = (&pair.image.colors[..], &pair.reference.colors[..]);
        let epsilon = epsilon.unwrap_or_else(|| image::relmse_epsilon(reference));
        let displayed = |values: &[f32]| values.iter().map(|&v| display(v)).collect::<Vec<f32>>();
        let ppd = flip::PIXELS_PER_DEGREE;
        let hdr = pair.hdr_flip();
        Metrics {
            non_finite: image::non_finite(colors, reference),
            mse: image::mse(colors, reference),
            mae: image::mae(colors, reference),
            relmse: image::relmse(colors, reference, epsilon),
            relmse_epsilon: epsilon,
            smape: image::smape(colors, reference),
            psnr: image::psnr(&displayed(colors), &displayed(reference), 1.0),
            flip_ldr: flip::ldr(colors, reference, pair.extent(), ppd).mean,
            flip_hdr: hdr.flip.mean,
            flip_exposures: hdr.exposures,
            flip_steps: hdr.steps,
            flip_pixels_per_degree: ppd,
        }
    }
}

/// Returns the display value. Non-finite values stay non-finite and are left out.
fn display(value: f32) -> f32 {
    if value.is_finite() { ToneCurve::Srgb.apply(value) } else { value }
}
