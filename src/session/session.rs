//! Render session of one process: passes are rendered one after the other into a film, each on all threads.

use super::machine::{self, Stopwatch};
use super::{Checkpoint, LoadedScene, Observer, Pace, Progress, Provenance, Rendered, images, provenance, target};
use crate::camera::Camera;
use crate::error::{Error, Kind, Result};
use crate::film::Film;
use crate::integrator::{self, FilmRenderer, Integrator, IntegratorConfig, PassReport, PilotEstimate, TechniqueImages};
use crate::named::Named;
use crate::parallel::Cancel;
use crate::scene::Scene;
use std::time::Duration;

/// A render session: a film in progress.
pub struct Session<'a> {
    stage: &'a LoadedScene,
    film: Film,
    provenance: Provenance,
    /// Runs from the start of the session.
    clock: Stopwatch,
    /// The last look at the error, if there is a target.
    check: Option<target::Check>,
}

/// Reason for the end of a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// The plan or its budget was met.
    Complete,
    /// A stop was requested; the passes so far are in the film.
    Interrupted,
}

impl<'a> Session<'a> {
    /// Begins a render: runs the pilot and creates an empty film.
    ///
    /// # Errors
    /// The camera does not exist, the method refuses the scene, or there is too little memory for the film.
    pub fn begin(stage: &'a LoadedScene, provenance: Provenance) -> Result<Session<'a>> {
        let settings = &provenance.settings;
        let layout = settings.layout();
        affordable("the film", Film::bytes_per_pixel(&layout, settings.replicates), layout.pixels())?;
        if let Some(refusal) = integrator::refusal(settings.method.kind(), &stage.scene) {
            return Err(Error::new(Kind::Usage, refusal));
        }
        if let Some(model) = settings.method.subsurface().filter(|_| integrator::diffusing_bodies(&stage.scene) == 0) {
            return Err(Error::usage(format!(
                "the scene has no body for --subsurface {}: closed, full of one medium that scatters, of an index above \
                 1, and at least ten mean free paths thick",
                model.name()
            )));
        }
        let clock = Stopwatch::start();
        let camera = settings.camera_in(&stage.scene)?;
        let pilot = integrator::pilot(&stage.scene, &camera, &settings.options(), &layout);
        let film = Film::new(layout, settings.replicates, settings.seed, pilot.units);
        Ok(Session { stage, film, provenance, clock, check: None })
    }

    /// Continues a film. It contains the results of the pilot.
    ///
    /// # Errors
    /// The scene or the program is not the one that began it.
    pub fn resume(stage: &'a LoadedScene, provenance: Provenance, film: Film) -> Result<Session<'a>> {
        provenance.continuable_on(stage)?;
        let clock = Stopwatch::start();
        Ok(Session { stage, film, provenance, clock, check: None })
    }

    /// Renders the contribution of each technique of bidirectional path tracing in the passes of the film, for paths of
    /// at most `deepest` scattering events; `None` if cancelled. `watch` receives the completed fraction before each
    /// pass.
    ///
    /// # Errors
    /// The camera does not exist, or there is too little memory for the images.
    pub fn techniques(
        &self,
        deepest: u32,
        cancel: &Cancel,
        mut watch: impl FnMut(f64),
    ) -> Result<Option<TechniqueImages>> {
        let (settings, passes) = (&self.provenance.settings, self.film.passes());
        let options = settings.options();
        affordable(
            "the images of techniques",
            TechniqueImages::bytes_per_pixel(&options, deepest),
            self.film.layout().pixels(),
        )?;
        let camera = settings.camera_in(&self.stage.scene)?;
        let watched = passes.iter().enumerate().inspect(|(done, _)| watch(*done as f64 / passes.len() as f64));
        let passes = watched.map(|(_, pass)| pass);
        Ok(integrator::technique_images(
            &self.stage.scene,
            &camera,
            &options,
            self.film.layout(),
            passes,
            deepest,
            cancel,
        ))
    }

    /// Returns the film.
    pub fn film(&self) -> &Film {
        &self.film
    }

    /// Returns the film's provenance, with the work so far.
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// Renders the passes that the plan wants and the film lacks, until the plan is complete, the error target is
    /// reached, the time is over, or a stop is requested.
    ///
    /// # Errors
    /// The camera does not exist.
    pub fn run(
        &mut self,
        cancel: &Cancel,
        observer: &mut dyn Observer,
        checkpoint: Option<Checkpoint>,
    ) -> Result<Ended> {
        self.run_with(cancel, observer, checkpoint, integrator::build)
    }

    /// [`Session::run`] with the integrator that `build` returns.
    ///
    /// # Errors
    /// The camera does not exist.
    pub fn run_with(
        &mut self,
        cancel: &Cancel,
        observer: &mut dyn Observer,
        mut checkpoint: Option<Checkpoint>,
        build: impl FnOnce(&'a Scene, Camera, &IntegratorConfig, &PilotEstimate) -> Box<dyn Integrator + 'a>,
    ) -> Result<Ended> {
        let (stage, settings) = (self.stage, &self.provenance.settings);
        let camera = settings.camera_in(&stage.scene)?;
        let pilot = PilotEstimate::with(self.film.units());
        let integrator = build(&stage.scene, camera, &settings.options(), &pilot);
        let Session { film, provenance, check, clock: session_clock, .. } = self;
        let (earlier, mut done) = (provenance.work.clone(), 0);
        provenance.work.sessions += 1;
        let clock = Stopwatch::start();
        let held = film.passes().clone();
        let plan = provenance.plan;
        let missing = || plan.passes().filter(|&pass| !held.contains(pass));
        let wanted = provenance.plan.count().map(|_| missing().count() as u64);
        look(film, provenance, check);
        let mut renderer = FilmRenderer::new(integrator, film);
        for pass in missing() {
            let is_over = check.is_some_and(|check| check.ends_render());
            if is_over || !time_left(renderer.film(), provenance, done, clock.wall()) {
                break;
            }
            let Some(report) = renderer.pass(pass, cancel) else { return Ok(Ended::Interrupted) };
            done += 1;
            account(provenance, session_clock, &earlier, report);
            look(renderer.film(), provenance, check);
            let (budget, wanted) = (provenance.plan.budget(), forecast(check.as_ref(), held.len(), wanted));
            let pace = Pace { done, wanted, elapsed: clock.wall(), budget };
            observer.pass(&Progress { film: renderer.film(), provenance, pace });
            if let Some(checkpoint) = &mut checkpoint {
                checkpoint.save_if_due(provenance, renderer.film()).unwrap_or_else(|error| observer.unsaved(&error));
            }
        }
        Ok(Ended::Complete)
    }

    /// Ends the session and returns its result.
    ///
    /// # Errors
    /// The camera does not exist.
    pub fn end(self) -> Result<Rendered> {
        let Session { stage, film, provenance, check, .. } = self;
        let ids = images::ids(stage, &provenance.settings)?;
        Ok(Rendered { provenance, film, ids, preparation: Some(stage.preparation), check })
    }
}

/// Looks at the error if there is a target and a look is due.
fn look(film: &Film, provenance: &Provenance, check: &mut Option<target::Check>) {
    let target = provenance.plan.stop.target_error;
    *check = target.and_then(|target| target::check(film, provenance.known(), target)).or(*check);
}

/// Forecasts the number of passes of a session from the error target, at most `wanted`. The film held `held` before.
fn forecast(check: Option<&target::Check>, held: u64, wanted: Option<u64>) -> Option<u64> {
    let needed = check.map(|check| target::passes_needed(check).saturating_sub(held));
    wanted.map(|wanted| needed.map_or(wanted, |needed| needed.min(wanted))).or(needed)
}

/// Whether the time budget, if there is one, admits another pass.
fn time_left(film: &Film, provenance: &Provenance, done: u64, used: Duration) -> bool {
    let Some(budget) = provenance.plan.budget() else { return true };
    let first_round = film.passes().len() < u64::from(provenance.settings.replicates);
    if first_round { done == 0 || used < budget } else { admits(done, used, budget) }
}

fn account(provenance: &mut Provenance, clock: &Stopwatch, earlier: &provenance::Work, report: PassReport) {
    let work = &mut provenance.work;
    work.passes.absorb(report);
    work.wall_seconds = earlier.wall_seconds + clock.wall().as_secs_f64();
    work.cpu_seconds = earlier.cpu_seconds + clock.cpu().as_secs_f64();
    work.finished = provenance::now();
}

/// Whether another pass will finish in time at the pace so far; the first one always runs.
fn admits(done: u64, used: Duration, budget: Duration) -> bool {
    done == 0 || used.as_secs_f64() * (1.0 + 1.0 / done as f64) <= budget.as_secs_f64()
}

/// Rejects a buffer that does not fit into memory.
fn affordable(what: &str, bytes_per_pixel: usize, pixels: usize) -> Result<()> {
    let cure = "use a smaller size, a crop, fewer replicates or fewer layers";
    machine::affordable(what, bytes_per_pixel as u64 * pixels as u64, cure)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Layout;

    /// A budget is used up to the last pass that fits. Passes of constant duration never overrun it.
    #[test]
    fn time_budgets_end_on_the_last_pass_that_fits() {
        let passes_within = |budget: u64, each: u64| {
            (0..).find(|&done| !admits(done, Duration::from_secs(done * each), Duration::from_secs(budget)))
        };
        assert_eq!(passes_within(100, 1), Some(100));
        assert_eq!(passes_within(103, 5), Some(20));
        assert_eq!(passes_within(1, 10), Some(1));
    }

    #[test]
    fn a_film_beyond_memory_is_refused_before_it_is_made() {
        let film = |layout: Layout, replicates| {
            affordable("the film", Film::bytes_per_pixel(&layout, replicates), layout.pixels())
        };
        assert_eq!(film(Layout::new(1 << 16, 1 << 16, None, &[]), 256).unwrap_err().kind, Kind::Memory);
        assert!(film(Layout::new(16, 16, None, &[]), 4).is_ok());
    }
}
