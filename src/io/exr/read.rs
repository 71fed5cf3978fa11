//! Reads OpenEXR files of any origin.

use super::super::primaries::Primaries;
use super::{Attribute, Layer, hash_pixels};
use crate::error::{Error, Result};
use crate::film::Crop;
use ::exr::meta::BlockDescription;
use ::exr::meta::MetaData;
use ::exr::meta::header::Header;
use ::exr::prelude as openexr;
use openexr::{AttributeValue, FlatSamples, ReadChannels, ReadLayers, Text, Vec2};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Seek};
use std::path::Path;

/// Decoded pixels may take this many times the file's size, or at least [`LEAST_BUDGET`]. No real picture is compressed
/// further, and a small hostile file cannot exhaust the memory.
const MOST_EXPANSION: u64 = 4096;
const LEAST_BUDGET: u64 = 1 << 28;

/// A decoded image.
#[derive(Debug, Clone, PartialEq)]
pub struct ExrImage {
    /// Width of the full image: the display window, enlarged to contain the data window of foreign files.
    pub width: u32,
    /// Height of the full image.
    pub height: u32,
    /// The data window.
    pub crop: Crop,
    /// All channels as f32, in the file's order. Channels of later parts are named `part.channel`.
    pub layers: Vec<Layer>,
    /// Whether each of `layers` is stored in 16 bits.
    pub half: Vec<bool>,
    /// The name of the first part, if it has one.
    pub part: Option<String>,
    /// Primaries and white of the channels, if the file states them.
    pub primaries: Option<Primaries>,
    /// Text and number attributes beyond those of the format.
    pub attributes: BTreeMap<String, Attribute>,
}

impl ExrImage {
    /// Returns the values of a channel, row by row in the data window.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.layers.iter().find(|layer| layer.name == name).map(|layer| &layer.values[..])
    }

    /// Returns the channels `prefix`R, G and B, interleaved; `None` without one of them.
    pub fn rgb(&self, prefix: &str) -> Option<Vec<f32>> {
        let channel = |name: &str| self.channel(&format!("{prefix}{name}"));
        let (r, g, b) = (channel("R")?, channel("G")?, channel("B")?);
        Some(r.iter().zip(g).zip(b).flat_map(|((&r, &g), &b)| [r, g, b]).collect())
    }

    /// See [`hash_pixels`].
    pub fn hash_pixels(&self) -> String {
        hash_pixels(self.width, self.height, Some(self.crop), &self.layers)
    }
}

/// Reads all channels of an image.
///
/// # Errors
/// [`crate::error::Kind::Scene`] with the path if the file is missing, damaged, of an unsupported kind, or claims more
/// pixels than it can hold.
pub fn read(path: &Path) -> Result<ExrImage> {
    let file = File::open(path).map_err(|cause| Error::read(path, cause))?;
    let refuse = |what: String| Error::scene(format!("cannot read {}: {what}", path.display()));
    let size = file.metadata().map_err(|cause| Error::read(path, cause))?.len();
    let mut file = BufReader::new(file);
    let meta = MetaData::read_from_buffered(&mut file, false).map_err(|cause| Error::read(path, cause))?;
    let window = check(&meta.headers, size).map_err(refuse)?;
    file.rewind().map_err(|cause| Error::read(path, cause))?;
    let reader = openexr::read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    let image = reader.from_buffered(file).map_err(|cause| Error::read(path, cause))?;
    Ok(convert(image, window))
}

/// Data window and size of the full image, translated so that the display window begins at (0, 0).
struct Window {
    width: u32,
    height: u32,
    crop: Crop,
}

fn check(headers: &[Header], file_size: u64) -> std::result::Result<Window, String> {
    let first = headers.first().ok_or("it has no image")?;
    for header in headers {
        if header.deep {
            return Err("deep images are not supported".into());
        }
        if header.layer_size != first.layer_size
            || header.own_attributes.layer_position != first.own_attributes.layer_position
        {
            return Err("its parts have different data windows".into());
        }
        if header.channels.list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
            return Err("subsampled channels are not supported".into());
        }
    }
    let channels: u64 = headers.iter().map(|h| h.channels.list.len() as u64).sum();
    let Vec2(w, h) = first.layer_size;
    let decoded = (w as u64).checked_mul(h as u64).and_then(|n| n.checked_mul(channels)).and_then(|n| n.checked_mul(4));
    let budget = file_size.saturating_mul(MOST_EXPANSION).max(LEAST_BUDGET);
    if headers.iter().any(|header| block_bytes(header).is_none_or(|bytes| bytes > budget)) {
        return Err(format!("its blocks are larger than {file_size} bytes can hold"));
    }
    match decoded {
        Some(0) => Err("it has no pixels".into()),
        Some(bytes) if bytes <= budget => window(first),
        _ => Err(format!("it claims {w}×{h} pixels of {channels} channels, more than {file_size} bytes can hold")),
    }
}

/// Returns the bytes of a block, which the decoder holds as a whole however little of it lies in the image; `None`
/// beyond u64.
fn block_bytes(header: &Header) -> Option<u64> {
    let Vec2(width, height) = match header.blocks {
        BlockDescription::Tiles(tiles) => tiles.tile_size,
        BlockDescription::ScanLines => Vec2(header.layer_size.width(), header.compression.scan_lines_per_block()),
    };
    let pixels = (width as u64).checked_mul(height as u64)?;
    pixels.checked_mul(header.channels.bytes_per_pixel as u64)
}

fn window(header: &Header) -> std::result::Result<Window, String> {
    let too_far = || "its windows lie too far out".to_string();
    let display = header.shared_attributes.display_window;
    let axis = |data: i32, data_size: usize, display: i32, display_size: usize| {
        let start = i64::from(data.min(display));
        let end = (i64::from(data) + data_size as i64).max(i64::from(display) + display_size as i64);
        let at = |x: i64| u32::try_from(x - start).ok();
        Some([at(i64::from(data))?, at(i64::from(data) + data_size as i64)?, at(end)?])
    };
    let (position, size) = (header.own_attributes.layer_position, header.layer_size);
    let [x0, x1, width] = axis(position.0, size.0, display.position.0, display.size.0).ok_or_else(too_far)?;
    let [y0, y1, height] = axis(position.1, size.1, display.position.1, display.size.1).ok_or_else(too_far)?;
    Ok(Window { width, height, crop: Crop { x0, y0, x1, y1 } })
}

fn convert(image: openexr::FlatImage, window: Window) -> ExrImage {
    let mut attributes = BTreeMap::new();
    let (mut layers, mut half) = (Vec::new(), Vec::new());
    let part = image.layer_data.first().and_then(|part| part.attributes.layer_name.as_ref().map(decoded));
    let primaries = image.attributes.chromaticities.map(|c| {
        Primaries(
            [c.red, c.green, c.blue, c.white]
                .map(|xy| [xy.0, xy.1].map(f64::from))
                .as_flattened()
                .try_into()
                .unwrap_or_default(),
        )
    });
    collect(&mut attributes, image.attributes.other);
    for (index, part) in image.layer_data.into_iter().enumerate() {
        let name = part.attributes.layer_name.as_ref().map_or_else(|| index.to_string(), decoded);
        collect(&mut attributes, part.attributes.other);
        for channel in part.channel_data.list {
            let plain = decoded(&channel.name);
            let name = if index == 0 { plain } else { format!("{name}.{plain}") };
            half.push(matches!(channel.sample_data, FlatSamples::F16(_)));
            layers.push(Layer { name, values: floats(channel.sample_data) });
        }
    }
    ExrImage {
        width: window.width,
        height: window.height,
        crop: window.crop,
        layers,
        half,
        part,
        primaries,
        attributes,
    }
}

fn floats(samples: FlatSamples) -> Vec<f32> {
    match samples {
        FlatSamples::F32(values) => values,
        FlatSamples::F16(values) => values.into_iter().map(|v| v.to_f32()).collect(),
        FlatSamples::U32(values) => values.into_iter().map(|v| v as f32).collect(),
    }
}

fn collect(into: &mut BTreeMap<String, Attribute>, from: impl IntoIterator<Item = (Text, AttributeValue)>) {
    for (name, value) in from {
        let value = match value {
            AttributeValue::Text(text) => Attribute::Text(decoded(&text)),
            AttributeValue::F32(x) => Attribute::Float(x),
            AttributeValue::F64(x) => Attribute::Float(x as f32),
            AttributeValue::I32(i) => Attribute::Int(i),
            _ => continue,
        };
        into.insert(decoded(&name), value);
    }
}

/// Decodes UTF-8, or Latin-1 if it is not valid UTF-8.
fn decoded(text: &Text) -> String {
    let bytes = text.bytes();
    std::str::from_utf8(bytes).map_or_else(|_| bytes.iter().map(|&b| char::from(b)).collect(), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Kind;
    use crate::stats::test_random::Random;
    use openexr::WritableImage;
    use std::fs;

    #[test]
    fn reads_offset_data_windows_and_half_floats() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let half: Vec<openexr::f16> = (0..12).map(|i| openexr::f16::from_f32(i as f32 * 0.5)).collect();
        let channels = vec![
            openexr::AnyChannel::new("A", FlatSamples::F16(half)),
            openexr::AnyChannel::new("id", FlatSamples::U32((0..12).collect())),
        ];
        let layer = openexr::Layer::new(
            (4, 3),
            openexr::LayerAttributes { layer_position: Vec2(-1, 2), ..Default::default() },
            openexr::Encoding::SMALL_LOSSLESS,
            openexr::AnyChannels::sort(channels.into_iter().collect()),
        );
        let shared = openexr::ImageAttributes::new(openexr::IntegerBounds::new(Vec2(0, 0), Vec2(8, 4)));
        openexr::Image { attributes: shared, layer_data: layer }.write().to_file(&path).unwrap();
        let image = read(&path).unwrap();
        assert_eq!((image.width, image.height), (9, 5));
        assert_eq!(image.crop, Crop { x0: 0, y0: 2, x1: 4, y1: 5 });
        assert_eq!(image.channel("A").unwrap()[5].to_bits(), 2.5_f32.to_bits());
        assert_eq!(image.channel("id").unwrap()[11].to_bits(), 11_f32.to_bits());
    }

    /// Damaged files give errors or different pixels, but never a panic.
    #[test]
    fn damage_does_not_panic() {
        let folder = tempfile::tempdir().unwrap();
        let (path, damaged) = (folder.path().join("a.exr"), folder.path().join("b.exr"));
        let layers =
            ["R", "G", "B"].map(|n| Layer { name: n.into(), values: (0..300).map(|i| (i % 17) as f32).collect() });
        super::super::write(&path, 20, 15, None, &layers, &[("note".into(), Attribute::Text("x".into()))]).unwrap();
        let bytes = fs::read(&path).unwrap();
        for length in (0..bytes.len()).step_by(bytes.len() / 50) {
            fs::write(&damaged, &bytes[..length]).unwrap();
            let error = read(&damaged).unwrap_err();
            assert!(error.kind == Kind::Scene && error.chain().contains("b.exr"), "{}", error.chain());
        }
        let mut random = Random::new(9);
        for i in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[i] ^= 1 << (random.bits() % 8);
            fs::write(&damaged, &changed).unwrap();
            let _ = read(&damaged);
        }
        assert!(read(&folder.path().join("none.exr")).unwrap_err().chain().contains("none.exr"));
    }
}
