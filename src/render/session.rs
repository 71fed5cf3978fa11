//! One process's part in a render: passes, one after the other and each over all threads, into a film.

use super::machine::{Stopwatch, available_memory};
use super::{Checkpoint, Observer, Progress, Provenance, Stage, checkpoint, provenance};
use crate::error::{Error, Kind, Result};
use crate::film::{Film, Layout, PassFilm};
use crate::integrator::{self, Integrator, PassReport};
use crate::parallel::Cancel;
use std::path::Path;
use std::time::Duration;

/// A film in work.
pub struct Session<'a> {
    stage: &'a Stage,
    layout: Layout,
    film: Film,
    provenance: Provenance,
}

/// How a session ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// The plan or its budget was met.
    Complete,
    /// A stop was requested; the passes so far are in the film.
    Interrupted,
}

impl<'a> Session<'a> {
    /// Begins a render: runs the prelude and makes an empty film.
    ///
    /// # Errors
    /// A camera that is not there, too little memory for the film.
    pub fn begin(stage: &'a Stage, provenance: Provenance) -> Result<Session<'a>> {
        let settings = &provenance.settings;
        let layout = settings.layout();
        affordable(&layout, settings.replicates)?;
        let camera = stage.scene.camera(settings.camera.as_deref(), settings.width, settings.height)?;
        let prelude = integrator::prelude(&stage.scene, &camera, &settings.options(), &layout);
        let film = Film::new(layout.clone(), settings.replicates, settings.seed, prelude.units);
        Ok(Session { stage, layout, film, provenance })
    }

    /// Goes on with a film. What the prelude decided is in it.
    ///
    /// # Errors
    /// The scene or the program is not the one that began it.
    pub fn resume(stage: &'a Stage, provenance: Provenance, film: Film) -> Result<Session<'a>> {
        provenance.continuable_on(stage)?;
        Ok(Session { stage, layout: provenance.settings.layout(), film, provenance })
    }

    /// Instance and material numbers at the pixel centres.
    ///
    /// # Errors
    /// A camera that is not there.
    pub fn ids(&self) -> Result<super::images::Ids> {
        let settings = &self.provenance.settings;
        let camera = self.stage.scene.camera(settings.camera.as_deref(), settings.width, settings.height)?;
        Ok(integrator::ids(&self.stage.scene, &camera, &self.layout))
    }

    /// The film.
    pub fn film(&self) -> &Film {
        &self.film
    }

    /// Where the film comes from, with the work so far.
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// Renders the passes that the plan wants and the film lacks, until done, out of time or told to stop.
    ///
    /// # Errors
    /// A checkpoint that cannot be written, a camera that is not there.
    pub fn run(&mut self, cancel: &Cancel, observer: &mut dyn Observer, mut checkpoint: Option<Checkpoint>) -> Result<Ended> {
        let (stage, settings) = (self.stage, self.provenance.settings.clone());
        let camera = stage.scene.camera(settings.camera.as_deref(), settings.width, settings.height)?;
        let integrator = integrator::build(settings.method, &stage.scene, camera, &settings.options());
        let mut scratch = PassFilm::new(&self.layout);
        let (earlier, mut done) = (self.provenance.work.clone(), 0);
        self.provenance.work.sessions += 1;
        let clock = Stopwatch::start();
        let held = self.film.passes().clone();
        let wanted = self.provenance.plan.count().map(|_| self.missing(&held).count() as u64);
        for pass in self.missing(&held) {
            if !self.time_left(done, clock.wall()) {
                break;
            }
            let Some(report) = self.render(&*integrator, pass, cancel, &mut scratch) else {
                return Ok(Ended::Interrupted);
            };
            done += 1;
            self.account(&earlier, report);
            let budget = self.provenance.plan.budget();
            observer.pass(&Progress { film: &self.film, done, wanted, elapsed: clock.wall(), budget });
            if let Some(checkpoint) = &mut checkpoint {
                checkpoint.save_if_due(&self.provenance, &self.film)?;
            }
        }
        Ok(Ended::Complete)
    }

    /// Writes the film, so that it can be merged or resumed.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, path: &Path) -> Result<()> {
        checkpoint::save(path, &self.provenance, &self.film)
    }

    /// The passes wanted and not held, in order.
    fn missing<'b>(&self, held: &'b crate::film::PassSet) -> impl Iterator<Item = u64> + use<'b> {
        self.provenance.plan.passes().filter(|&pass| !held.contains(pass))
    }

    fn time_left(&self, done: u64, used: Duration) -> bool {
        let Some(budget) = self.provenance.plan.budget() else { return true };
        admits(done, self.film.passes().len(), u64::from(self.provenance.settings.replicates), used, budget)
    }

    fn render(&mut self, integrator: &dyn Integrator, pass: u64, cancel: &Cancel, scratch: &mut PassFilm) -> Option<PassReport> {
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
        work.wall_seconds = earlier.wall_seconds + self.stage.clock.wall().as_secs_f64();
        work.cpu_seconds = earlier.cpu_seconds + self.stage.clock.cpu().as_secs_f64();
        work.finished = provenance::now();
    }
}

/// Whether there is time for another pass. Replicates stay balanced: a round of `round` passes is begun only if it will
/// be over in time at the pace so far, and then finished. The first pass always runs, and within the first round of a film
/// time decides pass by pass.
fn admits(done: u64, held: u64, round: u64, used: Duration, budget: Duration) -> bool {
    if done == 0 {
        return true;
    }
    match (held < round, held % round) {
        (true, _) => used < budget,
        (false, 0) => used.as_secs_f64() * (1.0 + round as f64 / done as f64) <= budget.as_secs_f64(),
        (false, _) => true,
    }
}

/// Refuses a film that would not fit into memory.
fn affordable(layout: &Layout, replicates: u32) -> Result<()> {
    let need = Film::bytes_per_pixel(layout, replicates) as u64 * layout.pixels() as u64;
    match available_memory() {
        Some(available) if need > available => {
            let (need, available) = (need as f64 / 1e9, available as f64 / 1e9);
            let what = format!("the film takes {need:.1} GB and {available:.1} GB are free: use a smaller size, a crop, fewer");
            Err(Error::new(Kind::Memory, format!("{what} replicates or fewer layers")))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passes_within(budget: u64, seconds_each: u64, round: u64) -> u64 {
        let mut done = 0;
        while admits(done, done, round, Duration::from_secs(done * seconds_each), Duration::from_secs(budget)) {
            done += 1;
        }
        done
    }

    #[test]
    fn time_budgets_end_on_whole_rounds() {
        assert_eq!(passes_within(100, 1, 4), 100);
        assert_eq!(passes_within(103, 1, 4), 100);
        assert_eq!(passes_within(7, 1, 4), 4);
    }

    #[test]
    fn a_budget_below_one_round_is_kept_pass_by_pass() {
        assert_eq!(passes_within(2, 1, 4), 2);
        assert_eq!(passes_within(1, 10, 4), 1);
    }

    #[test]
    fn a_film_beyond_memory_is_refused_before_it_is_made() {
        let layout = Layout::new(1 << 16, 1 << 16, None, &[]);
        assert_eq!(affordable(&layout, 256).unwrap_err().kind, Kind::Memory);
        assert!(affordable(&Layout::new(16, 16, None, &[]), 4).is_ok());
    }
}
