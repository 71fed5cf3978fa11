//! Reference images.

use super::{BenchScene, defect};
use crate::error::{Error, Result};

use crate::io::exr;
use crate::lab::image::relmse_epsilon;
use crate::session::RenderSettings;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// A reference image.
pub(super) struct Reference {
    /// Its pixels, 3 values each.
    pub(super) rgb: Vec<f32>,
    /// Origin and quality of the image.
    pub(super) record: Record,
}

/// Origin and quality of a reference.
#[derive(Debug, Clone, Serialize)]
pub struct Record {
    /// Its file.
    pub file: PathBuf,
    /// The program or method that made it.
    pub origin: String,
    /// The ε of relMSE, (0.1 × its mean)².
    pub epsilon: f64,
    /// Its own relMSE, which is subtracted from measured errors; `None` if unknown and not subtracted.
    pub noise: Option<f64>,
    /// Whether the time limit ended the rendering before its relMSE was a tenth of the predicted errors.
    pub is_cut_short: bool,
}

impl Reference {
    /// Reads the reference given for a subject, if any.
    pub(super) fn given(subject: &BenchScene) -> Result<Option<Reference>> {
        let Some((path, noise)) = &subject.reference else { return Ok(None) };
        let (_, job) = subject.stages.first().ok_or_else(|| defect("a scene without a backend"))?;
        let mut reference = Reference::read(path, &job.settings)?;
        reference.record.noise = noise.or(reference.record.noise);
        Ok(Some(reference))
    }

    pub(super) fn read(path: &Path, settings: &RenderSettings) -> Result<Reference> {
        let image = exr::read(path)?;
        let crop = image.crop;
        let size = [image.width, image.height];
        if size != [settings.width, settings.height] || settings.layout().crop != crop {
            let (w, h) = (settings.width, settings.height);
            let what =
                format!("the reference {} is {}×{} and the images are {w}×{h}", path.display(), size[0], size[1]);
            return Err(Error::usage(format!("{what}: use --size {}x{}", size[0], size[1])));
        }
        let missing = || Error::usage(format!("the reference {} has no channels R, G and B", path.display()));
        let rgb = image.rgb("").ok_or_else(missing)?;
        let epsilon = relmse_epsilon(&rgb);
        let noise = image.rgb("stderr.").map(|stderr| noise(&rgb, &stderr, epsilon));
        let origin = if noise.is_some() { "given, with its standard error" } else { "given" };
        let record = Record { file: path.into(), origin: origin.into(), epsilon, noise, is_cut_short: false };
        Ok(Reference { rgb, record })
    }
}

/// relMSE of an image according to its standard error.
pub(super) fn noise(rgb: &[f32], stderr: &[f32], epsilon: f64) -> f64 {
    let terms = rgb.iter().zip(stderr).map(|(&v, &s)| f64::from(s).powi(2) / (f64::from(v).powi(2) + epsilon));
    let (sum, count) = terms.filter(|t| t.is_finite()).fold((0.0, 0.0), |(sum, count), t| (sum + t, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reference_noise_follows_from_its_standard_error() {
        // (0.1² / (1 + ε) + 0 + 0.2² / (4 + ε)) / 3 with ε = (0.1 × 1)².
        let (rgb, stderr) = ([1.0, 0.0, 2.0], [0.1, 0.0, 0.2]);
        let epsilon = relmse_epsilon(&rgb);
        assert!((epsilon - 0.01).abs() < 1e-15, "rounding");
        let exact = (0.01 / 1.01 + 0.04 / 4.01) / 3.0;
        assert!((noise(&rgb, &stderr, epsilon) / exact - 1.0).abs() < 1e-6, "0.1 and 0.2 as f32");
        assert_eq!(noise(&[f32::NAN; 3], &stderr, epsilon).to_bits(), 0);
    }
}
