//! A candidate: one method with one backend, and its film.

use super::REPLICATES;
use super::lineup::settings;
use crate::error::{Error, Kind, Result};
use crate::film::pyramid::Pyramid;
use crate::film::{Film, Layout};
use crate::integrator::{FilmRenderer, Method};
use crate::lab::same_mean::Doubt;
use crate::named::Named;
use crate::parallel::Cancel;
use crate::session::machine::Stopwatch;
use crate::session::{LoadedScene, PassPlan, PassSelection, Provenance, SettingsPatch, StopCriteria};

/// A candidate: a method with a backend, and its film so far.
pub struct Candidate<'a> {
    /// Method and backend: `path/embree`.
    pub name: String,
    /// Provenance of its film, with the work so far.
    pub provenance: Provenance,
    /// The scene.
    pub stage: &'a LoadedScene,
    renderer: FilmRenderer<'a>,
    last_block: f64,
}

impl<'a> Candidate<'a> {
    /// Creates a candidate with an empty film.
    ///
    /// # Errors
    /// The camera does not exist, or a choice is out of range.
    pub fn new(stage: &'a LoadedScene, choices: &SettingsPatch, method: Method) -> Result<Self> {
        let settings = settings(choices, stage, method, stage.scene.backend())?;
        let layout = settings.layout();
        let camera = settings.camera_in(&stage.scene)?;
        let plan = PassPlan { stop: StopCriteria::after(0), selection: PassSelection::All };
        Ok(Candidate {
            name: format!("{}/{}", method.name(), settings.backend.name()),
            renderer: FilmRenderer::begin(&stage.scene, camera, &settings.options(), &layout),
            provenance: Provenance::new(stage, settings, plan, choices.tone()?),
            last_block: 0.0,
            stage,
        })
    }

    /// Returns the bytes of the films of `count` candidates with this layout.
    pub(super) fn bytes(layout: &Layout, count: usize) -> u64 {
        Film::bytes_per_pixel(layout, REPLICATES) as u64 * layout.pixels() as u64 * count as u64
    }

    /// Renders one pass of every replicate; `None` if cancelled.
    pub(super) fn block(&mut self, cancel: &Cancel) -> Option<()> {
        let clock = Stopwatch::start();
        let first = self.spp();
        for pass in first..first + u64::from(REPLICATES) {
            self.provenance.work.passes.absorb(self.renderer.pass(pass, cancel)?);
        }
        self.provenance.plan.stop = StopCriteria::after(self.spp());
        self.last_block = clock.wall().as_secs_f64();
        self.provenance.work.wall_seconds += self.last_block;
        self.provenance.work.cpu_seconds += clock.cpu().as_secs_f64();
        Some(())
    }

    /// Returns the samples per pixel so far.
    pub fn spp(&self) -> u64 {
        self.film().passes().len()
    }

    /// Returns the rendering time so far, in seconds.
    pub fn seconds(&self) -> f64 {
        self.provenance.work.wall_seconds
    }

    /// Returns the duration of the last block, in seconds.
    pub(super) fn last_block(&self) -> f64 {
        self.last_block
    }

    /// Returns the film.
    pub fn film(&self) -> &Film {
        self.renderer.film()
    }

    /// Returns the tile means of its picture.
    ///
    /// # Errors
    /// Internal, before the first block is rendered.
    pub fn pyramid(&self) -> Result<Pyramid> {
        let nothing = || Error::new(Kind::Internal, format!("{} has rendered nothing", self.name));
        Pyramid::of_film(self.film(), self.method().independent()).ok_or_else(nothing)
    }

    /// Returns the method.
    pub fn method(&self) -> Method {
        self.provenance.settings.method.kind()
    }

    /// Returns the doubt about its errors, if there is one. The bound on unseen light fails with probability `level`.
    pub fn doubt(&self, level: f64) -> Option<Doubt> {
        Doubt::of(&self.provenance.error_of(self.film())?, self.film().layout().pixels(), level)
    }
}
