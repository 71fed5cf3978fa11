//! What an earlier run left: nothing of use, a film to go on with, or all that is wanted. So a farm may run the same command again
//! after whatever happened.

use super::report::IDENTITY;
use super::{Outputs, Provenance, checkpoint};
use crate::film::Film;
use crate::io::exr::{self, Attribute};
use crate::io::png;
use std::path::Path;

/// What was found where the results go.
pub enum Found {
    /// Nothing that helps.
    Nothing,
    /// A film of the same picture that lacks passes, with where it came from.
    Part(Box<Provenance>, Film),
    /// Everything.
    All,
}

impl Found {
    /// Looks for what `wanted` leaves in `outputs`. Files that cannot be read, or are of another picture, are nothing.
    pub fn at(outputs: &Outputs, wanted: &Provenance) -> Found {
        if outputs.image().is_some_and(|path| is_image_of(path, wanted)) && outputs.paths().all(Path::is_file) {
            return Found::All;
        }
        let Some(path) = outputs.checkpoint().filter(|path| path.is_file()) else { return Found::Nothing };
        let Ok((provenance, film)) = checkpoint::restore(&path) else { return Found::Nothing };
        if provenance.same_picture(wanted).is_err() {
            return Found::Nothing;
        }
        let is_film_alone = outputs.paths().all(|output| output == path);
        let has_all = wanted.plan.is_met_by(film.passes());
        if is_film_alone && has_all { Found::All } else { Found::Part(Box::new(provenance), film) }
    }
}

/// Whether the image at `path` is whole and what `wanted` would make.
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
