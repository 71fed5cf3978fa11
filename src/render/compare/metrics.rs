//! The figures of a comparison.

use super::Pair;
use crate::io::png::Curve;
use crate::stats::image::{self, flip};
use serde::Serialize;

/// ε of relMSE is the square of this share of the reference's mean, as in the error that an image states of itself.
const FLOOR: f64 = 0.1;

/// How far an image is from its reference. What is infinite is `null` in JSON.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Metrics {
    /// Values (three a pixel) that are infinite or NaN in either image; all figures but FLIP leave them out.
    pub non_finite: usize,
    /// Mean squared error.
    pub mse: f64,
    /// Mean absolute error.
    pub mae: f64,
    /// Mean of (I − R)² / (R² + ε).
    pub relmse: f64,
    /// That ε.
    pub relmse_epsilon: f64,
    /// Mean of |I − R| / (|I| + |R|).
    pub smape: f64,
    /// Peak signal-to-noise ratio in decibels of display values: sRGB, clipped, peak 1.
    pub psnr: f64,
    /// Mean ꟻLIP as displayed.
    pub flip_ldr: f64,
    /// Mean ꟻLIP over exposures.
    pub flip_hdr: f64,
    /// The lowest and highest exposure of it in stops.
    pub flip_exposures: [f32; 2],
    /// How many exposures.
    pub flip_steps: u32,
    /// The distance that ꟻLIP is seen from, in pixels per degree.
    pub flip_pixels_per_degree: f32,
}

impl Metrics {
    pub(super) fn of(pair: &Pair, epsilon: Option<f64>) -> Metrics {
        let (colors, reference) = (&pair.image.colors[..], &pair.reference.colors[..]);
        let epsilon = epsilon.unwrap_or_else(|| (FLOOR * finite_mean(reference)).powi(2));
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

/// A display value; what is not finite stays so and is left out.
fn display(value: f32) -> f32 {
    if value.is_finite() { Curve::Srgb.apply(value) } else { value }
}

fn finite_mean(values: &[f32]) -> f64 {
    let (sum, n) = values.iter().filter(|v| v.is_finite()).fold((0.0, 0_u32), |(s, n), &v| (s + f64::from(v), n + 1));
    sum / f64::from(n.max(1))
}
