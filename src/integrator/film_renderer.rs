//! The pass loop: passes of one integrator, rendered into a film.

use super::{Integrator, IntegratorConfig, PassReport, build, pilot};
use crate::camera::Camera;
use crate::film::{Film, Layout, PassFilm};
use crate::parallel::Cancel;
use crate::scene::Scene;
use std::borrow::BorrowMut;

/// Renders passes into a film, its own or a borrowed one.
pub struct FilmRenderer<'a, F: BorrowMut<Film> = Film> {
    integrator: Box<dyn Integrator + 'a>,
    film: F,
    scratch: PassFilm,
}

impl<'a> FilmRenderer<'a> {
    /// Begins a film of `layout`: runs the pilot, whose units the film gets, and builds the integrator.
    pub fn begin(scene: &'a Scene, camera: Camera, options: &IntegratorConfig, layout: &Layout) -> FilmRenderer<'a> {
        let pilot = pilot(scene, &camera, options, layout);
        let film = Film::new(layout.clone(), options.replicates, options.seed, pilot.units);
        FilmRenderer::new(build(scene, camera, options, &pilot), film)
    }
}

impl<'a, F: BorrowMut<Film>> FilmRenderer<'a, F> {
    /// Continues `film` with passes of `integrator`, which renders its layout.
    pub fn new(integrator: Box<dyn Integrator + 'a>, film: F) -> Self {
        let held = film.borrow();
        let scratch = PassFilm::new(held.layout()).with_unit(held.units().radiance);
        FilmRenderer { integrator, film, scratch }
    }

    /// Renders pass number `pass`. Returns its report; `None` if it was cancelled, which leaves the film unchanged.
    pub fn pass(&mut self, pass: u64, cancel: &Cancel) -> Option<PassReport> {
        if cancel.requested() {
            return None;
        }
        self.scratch.clear();
        let report = self.integrator.run_pass(pass, cancel, &mut self.scratch)?;
        self.film.borrow_mut().commit(pass, &self.scratch);
        Some(report)
    }

    /// Renders `count` passes from the first that follows those of the film, without a way to cancel. Returns their
    /// reports, merged.
    pub fn passes(&mut self, count: u64) -> PassReport {
        let first = self.film().passes().len();
        let mut report = PassReport::default();
        for pass in first..first + count {
            report.absorb(self.pass(pass, &Cancel::new()).unwrap_or_default());
        }
        report
    }

    /// Returns the film.
    pub fn film(&self) -> &Film {
        self.film.borrow()
    }
}
