//! The result of a session or a merge: all data needed for images and reports. It holds no scene, so that the next one
//! can be rendered while this one is written.

use super::images::{self, Ids};
use super::loaded_scene::LoadTimings;
use super::target::Check;
use super::{Outputs, Provenance, RenderReport, checkpoint};
use crate::error::Result;
use crate::film::Film;
use std::path::Path;

/// A film with the data for its images and report.
pub struct Rendered {
    /// Its provenance.
    pub provenance: Provenance,
    /// The film.
    pub film: Film,
    /// Instance and material indices, if the image shows them: films do not hold them.
    pub ids: Option<Ids>,
    /// Loading and building times, if a scene was loaded.
    pub preparation: Option<LoadTimings>,
    /// The last look at the error, if there is a target.
    pub check: Option<Check>,
}

impl Rendered {
    /// Writes the film and the images of `outputs`. Returns the report.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, outputs: &Outputs) -> Result<RenderReport> {
        outputs.film.as_ref().map_or(Ok(()), |path| self.save(path))?;
        let Rendered { provenance, film, .. } = self;
        let layers = images::layers(provenance, film, self.ids.as_ref());
        let report =
            RenderReport::new(provenance, film, &layers, outputs, self.preparation).with_target(self.check.as_ref());
        images::write(outputs, provenance, film, &layers, &report)?;
        Ok(report)
    }

    /// Writes the film, so that it can be merged or resumed.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, path: &Path) -> Result<()> {
        checkpoint::save(path, &self.provenance, &self.film)
    }
}
