//! OpenEXR output: single-part 32-bit float images with named channels, the picture of record. Colour is in `R`, `G`,
//! `B` (, `A`), everything else in `name.channel`. A crop is the data window inside the display window of the full
//! image.
//!
//! The reader also accepts foreign files: half and integer channels, tiles, several parts of one size. It rejects deep
//! and subsampled images, and compression that the `exr` crate lacks (DWAA, DWAB).

use super::atomic::write_atomically;
use crate::error::{Error, Kind, Result};
use crate::film::Crop;
use ::exr::prelude as openexr;
use openexr::{AttributeValue, IntegerBounds, Text, Vec2, WritableImage};
use std::collections::BTreeSet;
use std::io;
use std::path::Path;

mod read;

pub use read::{ExrImage, read};

/// A channel with its values, row by row in the data window.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// The channel's name: `R`, `stderr.R`, `depth.Z`.
    pub name: String,
    /// Its values.
    pub values: Vec<f32>,
}

/// A header entry.
#[derive(Debug, Clone, PartialEq)]
pub enum Attribute {
    /// UTF-8 text.
    Text(String),
    /// A floating-point number.
    Float(f32),
    /// An integer.
    Int(i32),
}

/// Writes an image of `width` × `height` with the data window `crop` (`None` for the full image), ZIP-compressed, with
/// Rec. 709 primaries.
///
/// # Errors
/// [`Kind::Output`] with the path if the file cannot be written. [`Kind::Internal`] if the number of a layer's values
/// is not that of the pixels in the data window, a name is empty or duplicate, or the crop is not inside the image.
pub fn write(
    path: &Path,
    width: u32,
    height: u32,
    crop: Option<Crop>,
    layers: &[Layer],
    attributes: &[(String, Attribute)],
) -> Result<()> {
    let image = image(width, height, crop, layers, attributes)
        .map_err(|what| Error::new(Kind::Internal, format!("cannot make {}: {what}", path.display())))?;
    write_atomically(path, |file| image.write().to_unbuffered(file).map_err(into_io))
}

/// Hashes an image's pixels: size, crop, and the channels sorted by name, with little-endian f32 values. The hash is
/// independent of the layer order, so that a film and its file give the same one.
pub fn hash_pixels(width: u32, height: u32, crop: Option<Crop>, layers: &[Layer]) -> String {
    let crop = crop.unwrap_or(Crop { x0: 0, y0: 0, x1: width, y1: height });
    let mut hasher = blake3::Hasher::new();
    for number in [width, height, crop.x0, crop.y0, crop.x1, crop.y1] {
        hasher.update(&number.to_le_bytes());
    }
    let mut sorted: Vec<&Layer> = layers.iter().collect();
    sorted.sort_by(|a, b| a.name.cmp(&b.name));
    for layer in sorted {
        hasher.update(&(layer.name.len() as u64).to_le_bytes()).update(layer.name.as_bytes());
        hasher.update(&(layer.values.len() as u64).to_le_bytes());
        for run in layer.values.chunks(4096) {
            let bytes: Vec<u8> = run.iter().flat_map(|v| v.to_le_bytes()).collect();
            hasher.update(&bytes);
        }
    }
    hasher.finalize().to_hex().to_string()
}

type Image = openexr::Image<openexr::Layer<openexr::AnyChannels<openexr::FlatSamples>>>;

fn image(
    width: u32,
    height: u32,
    crop: Option<Crop>,
    layers: &[Layer],
    attributes: &[(String, Attribute)],
) -> std::result::Result<Image, String> {
    let crop = crop.unwrap_or(Crop { x0: 0, y0: 0, x1: width, y1: height });
    let is_inside = crop.x0 < crop.x1 && crop.x1 <= width && crop.y0 < crop.y1 && crop.y1 <= height;
    if !is_inside || width.max(height) > i32::MAX as u32 {
        return Err(format!("crop {crop:?} of an image of {width}×{height}"));
    }
    let size = Vec2((crop.x1 - crop.x0) as usize, (crop.y1 - crop.y0) as usize);
    let mut own =
        openexr::LayerAttributes { layer_position: Vec2(crop.x0 as i32, crop.y0 as i32), ..Default::default() };
    for (name, value) in attributes {
        if own.other.insert(text(name)?, encoded(value)).is_some() {
            return Err(format!("attribute {name} comes twice"));
        }
    }
    let channels = channels(layers, size)?;
    let layer = openexr::Layer::new(
        size,
        own,
        openexr::Encoding { compression: openexr::Compression::ZIP16, ..openexr::Encoding::UNCOMPRESSED },
        channels,
    );
    let display = IntegerBounds::new(Vec2(0, 0), Vec2(width as usize, height as usize));
    let mut shared = openexr::ImageAttributes::new(display);
    shared.chromaticities = Some(REC_709);
    Ok(openexr::Image { attributes: shared, layer_data: layer })
}

/// ITU-R BT.709 primaries and D65.
const REC_709: ::exr::meta::attribute::Chromaticities = ::exr::meta::attribute::Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.30, 0.60),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.3290),
};

fn channels(
    layers: &[Layer],
    size: Vec2<usize>,
) -> std::result::Result<openexr::AnyChannels<openexr::FlatSamples>, String> {
    let mut names = BTreeSet::new();
    let mut list = Vec::with_capacity(layers.len());
    for layer in layers {
        if !names.insert(&layer.name) {
            return Err(format!("channel {} comes twice", layer.name));
        }
        if layer.values.len() != size.area() {
            return Err(format!("channel {} has {} values for {size:?} pixels", layer.name, layer.values.len()));
        }
        list.push(openexr::AnyChannel::new(text(&layer.name)?, openexr::FlatSamples::F32(layer.values.clone())));
    }
    if list.is_empty() {
        return Err("no channels".into());
    }
    Ok(openexr::AnyChannels::sort(list.into_iter().collect()))
}

/// Encodes a name in UTF-8, as other programs do.
fn text(name: &str) -> std::result::Result<Text, String> {
    let is_valid = !name.is_empty() && name.len() < 256 && !name.contains('\0');
    is_valid.then(|| Text::from_slice_unchecked(name.as_bytes())).ok_or_else(|| format!("{name:?} is not a name"))
}

fn encoded(value: &Attribute) -> AttributeValue {
    match value {
        Attribute::Text(text) => AttributeValue::Text(Text::from_slice_unchecked(text.as_bytes())),
        Attribute::Float(x) => AttributeValue::F32(*x),
        Attribute::Int(i) => AttributeValue::I32(*i),
    }
}

fn into_io(error: openexr::Error) -> io::Error {
    match error {
        openexr::Error::Io(cause) => cause,
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn layers(pixels: usize) -> Vec<Layer> {
        let names = ["R", "G", "B", "stderr.R", "depth.Z"];
        let values = |c: usize| (0..pixels).map(|i| (i * 7 + c) as f32 * 0.37 - 3.0).collect();
        names.iter().enumerate().map(|(c, name)| Layer { name: (*name).into(), values: values(c) }).collect()
    }

    #[test]
    fn round_trips_values_crop_and_attributes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let attributes = [
            ("etendue.note".to_string(), Attribute::Text("rendered by étendue".into())),
            ("etendue.relmse".to_string(), Attribute::Float(0.125)),
            ("etendue.passes".to_string(), Attribute::Int(64)),
        ];
        for crop in [None, Some(Crop { x0: 3, y0: 5, x1: 20, y1: 39 })] {
            let pixels = crop.map_or(33 * 47, |_| 17 * 34);
            write(&path, 33, 47, crop, &layers(pixels), &attributes).unwrap();
            let image = read(&path).unwrap();
            assert_eq!((image.width, image.height), (33, 47));
            assert_eq!(image.crop, crop.unwrap_or(Crop { x0: 0, y0: 0, x1: 33, y1: 47 }));
            assert_eq!(image.attributes, attributes.iter().cloned().collect::<BTreeMap<_, _>>());
            for layer in layers(pixels) {
                assert_eq!(image.channel(&layer.name), Some(&layer.values[..]));
            }
            assert_eq!(image.hash_pixels(), hash_pixels(33, 47, crop, &layers(pixels)));
        }
    }

    #[test]
    fn pixel_hash_depends_on_every_bit_but_not_on_layer_order() {
        let base = layers(6);
        let hash = |layers: &[Layer]| hash_pixels(3, 2, None, layers);
        let mut reversed = base.clone();
        reversed.reverse();
        assert_eq!(hash(&reversed), hash(&base));
        let mut flipped = base.clone();
        flipped[3].values[5] = f32::from_bits(flipped[3].values[5].to_bits() ^ 1);
        let mut renamed = base.clone();
        renamed[3].name = "stderr.Q".into();
        for other in [hash(&flipped), hash(&renamed), hash_pixels(2, 3, None, &base), hash(&base[1..])] {
            assert_ne!(other, hash(&base));
        }
    }

    #[test]
    fn invalid_images_are_not_written() {
        let (path, crop) = (Path::new("a.exr"), Crop { x0: 0, y0: 0, x1: 4, y1: 2 });
        let twice = [layers(6), layers(6)].concat();
        for (crop, layers) in [(None, layers(5)), (None, twice), (Some(crop), layers(8)), (None, Vec::new())] {
            assert_eq!(write(path, 3, 2, crop, &layers, &[]).unwrap_err().kind, Kind::Internal);
        }
        let missing = write(Path::new("no/folder/a.exr"), 3, 2, None, &layers(6), &[]).unwrap_err();
        assert!(missing.kind == Kind::Output && missing.chain().contains("no/folder/a.exr"));
    }
}
