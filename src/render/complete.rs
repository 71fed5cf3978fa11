//! What an earlier run left: nothing of use, a film to go on with, or all that is wanted. So a farm may run the same command again
//! after whatever happened.

use super::{Outputs, Provenance, checkpoint};
use crate::film::Film;
use crate::io::exr::{self, Attribute};
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
        let image = outputs.exr.as_deref();
        if image.is_some_and(|path| is_image_of(path, wanted)) && outputs.paths().all(Path::is_file) {
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

/// Whether the image at `path` is what `wanted` would make.
fn is_image_of(path: &Path, wanted: &Provenance) -> bool {
    let Ok(image) = exr::read(path) else { return false };
    image.attributes.get("etendue.identity") == Some(&Attribute::Text(wanted.identity()))
}
