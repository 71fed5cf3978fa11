//! Environment maps from files: OpenEXR and Radiance pictures in latitude-longitude layout, by the ending of their name.
//!
//! An EXR file gives its channels R, G and B, or those of the first layer that has all three, or a luminance Y for all three.

use super::exr::{self, ExrImage};
use super::hdr;
use crate::error::{Error, Result};
use crate::film::Crop;
use crate::texture::RadianceMap;
use std::path::Path;

/// A map, and what was changed to make it one.
#[derive(Debug)]
pub struct LoadedMap {
    /// The map.
    pub map: RadianceMap,
    /// A sentence if texels were changed.
    pub warning: Option<String>,
}

/// Whether files of this name are read by [`load`].
pub fn is_supported(path: &Path) -> bool {
    ending(path).is_some()
}

/// Reads the map in `path`. Negative texels become 0, with a warning.
///
/// # Errors
/// A scene error with the path if the file cannot be read, is damaged, lacks colours, or has texels that are not finite or
/// beyond [`RadianceMap::BRIGHTEST`].
pub fn load(path: &Path) -> Result<LoadedMap> {
    let refuse = |what: String| Error::scene(format!("cannot read {}: {what}", path.display()));
    let file = std::fs::metadata(path).map_err(|cause| Error::read(path, cause))?;
    if !file.is_file() {
        return Err(refuse("it is not a regular file".into()));
    }
    let (width, height, texels) = match ending(path) {
        Some(Ending::Exr) => colors(exr::read(path)?).map_err(refuse)?,
        Some(Ending::Hdr) => {
            let image = hdr::read(path)?;
            (image.width, image.height, image.texels)
        }
        None => return Err(refuse("its name ends neither in .exr nor in .hdr".into())),
    };
    let (texels, negative) = checked(texels).map_err(refuse)?;
    let warning = (negative > 0).then(|| format!("{}: {negative} texels are negative and count as black", path.display()));
    Ok(LoadedMap { map: RadianceMap::new(width, height, texels), warning })
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

/// Width, height and colours of an image.
fn colors(image: ExrImage) -> std::result::Result<(u32, u32, Vec<[f32; 3]>), String> {
    let (width, height) = (image.width, image.height);
    if image.crop != (Crop { x0: 0, y0: 0, x1: width, y1: height }) {
        return Err("it holds a part of a picture only".into());
    }
    let [r, g, b] = rgb(&image).ok_or("it has no channels R, G and B")?;
    Ok((width, height, r.iter().zip(g).zip(b).map(|((&r, &g), &b)| [r, g, b]).collect()))
}

fn rgb(image: &ExrImage) -> Option<[&[f32]; 3]> {
    let of = |prefix: &str| {
        let channel = |name: &str| image.channel(&format!("{prefix}{name}"));
        Some([channel("R")?, channel("G")?, channel("B")?])
    };
    let mut prefixes = image.layers.iter().filter_map(|layer| layer.name.strip_suffix('R'));
    let grey = || Some([image.channel("Y")?; 3]);
    of("").or_else(|| prefixes.find_map(of)).or_else(grey)
}

/// The texels, negative ones made black, and how many those were.
fn checked(mut texels: Vec<[f32; 3]>) -> std::result::Result<(Vec<[f32; 3]>, usize), String> {
    let wrong = texels.iter().filter(|texel| !texel.iter().all(|lane| lane.abs() <= RadianceMap::BRIGHTEST)).count();
    if wrong > 0 {
        let (all, most) = (texels.len(), RadianceMap::BRIGHTEST);
        return Err(format!("{wrong} of its {all} texels are not finite or beyond {most:e}"));
    }
    let mut negative = 0;
    for texel in &mut texels {
        if texel.iter().any(|&lane| lane < 0.0) {
            negative += 1;
            *texel = texel.map(|lane| lane.max(0.0));
        }
    }
    Ok((texels, negative))
}
