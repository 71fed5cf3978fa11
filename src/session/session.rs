//! Render session of one process: passes are rendered one after the other into a film, each on all threads.

use super::machine::{self, Stopwatch};
use super::{Checkpoint, LoadedScene, Observer, Pace, Progress, Provenance, Rendered, images, provenance, target};
use crate::error::{Error, Kind, Result};
use crate::film::{Film, Layout, PassFilm};
use crate::integrator::{self, Integrator, PassReport, PilotEstimate, TechniqueImages};
use crate::parallel::Cancel;
use std::time::Duration;

/// A render session: a film in progress.
pub struct Session<'a> {
    stage: &'a LoadedScene,
    layout: Layout,
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
        if let Some(refusal) = integrator::refusal(settings.method, &stage.scene) {
            return Err(Error::new(Kind::Usage, refusal));
        }
        let clock = Stopwatch::start();
        let camera = settings.camera_in(&stage.scene)?;
        let pilot = integrator::pilot(&stage.scene, &camera, &settings.options(), &layout);
        let film = Film::new(layout.clone(), settings.replicates, settings.seed, pilot.units);
        Ok(Session { stage, layout, film, provenance, clock, check: None })
    }

    /// Continues a film. It contains the results of the pilot.
    ///
    /// # Errors
    /// The scene or the program is not the one that began it.
    pub fn resume(stage: &'a LoadedScene, provenance: Provenance, film: Film) -> Result<Session<'a>> {
        provenance.continuable_on(stage)?;
        let (layout, clock) = (provenance.settings.layout(), Stopwatch::start());
        Ok(Session { stage, layout, film, provenance, clock, check: None })
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
            self.layout.pixels(),
        )?;
        let camera = settings.camera_in(&self.stage.scene)?;
        let watched = passes.iter().enumerate().inspect(|(done, _)| watch(*done as f64 / passes.len() as f64));
        let passes = watched.map(|(_, pass)| pass);
        Ok(integrator::technique_images(&self.stage.scene, &camera, &options, &self.layout, passes, deepest, cancel))
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
        mut checkpoint: Option<Checkpoint>,
    ) -> Result<Ended> {
        let (stage, settings) = (self.stage, self.provenance.settings.clone());
        let camera = settings.camera_in(&stage.scene)?;
        let pilot = PilotEstimate::with(self.film.units());
        let integrator = integrator::build(settings.method, &stage.scene, camera, &settings.options(), &pilot);
        let mut scratch = PassFilm::new(&self.layout).with_unit(self.film.units().radiance);
        let (earlier, mut done) = (self.provenance.work.clone(), 0);
        self.provenance.work.sessions += 1;
        let clock = Stopwatch::start();
        let held = self.film.passes().clone();
        let wanted = self.provenance.plan.count().map(|_| self.missing(&held).count() as u64);
        self.look();
        for pass in self.missing(&held) {
            if self.is_good_enough() || !self.time_left(done, clock.wall()) {
                break;
            }
            let Some(report) = self.render(&*integrator, pass, cancel, &mut scratch) else {
                return Ok(Ended::Interrupted);
            };
            done += 1;
            self.account(&earlier, report);
            self.look();
            let (budget, wanted) = (self.provenance.plan.budget(), self.forecast(held.len(), wanted));
            let pace = Pace { done, wanted, elapsed: clock.wall(), budget };
            observer.pass(&Progress { film: &self.film, provenance: &self.provenance, pace });
            if let Some(checkpoint) = &mut checkpoint {
                checkpoint.save_if_due(&self.provenance, &self.film).unwrap_or_else(|error| observer.unsaved(&error));
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

    /// The passes wanted and not held, in order.
    fn missing<'b>(&self, held: &'b crate::film::PassSet) -> impl Iterator<Item = u64> + use<'b> {
        self.provenance.plan.passes().filter(|&pass| !held.contains(pass))
    }

    /// Looks at the error if there is a target and a look is due.
    fn look(&mut self) {
        let target = self.provenance.plan.stop.target_error;
        let known = self.provenance.known();
        self.check = target.and_then(|target| target::check(&self.film, known, target)).or(self.check);
    }

    fn is_good_enough(&self) -> bool {
        self.check.is_some_and(|check| check.reached)
    }

    /// Forecasts the number of passes of this session from the error target, at most `wanted`.
    fn forecast(&self, held: u64, wanted: Option<u64>) -> Option<u64> {
        let needed = self.check.map(|check| target::passes_needed(&check).saturating_sub(held));
        wanted.map(|wanted| needed.map_or(wanted, |needed| needed.min(wanted))).or(needed)
    }

    fn time_left(&self, done: u64, used: Duration) -> bool {
        let Some(budget) = self.provenance.plan.budget() else { return true };
        let first_round = self.film.passes().len() < u64::from(self.provenance.settings.replicates);
        if first_round { done == 0 || used < budget } else { admits(done, used, budget) }
    }

    fn render(
        &mut self,
        integrator: &dyn Integrator,
        pass: u64,
        cancel: &Cancel,
        scratch: &mut PassFilm,
    ) -> Option<PassReport> {
        if cancel.requested() {
            return None;
        }
        scratch.clear();
        let report = integrator.run_pass(pass, cancel, scratch)?;
        self.film.commit(pass, scratch);
        Some(report)
    }

    fn account(&mut self, earlier: &provenance::Work, report: PassReport) {
        let work = &mut self.provenance.work;
        work.passes.absorb(report);
        work.wall_seconds = earlier.wall_seconds + self.clock.wall().as_secs_f64();
        work.cpu_seconds = earlier.cpu_seconds + self.clock.cpu().as_secs_f64();
        work.finished = provenance::now();
    }
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
