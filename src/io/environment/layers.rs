//! Selects the colour channels of an EXR file: those of the named layer or part, or the most likely ones.

use super::super::exr::ExrImage;
use super::super::primaries::Primaries;
use super::Picture;
use crate::film::Crop;
use glam::DMat3;

/// The largest finite 16-bit float.
const LARGEST_HALF: f32 = 65504.0;

/// Channels that form a picture, by index.
struct Layer {
    /// Prefix of its channel names, without the dot.
    name: String,
    channels: [usize; 3],
}

/// Returns the texels of the layer `wanted`, or of the most likely one.
pub(super) fn picture(image: ExrImage, wanted: Option<&str>) -> Result<Picture, String> {
    let (width, height) = (image.width, image.height);
    if image.crop != (Crop { x0: 0, y0: 0, x1: width, y1: height }) {
        return Err("it holds a part of a picture only".into());
    }
    let layers = layers(&image);
    let chosen = match wanted {
        Some(wanted) => named(&layers, &image, wanted)?,
        None => likely(&layers).ok_or("it has no channels R, G and B")?,
    };
    let [r, g, b] = chosen.channels.map(|c| &image.layers[c].values);
    let texels = r.iter().zip(g).zip(b).map(|((&r, &g), &b)| [r, g, b]).collect();
    let is_grey = chosen.channels[0] == chosen.channels[1];
    let primaries = image.primaries.filter(|_| !is_grey);
    let to_rec_709 = primaries.map_or(Some(DMat3::IDENTITY), Primaries::to_rec_709);
    let to_rec_709 = to_rec_709.ok_or("its chromaticities make no colours")?;
    let largest = chosen.channels.iter().all(|&c| image.half[c]).then_some(LARGEST_HALF);
    Ok(Picture { width, height, texels, to_rec_709, largest, said: said(&layers, chosen, wanted) })
}

/// Notes the selected layer, if there is more than the plain picture.
fn said(layers: &[Layer], chosen: &Layer, wanted: Option<&str>) -> Option<String> {
    let name =
        |layer: &Layer| if layer.name.is_empty() { "the plain channels".into() } else { format!("'{}'", layer.name) };
    if layers.len() == 1 && chosen.name.is_empty() {
        return None;
    }
    let all: Vec<String> = layers.iter().map(name).collect();
    let hint = if wanted.is_some() || layers.len() == 1 { "" } else { "; --env-layer takes another" };
    Some(format!("of its layers ({}) {} is taken{hint}", all.join(", "), name(chosen)))
}

/// Returns all layers with red, green and blue, or with luminance, in the file's order.
fn layers(image: &ExrImage) -> Vec<Layer> {
    let place = |name: &str| image.layers.iter().position(|layer| layer.name == name);
    let mut found: Vec<Layer> = Vec::new();
    for channel in &image.layers {
        let (prefix, last) = channel.name.rsplit_once('.').unwrap_or(("", &channel.name));
        if !matches!(last, "R" | "Y") || found.iter().any(|layer| layer.name == prefix) {
            continue;
        }
        let of = |last: &str| place(&if prefix.is_empty() { last.to_owned() } else { format!("{prefix}.{last}") });
        let colors = || Some([of("R")?, of("G")?, of("B")?]);
        // Positions have channels X, Y and Z; Y alone is luminance.
        let grey = || Some([of("Y").filter(|_| of("Z").is_none())?; 3]);
        if let Some(channels) = colors().or_else(grey) {
            found.push(Layer { name: prefix.to_owned(), channels });
        }
    }
    found
}

/// Selects the plain channels; else Blender's Combined, the beauty pass of other programs, or the first layer. Colour
/// is preferred to luminance.
fn likely(layers: &[Layer]) -> Option<&Layer> {
    let is_grey = |layer: &Layer| layer.channels[0] == layer.channels[1];
    let last = |layer: &Layer| layer.name.rsplit('.').next().unwrap_or_default().to_ascii_lowercase();
    let rank = |layer: &&Layer| match last(layer).as_str() {
        "" => 0,
        "combined" => 1,
        "beauty" | "rgba" | "rgb" => 2,
        _ => 3,
    };
    layers.iter().min_by_key(|layer| (is_grey(layer), rank(layer)))
}

/// Finds the layer with that name, or whose name ends or begins with it. The first part also matches by its own name.
fn named<'a>(layers: &'a [Layer], image: &ExrImage, wanted: &str) -> Result<&'a Layer, String> {
    let full = |layer: &Layer| layer.name == wanted;
    let first = |layer: &Layer| layer.name.is_empty() && (image.part.as_deref() == Some(wanted) || wanted == "RGB");
    let end = |layer: &Layer| layer.name.strip_suffix(wanted).is_some_and(|rest| rest.ends_with('.'));
    let begin = |layer: &Layer| layer.name.strip_prefix(wanted).is_some_and(|rest| rest.starts_with('.'));
    let tests: [&dyn Fn(&Layer) -> bool; 4] = [&full, &first, &end, &begin];
    let found = tests.iter().find_map(|test| layers.iter().find(|layer| test(layer)));
    found.ok_or_else(|| {
        let names = layers.iter().map(|layer| if layer.name.is_empty() { "RGB" } else { &layer.name });
        format!("it has no layer '{wanted}' with colours; it has {}", names.collect::<Vec<_>>().join(", "))
    })
}
