//! Converts films to images: EXR with every layer and the report in its header, and PNG for viewing.

use super::aov::Source;
use super::{Aov, LoadedScene, Outputs, Provenance, RenderReport, RenderSettings};
use crate::error::Result;
use crate::film::pyramid::{Pyramid, RECORD, encode};
use crate::film::{Film, Plane};
use crate::integrator;
use crate::io::exr::{self, Attribute, Layer};
use crate::io::png;
use std::path::Path;

/// Instance and material indices at the pixel centres.
pub type Ids = [Vec<f32>; 2];

/// Whether the image needs the scene besides the film, since films hold no instance or material indices.
pub fn needs_ids(aovs: &[Aov]) -> bool {
    aovs.iter().any(|aov| matches!(aov.source(), Source::InstanceIds | Source::MaterialIds))
}

/// Computes the instance and material indices, if layers of the image show them.
///
/// # Errors
/// The camera does not exist.
pub fn ids(stage: &LoadedScene, settings: &RenderSettings) -> Result<Option<Ids>> {
    if !needs_ids(&settings.aovs) {
        return Ok(None);
    }
    let camera = settings.camera_in(&stage.scene)?;
    Ok(Some(integrator::ids(&stage.scene, &camera, &settings.layout())))
}

/// Writes the images of `outputs`. The EXR image holds `layers`.
///
/// # Errors
/// A file cannot be written.
pub fn write(
    outputs: &Outputs,
    provenance: &Provenance,
    film: &Film,
    layers: &[Layer],
    report: &RenderReport,
) -> Result<()> {
    let settings = &provenance.settings;
    let layout = settings.layout();
    if let Some(path) = &outputs.exr {
        let record = Pyramid::of_film(film, settings.method.kind().independent());
        let record = record.map(|pyramid| (RECORD.to_owned(), Attribute::Text(encode(&pyramid))));
        let attributes: Vec<_> = report.attributes().into_iter().chain(record).collect();
        exr::write(path, layout.width, layout.height, settings.crop, layers, &attributes)?;
    }
    let labels = report.labels();
    outputs.png.as_ref().map_or(Ok(()), |path| write_png(path, provenance, film, &labels))
}

/// Writes the PNG image, with `labels` in its header.
///
/// # Errors
/// The file cannot be written.
pub fn write_png(path: &Path, provenance: &Provenance, film: &Film, labels: &[(&str, &str)]) -> Result<()> {
    let (crop, look) = (film.layout().crop, provenance.look);
    let alpha = provenance.settings.transparent.then(|| film.mean(Plane::Alpha));
    let (width, height, rgb) = (crop.x1 - crop.x0, crop.y1 - crop.y0, film.mean(Plane::Color));
    let picture = png::PngPicture { width, height, rgb: &rgb, alpha: alpha.as_deref() };
    png::write(path, picture, look.exposure, look.curve, labels)
}

/// Returns all layers of the EXR image: colour, alpha if asked for, the standard error of colour, and the AOVs.
pub fn layers(provenance: &Provenance, film: &Film, ids: Option<&Ids>) -> Vec<Layer> {
    let settings = &provenance.settings;
    let mut layers = split(&["R", "G", "B"], &film.mean(Plane::Color));
    if settings.transparent {
        layers.extend(split(&["A"], &film.mean(Plane::Alpha)));
    }
    if let Some(error) = film.standard_error() {
        layers.extend(split(&["stderr.R", "stderr.G", "stderr.B"], &error));
    }
    for aov in &settings.aovs {
        let values = match (aov.source(), ids) {
            (Source::Plane(plane), _) => film.mean(plane),
            (Source::OwnedTiles, _) => owned(provenance, film),
            (Source::InstanceIds, Some([instances, _])) => instances.clone(),
            (Source::MaterialIds, Some([_, materials])) => materials.clone(),
            (Source::InstanceIds | Source::MaterialIds, None) => continue,
        };
        layers.extend(split(aov.channels(), &values));
    }
    layers
}

/// Mask of the pixels where one chain brought most of the light; all 0 for a method without chains.
fn owned(provenance: &Provenance, film: &Film) -> Vec<f32> {
    let chains = &provenance.work.passes.chains;
    chains.as_ref().map_or_else(|| vec![0.0; film.layout().pixels()], |chains| chains.tiles.owned_pixels(film.layout()))
}

/// Splits pixel-interleaved values into one layer per channel.
pub(crate) fn split(names: &[&str], values: &[f32]) -> Vec<Layer> {
    let channel = |at: usize| values.iter().skip(at).step_by(names.len()).copied().collect();
    names.iter().enumerate().map(|(at, &name)| Layer { name: name.into(), values: channel(at) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_are_taken_apart_in_order() {
        let layers = split(&["a.X", "a.Y"], &[1.0, 2.0, 3.0, 4.0]);
        assert_eq!(layers.iter().map(|l| l.name.as_str()).collect::<Vec<_>>(), ["a.X", "a.Y"]);
        assert_eq!(layers.into_iter().map(|l| l.values).collect::<Vec<_>>(), [[1.0, 3.0], [2.0, 4.0]]);
    }

    #[test]
    fn only_identifiers_need_the_scene() {
        assert!(needs_ids(&[Aov::Depth, Aov::Material]));
        assert!(!needs_ids(&[Aov::Depth, Aov::Invalid]));
    }
}
