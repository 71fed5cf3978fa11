//! What a session or a merge leaves: all that images and reports are made of. It holds no scene, so that the next one can be rendered
//! while this is written.

use super::images::{self, Ids};
use super::stage::Preparation;
use super::target::Check;
use super::{Outputs, Provenance, Report, checkpoint};
use crate::error::Result;
use crate::film::Film;
use std::path::Path;

/// A film with everything that is said of it.
pub struct Rendered {
    /// Where it comes from.
    pub provenance: Provenance,
    /// The sums.
    pub film: Film,
    /// Numbers of instances and materials, if the image is to have them: they are not in films.
    pub ids: Option<Ids>,
    /// What it took until the scene was ready, if one was loaded for it.
    pub preparation: Option<Preparation>,
    /// The last look at the error, where there is a target.
    pub check: Option<Check>,
}

impl Rendered {
    /// Writes the film and the images of `outputs`; what is to be reported.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, outputs: &Outputs) -> Result<Report> {
        outputs.film.as_ref().map_or(Ok(()), |path| self.save(path))?;
        let Rendered { provenance, film, .. } = self;
        let layers = images::layers(provenance, film, self.ids.as_ref());
        let report = Report::new(provenance, film, &layers, outputs, self.preparation).with_target(self.check.as_ref());
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
