//! Environment maps in latitude-longitude layout. The file name's ending selects the format, OpenEXR or Radiance.
//!
//! `layers` selects the channels of an EXR file.

mod layers;

use super::exr;
use super::hdr::{self, HdrImage};
use crate::error::{Error, Result};
use crate::texture::RadianceMap;
use glam::{DMat3, DVec3};
use std::path::Path;

/// An environment map, with notes about its conversion.
#[derive(Debug)]
pub struct LoadedMap {
    /// The map.
    pub map: RadianceMap,
    /// Choices and changes made while loading, one sentence each.
    pub warnings: Vec<String>,
    /// Losses, one sentence each. `--strict` rejects them.
    pub lost: Vec<String>,
}

/// Whether [`load`] supports files with this ending.
pub fn is_supported(path: &Path) -> bool {
    ending(path).is_some()
}

/// Reads the map in `path`, from the layer or part `layer` if given. Colours are converted to linear Rec. 709. Negative
/// lanes become 0. Infinite lanes become the largest finite value: of 16-bit floats if the file stores these, else of
/// the picture.
///
/// # Errors
/// A scene error with the path if the file cannot be read, is damaged, lacks colours or the layer, or has texels that
/// are NaN or beyond [`RadianceMap::BRIGHTEST`].
pub fn load(path: &Path, layer: Option<&str>) -> Result<LoadedMap> {
    let refuse = |what: String| Error::scene(format!("cannot read {}: {what}", path.display()));
    let file = std::fs::metadata(path).map_err(|cause| Error::read(path, cause))?;
    if !file.is_file() {
        return Err(refuse("it is not a regular file".into()));
    }
    let mut picture = match ending(path) {
        Some(Ending::Exr) => layers::picture(exr::read(path)?, layer).map_err(refuse)?,
        Some(Ending::Hdr) if layer.is_some() => return Err(refuse("a .hdr file has no layers to choose from".into())),
        Some(Ending::Hdr) => Picture::from(hdr::read(path)?),
        None => return Err(refuse("its name ends neither in .exr nor in .hdr".into())),
    };
    let named = |what: String| format!("{}: {what}", path.display());
    let infinite = picture.clamp_infinite().map_err(refuse)?;
    picture.convert();
    let negative = picture.check().map_err(refuse)?;
    let negative = (negative > 0).then(|| format!("{negative} texels are negative and count as black"));
    let warnings = picture.said.into_iter().chain(negative).map(named).collect();
    let lost = infinite.into_iter().map(named).collect();
    Ok(LoadedMap { map: RadianceMap::new(picture.width, picture.height, picture.texels), warnings, lost })
}

enum Ending {
    Exr,
    Hdr,
}

fn ending(path: &Path) -> Option<Ending> {
    match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "exr" => Some(Ending::Exr),
        "hdr" => Some(Ending::Hdr),
        _ => None,
    }
}

/// Texels in the primaries of the file.
struct Picture {
    width: u32,
    height: u32,
    texels: Vec<[f32; 3]>,
    /// Matrix from the file's primaries to linear Rec. 709.
    to_rec_709: DMat3,
    /// The largest finite value of the file's number format, if it is small enough to replace infinity.
    largest: Option<f32>,
    /// A note about the selected layer.
    said: Option<String>,
}

impl From<HdrImage> for Picture {
    fn from(image: HdrImage) -> Self {
        let HdrImage { width, height, texels, to_rec_709 } = image;
        Picture { width, height, texels, to_rec_709, largest: None, said: None }
    }
}

impl Picture {
    /// Replaces infinite values. Returns a note if there were any.
    fn clamp_infinite(&mut self) -> std::result::Result<Option<String>, String> {
        let bright = |texel: &&mut [f32; 3]| texel.contains(&f32::INFINITY);
        let count = self.texels.iter_mut().filter(bright).count();
        if count == 0 {
            return Ok(None);
        }
        let finite = self.texels.iter().flatten().copied().filter(|lane| lane.is_finite());
        let largest = self.largest.unwrap_or_else(|| finite.fold(0.0, f32::max).min(RadianceMap::BRIGHTEST));
        if largest <= 0.0 {
            return Err(format!("all that shines in it is infinite ({count} texels)"));
        }
        for texel in self.texels.iter_mut().filter(bright) {
            *texel = texel.map(|lane| if lane == f32::INFINITY { largest } else { lane });
        }
        Ok(Some(format!("{count} texels are infinite and count as {largest}: their light is lost in part")))
    }

    /// Converts the colours to linear Rec. 709.
    fn convert(&mut self) {
        if self.to_rec_709 == DMat3::IDENTITY {
            return;
        }
        for texel in &mut self.texels {
            let converted = self.to_rec_709 * DVec3::from(texel.map(f64::from));
            *texel = rounded(converted, *texel);
        }
    }

    /// Clamps negative lanes to 0. Returns the number of texels changed.
    fn check(&mut self) -> std::result::Result<usize, String> {
        let wrong = |texel: &&[f32; 3]| !texel.iter().all(|lane| lane.abs() <= RadianceMap::BRIGHTEST);
        let count = self.texels.iter().filter(wrong).count();
        if count > 0 {
            let (all, most) = (self.texels.len(), RadianceMap::BRIGHTEST);
            return Err(format!("{count} of its {all} texels are not numbers or beyond {most:e}"));
        }
        let mut negative = 0;
        for texel in self.texels.iter_mut().filter(|texel| texel.iter().any(|&lane| lane < 0.0)) {
            negative += 1;
            *texel = texel.map(|lane| lane.max(0.0));
        }
        Ok(negative)
    }
}

/// Rounds a colour to single precision. A lane below the rounding error of the conversion becomes 0, so that a colour
/// on the gamut boundary does not fall outside.
fn rounded(color: DVec3, from: [f32; 3]) -> [f32; 3] {
    let largest = from.into_iter().fold(0.0, |a: f32, b| a.max(b.abs()));
    let rounding = f64::from(largest) * 4.0 * f64::from(f32::EPSILON);
    color.to_array().map(|lane| if lane.abs() <= rounding { 0.0 } else { lane as f32 })
}
