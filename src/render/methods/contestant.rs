//! A method with a backend on a scene: its renders, timed.

use super::curve::Mark;
use super::reference::Reference;
use super::{Result, defect};
use crate::error::Error;
use crate::film::{Film, Plane};
use crate::integrator;
use crate::parallel::Cancel;
use crate::render::machine::Stopwatch;
use crate::render::{Look, Observer, Plan, Progress, Provenance, Selection, Session, Settings, Stage, Stop};
use crate::sampling::mix64;
use crate::stats::image::relmse;

/// A method with a backend on a scene.
pub(super) struct Contestant<'a> {
    pub(super) stage: &'a Stage,
    pub(super) settings: Settings,
    /// What the method cannot see here.
    pub(super) blind_spots: Vec<String>,
    /// The image of the warm-up: one sample in each replicate.
    warm_up: Vec<f32>,
    /// The curve of each repetition.
    pub(super) runs: Vec<Vec<Mark>>,
    /// The last image of the first repetition.
    pub(super) picture: Vec<f32>,
    first_seconds: f64,
    doublings: u32,
}

impl<'a> Contestant<'a> {
    /// Renders one round of the replicates, to touch all memory and to know the pace.
    pub(super) fn warmed_up(stage: &'a Stage, settings: Settings) -> Result<Self> {
        let mut warm_up = Vec::new();
        let marks = timed(stage, &settings, 0, |film, _| {
            warm_up = film.mean(Plane::Color);
            0.0
        })?;
        let pace = marks.last().ok_or_else(|| defect("a warm-up without a pass"))?.cpu_seconds;
        let first_seconds = pace / stage.preparation.threads.max(1) as f64;
        let blind_spots = integrator::blind_spots(settings.method, &stage.scene);
        let (runs, picture, doublings) = (Vec::new(), Vec::new(), 0);
        Ok(Contestant { stage, settings, blind_spots, warm_up, runs, picture, first_seconds, doublings })
    }

    /// The name in reports.
    pub(super) fn label(&self) -> String {
        label(&self.settings)
    }

    /// Whether its curve says how good it is: it sees everything.
    pub(super) fn counts(&self) -> bool {
        self.blind_spots.is_empty()
    }

    /// About how long a repetition with that many doublings takes if nothing else runs: by processor time, so that a busy
    /// machine does not make curves short.
    pub(super) fn seconds(&self, doublings: u32) -> f64 {
        self.first_seconds * f64::from(doublings).exp2()
    }

    /// Sets how often the sample count is doubled.
    pub(super) fn plan(&mut self, doublings: u32) {
        self.doublings = doublings;
    }

    /// The error that its last image will have if it falls as that of independent samples, judged by a reference that has the
    /// error `noise` itself.
    pub(super) fn foretold(&self, rgb: &[f32], noise: f64, epsilon: f64) -> f64 {
        (relmse(&self.warm_up, rgb, epsilon) - noise) / f64::from(self.doublings).exp2()
    }

    /// Renders a repetition.
    pub(super) fn run(&mut self, repetition: u32, reference: &Reference) -> Result<()> {
        let settings = Settings { seed: seed(self.settings.seed, repetition), ..self.settings.clone() };
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

pub(super) fn label(settings: &Settings) -> String {
    let method = serde_json::json!(settings.method);
    format!("{}, {}", method.as_str().unwrap_or_default(), settings.backend.name())
}

/// The seed of a repetition; the warm-up has the settings' own, which none of these is but by a chance of 2⁻⁶⁴.
pub(super) fn seed(base: u64, repetition: u32) -> u64 {
    mix64(base ^ mix64(u64::from(repetition) + 1))
}

/// The only place that says how much is rendered.
fn plan(passes: u64) -> Plan {
    Plan { stop: Stop::after(passes), selection: Selection::All }
}

/// Renders, and asks `judge` for the error whenever the sample count has doubled; the time it takes is not counted.
pub(super) fn timed(
    stage: &Stage,
    settings: &Settings,
    doublings: u32,
    judge: impl FnMut(&Film, u64) -> f64,
) -> Result<Vec<Mark>> {
    let (session, marks) = render(stage, settings, doublings, &Cancel::new(), judge)?;
    let rays = session.provenance().work.passes.rays.total();
    let passes = session.film().passes().len().max(1) as f64;
    // Rays per pass vary so little that the whole render speaks for its parts.
    Ok(marks.into_iter().map(|m| Mark { rays: (rays as f64 * m.spp as f64 / passes) as u64, ..m }).collect())
}

/// The same, with a way to stop it; the session has the film.
pub(super) fn render<'a>(
    stage: &'a Stage,
    settings: &Settings,
    doublings: u32,
    cancel: &Cancel,
    judge: impl FnMut(&Film, u64) -> f64,
) -> Result<(Session<'a>, Vec<Mark>)> {
    let round = u64::from(settings.replicates);
    let mut watch = Watch { clock: Stopwatch::start(), excluded: [0.0; 2], next: round, marks: Vec::new(), judge };
    let provenance = Provenance::new(stage, settings.clone(), plan(round << doublings), Look::default());
    let mut session = Session::begin(stage, provenance)?;
    session.run(cancel, &mut watch, None)?;
    Ok((session, watch.marks))
}

/// Reads the clock and judges the film at doubling counts.
struct Watch<J> {
    clock: Stopwatch,
    /// Processor and wall-clock seconds that judging took.
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
    /// Nothing is saved on the way.
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
