//! Films saved while rendering, so that a kill costs a minute at most.

use super::Provenance;
use super::film_file::{self, FilmFile};
use crate::error::{Error, Kind, Result};
use crate::film::Film;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How long a film goes unsaved where nothing is said.
pub const INTERVAL: Duration = Duration::from_secs(60);

/// How many times longer than a save itself the time between saves is, so that large films on slow disks do not hold
/// the render up: by 2 % at most.
const PATIENCE: u32 = 50;

/// Where and when a film is saved.
#[derive(Debug)]
pub struct Checkpoint {
    path: PathBuf,
    saved: Instant,
    every: Duration,
    wait: Duration,
}

impl Checkpoint {
    /// Saves to `path`, first after `every`, and as often if a save takes little of it.
    pub fn new(path: &Path, every: Duration) -> Self {
        Checkpoint { path: path.to_owned(), saved: Instant::now(), every, wait: every }
    }

    /// Saves if it is time.
    ///
    /// # Errors
    /// The file cannot be written; it will be time again after as long.
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

/// Writes `film` to `path` with where it came from.
///
/// # Errors
/// The file cannot be written.
pub fn save(path: &Path, provenance: &Provenance, film: &Film) -> Result<()> {
    film_file::write(path, &serde_json::json!(provenance), film)
}

/// Reads a film and where it came from.
///
/// # Errors
/// The file cannot be read, or is no film that this étendue understands.
pub fn restore(path: &Path) -> Result<(Provenance, Film)> {
    let (provenance, file) = open(path)?;
    Ok((provenance, file.film()?))
}

/// Where the film at `path` came from, and the file itself, whose sums have not been read yet.
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
