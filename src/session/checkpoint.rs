//! Periodic checkpoints of the film, so that a kill costs at most one minute of work by default.

use super::Provenance;
use super::film_file::{self, FilmFile};
use crate::error::{Error, Kind, Result};
use crate::film::Film;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Default interval between saves.
pub const INTERVAL: Duration = Duration::from_secs(60);

/// The interval between saves is at least this multiple of the duration of a save. Large films on slow disks then slow
/// the render down by at most 2 %.
const PATIENCE: u32 = 50;

/// Path and schedule of the saves.
#[derive(Debug)]
pub struct Checkpoint {
    path: PathBuf,
    saved: Instant,
    every: Duration,
    wait: Duration,
}

impl Checkpoint {
    /// Saves to `path`, first after `every`. Later saves keep this interval unless a save takes more than 1/50 of it.
    pub fn new(path: &Path, every: Duration) -> Self {
        Checkpoint { path: path.to_owned(), saved: Instant::now(), every, wait: every }
    }

    /// Saves the film if a save is due.
    ///
    /// # Errors
    /// The file cannot be written. The next save is then due after the same interval.
    pub(super) fn save_if_due(&mut self, provenance: &Provenance, film: &Film) -> Result<()> {
        if self.saved.elapsed() < self.wait {
            return Ok(());
        }
        let start = Instant::now();
        let saved = save(&self.path, provenance, film);
        self.saved = Instant::now();
        self.wait = self.every.max(start.elapsed() * PATIENCE);
        saved
    }
}

/// Writes `film` with its provenance to `path`.
///
/// # Errors
/// The file cannot be written.
pub fn save(path: &Path, provenance: &Provenance, film: &Film) -> Result<()> {
    film_file::write(path, &serde_json::json!(provenance), film)
}

/// Reads a film and its provenance.
///
/// # Errors
/// The file cannot be read, or is no film that this étendue understands.
pub fn restore(path: &Path) -> Result<(Provenance, Film)> {
    let (provenance, file) = open(path)?;
    Ok((provenance, file.film()?))
}

/// Reads the provenance of the film at `path` and opens the file. The sums are not read yet.
///
/// # Errors
/// The file cannot be read, or is no film that this étendue understands.
pub fn open(path: &Path) -> Result<(Provenance, FilmFile)> {
    let file = FilmFile::open(path)?;
    let provenance = Provenance::deserialize(file.provenance()).map_err(|cause| {
        let what = format!("{}: its provenance is not one this étendue understands", path.display());
        Error::new(Kind::Scene, what).because(cause)
    })?;
    let (head, settings) = (file.head(), &provenance.settings);
    let fits = settings.layout() == head.layout && settings.replicates == head.replicates && settings.seed == head.seed;
    if !fits || !provenance.plan.is_sound() {
        return Err(Error::scene(format!("{}: its provenance does not fit its sums", path.display())));
    }
    Ok((provenance, file))
}
