//! Timed renders of one method with one backend on one scene.

use super::mark::Mark;
use super::reference::Reference;
use super::{Result, defect};
use crate::error::Error;
use crate::film::{Film, Plane};
use crate::integrator;
use crate::lab::image::relmse;
use crate::named::Named;
use crate::parallel::Cancel;
use crate::sampling::mix64;
use crate::session::machine::Stopwatch;
use crate::session::{
    LoadedScene, Observer, PassPlan, PassSelection, Progress, Provenance, RenderSettings, Session, StopCriteria,
    ToneMapping,
};

/// A method with a backend on a scene.
pub(super) struct BenchCase<'a> {
    pub(super) stage: &'a LoadedScene,
    pub(super) settings: RenderSettings,
    /// Blind spots of the method in this scene.
    pub(super) blind_spots: Vec<String>,
    /// The image after the warm-up: one sample in each replicate.
    warm_up: Vec<f32>,
    /// The marks of each repetition.
    pub(super) runs: Vec<Vec<Mark>>,
    /// The final image of the first repetition.
    pub(super) picture: Vec<f32>,
    first_seconds: f64,
    doublings: u32,
}

impl<'a> BenchCase<'a> {
    /// Renders one round of the replicates, to touch all memory and to measure the pace.
    pub(super) fn warmed_up(stage: &'a LoadedScene, settings: RenderSettings) -> Result<Self> {
        let mut warm_up = Vec::new();
        let marks = timed(stage, &settings, 0, |film, _| {
            warm_up = film.mean(Plane::Color);
            0.0
        })?;
        let pace = marks.last().ok_or_else(|| defect("a warm-up without a pass"))?.cpu_seconds;
        let first_seconds = pace / stage.preparation.threads.max(1) as f64;
        let blind_spots = integrator::blind_spots(settings.method.kind(), &stage.scene);
        let (runs, picture, doublings) = (Vec::new(), Vec::new(), 0);
        Ok(BenchCase { stage, settings, blind_spots, warm_up, runs, picture, first_seconds, doublings })
    }

    /// Returns the name in reports.
    pub(super) fn label(&self) -> String {
        label(&self.settings)
    }

    /// Whether the curve enters ratios: the method has no blind spot in this scene.
    pub(super) fn counts(&self) -> bool {
        self.blind_spots.is_empty()
    }

    /// Estimates the seconds of a repetition with that many doublings on an idle machine. The estimate uses processor
    /// time, so that background load does not shorten curves.
    pub(super) fn seconds(&self, doublings: u32) -> f64 {
        self.first_seconds * f64::from(doublings).exp2()
    }

    /// Sets the number of doublings of the sample count.
    pub(super) fn plan(&mut self, doublings: u32) {
        self.doublings = doublings;
    }

    /// Predicts the error of the last image, if it falls as that of independent samples. `noise` is the reference's own
    /// error, which is subtracted.
    pub(super) fn foretold(&self, rgb: &[f32], noise: f64, epsilon: f64) -> f64 {
        (relmse(&self.warm_up, rgb, epsilon) - noise) / f64::from(self.doublings).exp2()
    }

    /// Renders a repetition.
    pub(super) fn run(&mut self, repetition: u32, reference: &Reference) -> Result<()> {
        let settings = RenderSettings { seed: seed(self.settings.seed, repetition), ..self.settings.clone() };
        let last = u64::from(settings.replicates) << self.doublings;
        let mut picture = None;
        let marks = timed(self.stage, &settings, self.doublings, |film, done| {
            let image = film.mean(Plane::Color);
            let error = relmse(&image, &reference.rgb, reference.record.epsilon);
            picture = (repetition == 0 && done == last).then_some(image);
            error
        })?;
        self.picture = picture.unwrap_or(std::mem::take(&mut self.picture));
        let noise = reference.record.noise.unwrap_or(0.0);
        self.runs.push(marks.into_iter().map(|m| Mark { relmse: m.relmse - noise, ..m }).collect());
        Ok(())
    }
}

pub(super) fn label(settings: &RenderSettings) -> String {
    format!("{}, {}", settings.method.kind().name(), settings.backend.name())
}

/// Seed of a repetition. The warm-up uses the settings' own seed, which differs but for a probability of 2⁻⁶⁴.
pub(super) fn seed(base: u64, repetition: u32) -> u64 {
    mix64(base ^ mix64(u64::from(repetition) + 1))
}

/// Plan with a fixed number of passes.
fn plan(passes: u64) -> PassPlan {
    PassPlan { stop: StopCriteria::after(passes), selection: PassSelection::All }
}

/// Renders, and calls `judge` for the error at each doubling of the sample count. The time of these calls is not
/// counted.
pub(super) fn timed(
    stage: &LoadedScene,
    settings: &RenderSettings,
    doublings: u32,
    judge: impl FnMut(&Film, u64) -> f64,
) -> Result<Vec<Mark>> {
    let (session, marks) = render(stage, settings, doublings, &Cancel::new(), judge)?;
    let rays = session.provenance().work.passes.rays.total();
    let passes = session.film().passes().len().max(1) as f64;
    // The number of rays per pass varies little, so that the average over the render serves for its parts.
    Ok(marks.into_iter().map(|m| Mark { rays: (rays as f64 * m.spp as f64 / passes) as u64, ..m }).collect())
}

/// As [`timed`], but cancellable. Returns the session, which holds the film.
pub(super) fn render<'a>(
    stage: &'a LoadedScene,
    settings: &RenderSettings,
    doublings: u32,
    cancel: &Cancel,
    judge: impl FnMut(&Film, u64) -> f64,
) -> Result<(Session<'a>, Vec<Mark>)> {
    let round = u64::from(settings.replicates);
    let mut watch = Watch { clock: Stopwatch::start(), excluded: [0.0; 2], next: round, marks: Vec::new(), judge };
    let provenance = Provenance::new(stage, settings.clone(), plan(round << doublings), ToneMapping::default());
    let mut session = Session::begin(stage, provenance)?;
    session.run(cancel, &mut watch, None)?;
    Ok((session, watch.marks))
}

/// Observer that reads the clock and judges the film at doubling sample counts.
struct Watch<J> {
    clock: Stopwatch,
    /// Processor and wall-clock seconds spent on judging.
    excluded: [f64; 2],
    next: u64,
    marks: Vec<Mark>,
    judge: J,
}

impl<J> Watch<J> {
    fn seconds(&self) -> [f64; 2] {
        [self.clock.cpu().as_secs_f64() - self.excluded[0], self.clock.wall().as_secs_f64() - self.excluded[1]]
    }
}

impl<J: FnMut(&Film, u64) -> f64> Observer for Watch<J> {
    /// No checkpoints are saved here.
    fn unsaved(&mut self, _error: &Error) {}

    fn pass(&mut self, progress: &Progress<'_>) {
        if progress.pace.done < self.next {
            return;
        }
        let [cpu_seconds, wall_seconds] = self.seconds();
        let relmse = (self.judge)(progress.film, progress.pace.done);
        self.marks.push(Mark { spp: progress.pace.done, cpu_seconds, wall_seconds, relmse, rays: 0 });
        let [cpu, wall] = self.seconds();
        self.excluded = [self.excluded[0] + cpu - cpu_seconds, self.excluded[1] + wall - wall_seconds];
        self.next = 2 * progress.pace.done;
    }
}
