//! Rows of the measurement: a backend with a build, or obvhs's CWBVH, with the rates of its rounds.

use super::record::View;
use super::stream::{Group, RayStream};
use crate::accel::{Accel, Backend, Build, Intersector};
use crate::error::Result;
use crate::geometry::{AnyHit, Geometry, Hit, Ray};
use crate::lab::bench_rays::RayQuery;
use crate::lab::bench_rays::cwbvh::Cwbvh;
use crate::lab::hard_cases::title;
use crate::session::LoadedScene;
use crate::session::machine::Stopwatch;
use rayon::prelude::*;
use std::hint::black_box;

/// Rays per task: few enough to keep all threads busy with a small class.
const CHUNK: usize = 512;

/// Shorter streams are traced several times in a row, so that the clock's resolution does not dominate.
const FEWEST: usize = 1 << 14;

const MILLION: f64 = 1e6;

/// A structure that traces rays.
pub(super) enum Structure {
    /// A backend.
    Accel(Accel),
    /// obvhs's own tree and intersection tests.
    Cwbvh(Cwbvh),
}

impl Intersector for Structure {
    fn closest(&self, ray: &Ray, any: &impl AnyHit) -> Option<Hit> {
        match self {
            Structure::Accel(accel) => accel.closest(ray, any),
            Structure::Cwbvh(tree) => tree.closest(ray, any),
        }
    }

    fn occluded(&self, ray: &Ray, any: &impl AnyHit) -> bool {
        match self {
            Structure::Accel(accel) => accel.occluded(ray, any),
            Structure::Cwbvh(tree) => tree.occluded(ray, any),
        }
    }
}

/// A structure over a scene, with its measured rates.
pub(super) struct Row {
    /// Name in reports, such as `embree-robust`.
    pub(super) title: String,
    pub(super) structure: Structure,
    pub(super) build_seconds: f64,
    pub(super) bytes: usize,
    /// Rates by thread count, in the order of the request.
    pub(super) paces: Vec<Pace>,
}

/// Million rays per second at one thread count, round by round.
pub(super) struct Pace {
    pub(super) threads: usize,
    /// All rays in render order.
    pub(super) raw: Vec<f64>,
    /// Rates by group of the stream.
    pub(super) groups: Vec<Vec<f64>>,
    /// Rates inside a render; empty for a structure that cannot render.
    pub(super) render: Vec<f64>,
}

impl Row {
    /// Builds a backend.
    ///
    /// # Errors
    /// As [`Accel::build`].
    pub(super) fn of_backend(geometry: &Geometry, (backend, build): (Backend, Build), threads: usize) -> Result<Row> {
        let clock = Stopwatch::start();
        let accel = Accel::build(geometry, backend, build, threads)?;
        let bytes = accel.bytes();
        Ok(Row::new(title((backend, build)), Structure::Accel(accel), clock, bytes))
    }

    /// Builds obvhs's CWBVH.
    ///
    /// # Errors
    /// As [`Cwbvh::build`].
    pub(super) fn of_cwbvh(geometry: &Geometry) -> Result<Row> {
        let clock = Stopwatch::start();
        let tree = Cwbvh::build(geometry)?;
        let bytes = tree.bytes();
        Ok(Row::new("obvhs-cwbvh".into(), Structure::Cwbvh(tree), clock, bytes))
    }

    fn new(title: String, structure: Structure, clock: Stopwatch, bytes: usize) -> Row {
        Row { title, structure, build_seconds: clock.wall().as_secs_f64(), bytes, paces: Vec::new() }
    }

    /// Traces the rays and returns million rays per second.
    fn rate(&self, questions: &[RayQuery]) -> f64 {
        match &self.structure {
            Structure::Accel(accel) => rate(accel, questions),
            Structure::Cwbvh(tree) => rate(tree, questions),
        }
    }

    /// Times a pass with this row's backend, which is lent to the stage meanwhile.
    fn render(&mut self, stage: LoadedScene, view: &View, pass: u64) -> (LoadedScene, Option<f64>) {
        let Structure::Accel(accel) = &mut self.structure else { return (stage, None) };
        let lent = exchanged(stage, accel);
        let clock = Stopwatch::start();
        let rays = view.pass(&lent.scene, pass).total();
        let rate = rays as f64 / MILLION / clock.wall().as_secs_f64();
        (exchanged(lent, accel), Some(rate))
    }
}

/// Swaps the stage's backend with `accel`.
fn exchanged(stage: LoadedScene, accel: &mut Accel) -> LoadedScene {
    LoadedScene { scene: stage.scene.with_accel(|own| (std::mem::replace(accel, own), ())).0, ..stage }
}

fn rate(accel: &impl Intersector, questions: &[RayQuery]) -> f64 {
    let times = FEWEST.div_ceil(questions.len().max(1));
    let hits = |chunk: &[RayQuery]| chunk.iter().filter(|question| question.ask(accel)).count();
    let clock = Stopwatch::start();
    black_box((0..times).into_par_iter().map(|_| questions.par_chunks(CHUNK).map(hits).sum::<usize>()).sum::<usize>());
    (times * questions.len()) as f64 / MILLION / clock.wall().as_secs_f64()
}

/// Times everything once. For each thread pool, the measurements are all rays, each group, and a pass. Within each
/// measurement the rows take turns.
pub(super) fn round(
    mut stage: LoadedScene,
    view: &View,
    (stream, groups): (&RayStream, &[Group]),
    rows: &mut [Row],
    pools: &[rayon::ThreadPool],
    pass: u64,
) -> LoadedScene {
    for (at, pool) in pools.iter().enumerate() {
        for row in rows.iter_mut() {
            let rate = pool.install(|| row.rate(&stream.questions));
            row.paces[at].raw.push(rate);
        }
        for (number, group) in groups.iter().enumerate() {
            for row in rows.iter_mut() {
                let rate = pool.install(|| row.rate(&group.questions));
                row.paces[at].groups[number].push(rate);
            }
        }
        for row in rows.iter_mut() {
            let rendered = pool.install(|| row.render(stage, view, pass));
            stage = rendered.0;
            row.paces[at].render.extend(rendered.1);
        }
    }
    stage
}
