//! Detects the output of an earlier run: nothing usable, a partial film to continue, or a complete result. A farm may
//! thus run the same command again after any failure.

use super::report::IDENTITY;
use super::{Outputs, Provenance, checkpoint};
use crate::film::Film;
use crate::io::exr::{self, Attribute};
use crate::io::png;
use std::path::Path;

/// Output of an earlier run.
pub enum ExistingOutput {
    /// Nothing usable.
    Nothing,
    /// A film of the same picture that lacks passes, with its provenance.
    Part(Box<Provenance>, Film),
    /// The complete output.
    All,
}

impl ExistingOutput {
    /// Looks for the output of `wanted` in `outputs`. Files that are unreadable, or belong to another picture, count as
    /// nothing.
    pub fn at(outputs: &Outputs, wanted: &Provenance) -> ExistingOutput {
        if outputs.image().is_some_and(|path| is_image_of(path, wanted)) && outputs.paths().all(Path::is_file) {
            return ExistingOutput::All;
        }
        let Some(path) = outputs.checkpoint().filter(|path| path.is_file()) else { return ExistingOutput::Nothing };
        let Ok((provenance, film)) = checkpoint::restore(&path) else { return ExistingOutput::Nothing };
        if provenance.same_picture(wanted).is_err() {
            return ExistingOutput::Nothing;
        }
        let is_film_alone = outputs.paths().all(|output| output == path);
        let has_all = wanted.plan.is_met_by(film.passes());
        if is_film_alone && has_all { ExistingOutput::All } else { ExistingOutput::Part(Box::new(provenance), film) }
    }
}

/// Whether the image at `path` is complete and identical to the one that `wanted` would produce.
fn is_image_of(path: &Path, wanted: &Provenance) -> bool {
    let is_png = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
    let found = if is_png { png::label(path, IDENTITY) } else { exr_label(path) };
    found == Some(wanted.identity())
}

fn exr_label(path: &Path) -> Option<String> {
    match exr::read(path).ok()?.attributes.remove(IDENTITY) {
        Some(Attribute::Text(text)) => Some(text),
        _ => None,
    }
}
