//! Files of what techniques of bidirectional path tracing find on their own: an EXR image with layers `s1t2.weighted.R` and
//! `s1t2.unweighted.R` (and so on) for 1 vertex from the light and 2 from the camera, and a sheet of all of them as PNG.

mod canvas;
mod sheet;

use super::Provenance;
use super::images::split;
use super::report::flatten;
use crate::error::{Error, Result};
use crate::film::{Film, Plane};
use crate::integrator::{TechniqueImage, TechniqueImages};
use crate::io::exr::{self, Layer};
use crate::io::png;
use std::path::{Path, PathBuf};

/// The files to write.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TechniqueFiles {
    /// Every image, as layers.
    pub exr: PathBuf,
    /// All of them to look at.
    pub png: PathBuf,
}

impl TechniqueFiles {
    /// The EXR image at `path` and the sheet beside it.
    ///
    /// # Errors
    /// A usage error for another ending than `.exr`.
    pub fn of(path: &Path) -> Result<Self> {
        if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("exr")) {
            return Ok(TechniqueFiles { exr: path.to_owned(), png: path.with_extension("png") });
        }
        Err(Error::usage(format!("{}: the images of techniques must end in .exr", path.display())))
    }

    /// Both.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        [&self.exr, &self.png].into_iter().map(PathBuf::as_path)
    }
}

/// Writes the images of a render with that provenance; the sheet looks as its PNG image does.
///
/// # Errors
/// A file that cannot be written.
pub fn write(files: &TechniqueFiles, provenance: &Provenance, images: &TechniqueImages) -> Result<()> {
    let settings = &provenance.settings;
    exr::write(&files.exr, settings.width, settings.height, settings.crop, &layers(images), &attributes(provenance, images))?;
    let sheet = sheet::draw(images, provenance.look);
    png::write_colors(&files.png, sheet.width as u32, sheet.height as u32, &sheet.colors)
}

/// Where the images come from, as the header of a render says it.
fn attributes(provenance: &Provenance, images: &TechniqueImages) -> Vec<(String, exr::Attribute)> {
    let passes = images.images.first().map(|image| image.weighted.passes().to_string());
    let mut attributes = Vec::new();
    let document = serde_json::json!({
        "program": provenance.program,
        "scene": { "hash": provenance.scene.hash },
        "settings": provenance.settings,
        "settings_hash": provenance.settings.hash(),
        "passes": passes,
        "rays": images.report.rays,
        "guards": images.report.guards,
    });
    flatten("etendue", &document, &mut attributes);
    attributes
}

/// All layers, shorter paths first.
pub fn layers(images: &TechniqueImages) -> Vec<Layer> {
    images
        .images
        .iter()
        .flat_map(|image| {
            [("weighted", &image.weighted), ("unweighted", &image.unweighted)].map(|(kind, film)| named(image, kind, film))
        })
        .flatten()
        .collect()
}

fn named(image: &TechniqueImage, kind: &str, film: &Film) -> Vec<Layer> {
    let names = ["R", "G", "B"].map(|lane| format!("s{}t{}.{kind}.{lane}", image.s, image.t));
    split(&names.each_ref().map(String::as_str), &film.mean(Plane::Color))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sheet_lies_beside_the_image() {
        let files = TechniqueFiles::of(Path::new("a/b.c.EXR")).unwrap();
        assert_eq!(files.png, Path::new("a/b.c.png"));
        for wrong in ["a", "a.png", ".exr"] {
            assert!(TechniqueFiles::of(Path::new(wrong)).is_err(), "{wrong}");
        }
    }
}
