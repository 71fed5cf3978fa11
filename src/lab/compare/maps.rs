//! Difference maps of two images: EXR with the values, or PNG in perceptually even colours. Non-finite pixels are
//! green.

use super::ImagePair;
use crate::error::{Error, Result};
use crate::io::exr::{self, Layer};
use crate::io::png;
use crate::session::images::split;
use std::path::Path;

/// z-score at the ends of the colour scale.
const Z_LIMIT: f32 = 5.0;
/// Fraction of the pixels whose difference lies within the colour scale.
const WITHIN: f64 = 0.99;
const NOT_FINITE: [u8; 3] = [0, 255, 0];

/// A quantity at each pixel.
#[derive(Debug, Clone)]
pub struct Map {
    /// EXR channel names.
    channels: &'static [&'static str],
    values: Vec<f32>,
    /// One value per pixel for PNG, and the meaning of the colours.
    shown: Vec<f32>,
    scale: Scale,
}

/// Colour scale of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// Blue at −limit, white at 0, red at +limit: ColorBrewer's RdBu.
    Signed {
        /// Value at the ends of the scale.
        limit: f32,
    },
    /// Black at 0, pale yellow at 1: magma.
    Share,
}

impl std::fmt::Display for Scale {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Scale::Signed { limit } => write!(f, "blue at -{limit:.3e}, white at 0, red at +{limit:.3e}"),
            Scale::Share => write!(f, "black at 0, purple at 0.4, pale yellow at 1"),
        }
    }
}

impl ImagePair {
    /// Returns image − reference. The colours show the mean over channels, scaled to the 99th percentile of the nonzero
    /// magnitudes.
    pub fn difference(&self) -> Map {
        let values: Vec<f32> = self.image.colors.iter().zip(&self.reference.colors).map(|(a, b)| a - b).collect();
        let shown: Vec<f32> = values.chunks_exact(3).map(|c| (c[0] + c[1] + c[2]) / 3.0).collect();
        Map { channels: &["R", "G", "B"], values, scale: Scale::Signed { limit: percentile(&shown) }, shown }
    }

    /// Returns (image − reference) over its standard error, 0 where the two are equal. The colours show the channel
    /// with the largest magnitude, up to 5.
    ///
    /// # Errors
    /// A usage error if an image carries no standard errors.
    pub fn z_scores(&self) -> Result<Map> {
        let [Some(ea), Some(eb)] = [&self.image, &self.reference].map(|side| side.errors.as_ref()) else {
            return Err(Error::usage("z-scores need standard errors (layers stderr.R, G, B) in both images"));
        };
        let colors = self.image.colors.iter().zip(&self.reference.colors);
        let values: Vec<f32> =
            colors.zip(ea.iter().zip(eb)).map(|((a, b), (ea, eb))| z(*a, *b, ea.hypot(*eb))).collect();
        let furthest = |c: &[f32]| c.iter().copied().reduce(|a, b| if b.abs() > a.abs() || b.is_nan() { b } else { a });
        let shown = values.chunks_exact(3).filter_map(furthest).collect();
        Ok(Map { channels: &["R", "G", "B"], values, shown, scale: Scale::Signed { limit: Z_LIMIT } })
    }

    /// Returns the HDR ꟻLIP map.
    pub fn flip(&self) -> Map {
        let map = &self.hdr_flip().flip.map;
        Map { channels: &["Y"], shown: map.clone(), values: map.clone(), scale: Scale::Share }
    }

    /// Writes a map as EXR or PNG, selected by the ending of `path`. Returns the colour scale for a PNG.
    ///
    /// # Errors
    /// The path has another ending, or the file cannot be written.
    pub fn write(&self, map: &Map, path: &Path) -> Result<Option<Scale>> {
        let [width, height] = self.extent().map(|side| side as u32);
        if is(path, "exr") {
            let [full_width, full_height] = self.image.size;
            let layers: Vec<Layer> = split(map.channels, &map.values);
            return exr::write(path, full_width, full_height, Some(self.image.crop), &layers, &[]).map(|()| None);
        }
        check_ending(path)?;
        let colors: Vec<[u8; 3]> = map.shown.iter().map(|&v| map.scale.color(v)).collect();
        png::write_colors(path, width, height, &colors).map(|()| Some(map.scale))
    }
}

/// Checks that `path` has an ending that a map can be written with.
///
/// # Errors
/// A usage error if it ends neither in .png nor in .exr.
pub fn check_ending(path: &Path) -> Result<()> {
    if is(path, "exr") || is(path, "png") {
        return Ok(());
    }
    Err(Error::usage(format!("{}: a map must end in .png or .exr", path.display())))
}

fn is(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending))
}

impl Scale {
    fn color(self, value: f32) -> [u8; 3] {
        let (gradient, at) = match self {
            // RdBu begins with red.
            Scale::Signed { limit } => (colorous::RED_BLUE, 0.5 - 0.5 * (value / limit).clamp(-1.0, 1.0)),
            Scale::Share => (colorous::MAGMA, value.clamp(0.0, 1.0)),
        };
        if value.is_nan() { NOT_FINITE } else { gradient.eval_continuous(f64::from(at)).as_array() }
    }
}

/// The difference in standard errors: 0 if there is no difference, infinite if there is one and the error is 0.
fn z(a: f32, b: f32, error: f32) -> f32 {
    let difference = a - b;
    if difference.abs() > 0.0 { difference / error } else { difference }
}

/// Returns the [`WITHIN`] quantile of the nonzero absolute values; 1 if all are 0.
fn percentile(values: &[f32]) -> f32 {
    let mut sizes: Vec<f32> = values.iter().map(|v| v.abs()).filter(|v| v.is_finite() && *v > 0.0).collect();
    sizes.sort_unstable_by(f32::total_cmp);
    sizes.get((sizes.len() as f64 * WITHIN) as usize).copied().unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn map_colours_encode_sign_and_magnitude() {
        let scale = Scale::Signed { limit: 2.0 };
        let [low, zero, high] = [-9.0, 0.0, 2.0].map(|v| scale.color(v));
        assert!(
            low[2] > 2 * low[0] && high[0] > 2 * high[2] && zero.iter().all(|&c| c > 230),
            "{low:?} {zero:?} {high:?}"
        );
        assert_eq!(scale.color(f32::NAN), NOT_FINITE);
        assert_eq!(scale.color(f32::INFINITY), high);
        assert!(Scale::Share.color(0.0).iter().all(|&c| c < 10) && Scale::Share.color(1.0)[0] > 240);
    }

    #[test]
    fn map_scale_covers_99_percent_of_values() {
        let mut values: Vec<f32> = (1..=1000).map(|i| i as f32).collect();
        assert_eq!(percentile(&values), 991.0);
        values.iter_mut().take(900).for_each(|v| *v = 0.0);
        assert_eq!(percentile(&values), 1000.0);
        assert_eq!(percentile(&[0.0, f32::NAN]), 1.0);
    }

    #[test]
    fn z_scores_of_exact_pixels() {
        assert_eq!(z(3.0, 1.0, 0.5), 4.0);
        assert_eq!(z(1.0, 1.0, 0.0), 0.0);
        assert_eq!(z(1.0, 2.0, 0.0), f32::NEG_INFINITY);
        assert!(z(f32::NAN, 1.0, 1.0).is_nan());
    }
}
