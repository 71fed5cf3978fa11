//! How many rays per second a render traces, beside the rate at which the same rays are answered with nothing in between.
//!
//! The rays of one pass are recorded on one thread and replayed by all; both are timed round by round, so that whatever else
//! the machine does falls on both.

use super::machine::Stopwatch;
use super::{Settings, Stage};
use crate::accel::{Accel, Question};
use crate::camera::Camera;
use crate::error::{Error, Kind, Result};
use crate::film::{Layout, PassFilm};
use crate::integrator::{self, Integrator};
use crate::parallel::Cancel;
use rayon::prelude::*;
use serde::Serialize;
use std::hint::black_box;

const MILLION: f64 = 1e6;

/// Questions that one task replays.
const CHUNK: usize = 4096;

/// Million rays per second over some rounds.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Rate {
    /// The middle one.
    pub median: f64,
    /// The slowest round.
    pub least: f64,
    /// The fastest round.
    pub most: f64,
}

/// Ray rates of one scene with one backend.
#[derive(Debug, Clone, Serialize)]
pub struct RayRates {
    /// The scene file.
    pub scene: String,
    /// The backend.
    pub backend: &'static str,
    /// How its structure was built.
    pub build: crate::accel::Build,
    /// Seconds that took.
    pub accel_seconds: f64,
    /// Bytes of the structure for each triangle.
    pub bytes_per_triangle: f64,
    /// Rays that were recorded.
    pub rays: usize,
    /// The same rays, replayed.
    pub raw: Rate,
    /// Rays of the render.
    pub render: Rate,
    /// Share of the raw rate that the render reaches.
    pub share: Rate,
}

/// A scene whose rays are recorded and ready to be replayed.
pub struct RayBench {
    stage: Stage,
    settings: Settings,
    camera: Camera,
    layout: Layout,
    questions: Vec<Question>,
    raw: Vec<f64>,
    render: Vec<f64>,
}

impl RayBench {
    /// Records the rays of pass 0.
    ///
    /// # Errors
    /// A camera that is not there; an internal error if no thread can be started.
    pub fn new(stage: Stage, settings: Settings) -> Result<RayBench> {
        let (layout, camera) =
            (settings.layout(), stage.scene.camera(settings.camera.as_deref(), settings.width, settings.height)?);
        let stage = Stage { scene: stage.scene.with_accel(Accel::recorded), ..stage };
        let bench = RayBench { stage, settings, camera, layout, questions: Vec::new(), raw: Vec::new(), render: Vec::new() };
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        let alone = alone.map_err(|cause| Error::new(Kind::Internal, "cannot start a thread").because(cause))?;
        alone.install(|| bench.trace(&*bench.integrator(), 0));
        let mut questions = Vec::new();
        let scene = bench.stage.scene.with_accel(|accel| {
            let (accel, asked) = accel.questions();
            questions = asked;
            accel
        });
        Ok(RayBench { stage: Stage { scene, ..bench.stage }, questions, ..bench })
    }

    /// Times a pass and a replay.
    pub fn round(&mut self) {
        let integrator = self.integrator();
        let clock = Stopwatch::start();
        let rays = self.trace(&*integrator, 1 + self.render.len() as u64);
        let seconds = clock.wall().as_secs_f64();
        drop(integrator);
        self.render.push(rays as f64 / MILLION / seconds);
        let clock = Stopwatch::start();
        let accel = self.stage.scene.accel();
        let hits: usize = self.questions.par_chunks(CHUNK).map(|chunk| chunk.iter().filter(|q| q.ask(accel)).count()).sum();
        black_box(hits);
        self.raw.push(self.questions.len() as f64 / MILLION / clock.wall().as_secs_f64());
    }

    /// What the rounds so far say.
    pub fn rates(&self) -> RayRates {
        let info = &self.stage.info;
        RayRates {
            scene: self.stage.path.display().to_string(),
            backend: self.stage.scene.backend().name(),
            build: self.settings.build,
            accel_seconds: info.accel_seconds,
            bytes_per_triangle: info.accel_bytes as f64 / info.triangles.max(1) as f64,
            rays: self.questions.len(),
            raw: Rate::of(&self.raw),
            render: Rate::of(&self.render),
            share: Rate::of(&self.render.iter().zip(&self.raw).map(|(render, raw)| render / raw).collect::<Vec<_>>()),
        }
    }

    fn integrator(&self) -> Box<dyn Integrator + '_> {
        integrator::build(self.settings.method, &self.stage.scene, self.camera.clone(), &self.settings.options())
    }

    /// Renders a pass and counts its rays.
    fn trace(&self, integrator: &dyn Integrator, pass: u64) -> u64 {
        let report = integrator.run_pass(pass, &Cancel::new(), &mut PassFilm::new(&self.layout)).unwrap_or_default();
        report.rays.camera + report.rays.bounce + report.rays.shadow
    }
}

impl Rate {
    fn of(rounds: &[f64]) -> Rate {
        let mut sorted = rounds.to_vec();
        sorted.sort_by(f64::total_cmp);
        let at = |i: usize| sorted.get(i).copied().unwrap_or(f64::NAN);
        Rate { median: at(sorted.len() / 2), least: at(0), most: at(sorted.len().saturating_sub(1)) }
    }
}
