//! Image files of the individual techniques of bidirectional path tracing. The EXR image has layers such as
//! `s1t2.weighted.R` and `s1t2.unweighted.R` for s = 1 light vertex and t = 2 camera vertices. A PNG sheet shows all of
//! them.

mod canvas;
mod sheet;

use crate::error::{Error, Result};
use crate::film::{Film, Plane};
use crate::integrator::{TechniqueImage, TechniqueImages};
use crate::io::exr::{self, Layer};
use crate::io::png;
use crate::session::Provenance;
use crate::session::images::split;
use crate::session::report::flatten;
use std::path::{Path, PathBuf};

/// Output files of the technique images.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TechniqueFiles {
    /// EXR image with all technique images as layers.
    pub exr: PathBuf,
    /// PNG sheet with all technique images.
    pub png: PathBuf,
}

impl TechniqueFiles {
    /// Returns the EXR image at `path` and the sheet beside it.
    ///
    /// # Errors
    /// A usage error for another ending than `.exr`.
    pub fn of(path: &Path) -> Result<Self> {
        if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("exr")) {
            return Ok(TechniqueFiles { exr: path.to_owned(), png: path.with_extension("png") });
        }
        Err(Error::usage(format!("{}: the images of techniques must end in .exr", path.display())))
    }

    /// Returns both paths.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        [&self.exr, &self.png].into_iter().map(PathBuf::as_path)
    }
}

/// Writes the technique images of a render. The sheet has the tone mapping of the render's PNG image.
///
/// # Errors
/// A file cannot be written.
pub fn write(files: &TechniqueFiles, provenance: &Provenance, images: &TechniqueImages) -> Result<()> {
    let settings = &provenance.settings;
    exr::write(
        &files.exr,
        settings.width,
        settings.height,
        settings.crop,
        &layers(images),
        &attributes(provenance, images),
    )?;
    let sheet = sheet::draw(images, provenance.look);
    png::write_colors(&files.png, sheet.width as u32, sheet.height as u32, &sheet.colors)
}

/// Provenance of the images, in the same form as in the header of a render.
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
            [("weighted", &image.weighted), ("unweighted", &image.unweighted)]
                .map(|(kind, film)| named(image, kind, film))
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
    fn technique_sheet_path_is_beside_the_image() {
        let files = TechniqueFiles::of(Path::new("a/b.c.EXR")).unwrap();
        assert_eq!(files.png, Path::new("a/b.c.png"));
        for wrong in ["a", "a.png", ".exr"] {
            assert!(TechniqueFiles::of(Path::new(wrong)).is_err(), "{wrong}");
        }
    }
}
