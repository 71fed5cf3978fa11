//! Rows of the measurement: a backend with a build, or obvhs's CWBVH, with the rates of its rounds by mode.

use super::batch::Answers;
use super::record::View;
use super::stream::Group;
use crate::accel::{Accel, Backend, Build, Coherence, Intersector, Packet};
use crate::error::Result;
use crate::geometry::{AnyHit, Geometry, Hit, Hits, Ray, Rays};
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

    fn closest_all(&self, rays: &Rays, coherence: Coherence, any: &impl AnyHit, hits: &mut Hits) {
        match self {
            Structure::Accel(accel) => accel.closest_all(rays, coherence, any, hits),
            Structure::Cwbvh(tree) => tree.closest_all(rays, coherence, any, hits),
        }
    }

    fn occluded_all(&self, rays: &Rays, coherence: Coherence, any: &impl AnyHit, occluded: &mut [bool]) {
        match self {
            Structure::Accel(accel) => accel.occluded_all(rays, coherence, any, occluded),
            Structure::Cwbvh(tree) => tree.occluded_all(rays, coherence, any, occluded),
        }
    }
}

/// How a structure gets its rays.
#[derive(Debug, Clone, Copy)]
pub(super) enum Mode {
    /// One by one.
    Single,
    /// In batches, which a backend with packets cuts into those of `packet`.
    Batch {
        /// `None` for a backend without packets.
        packet: Option<Packet>,
        /// What the backend is told of consecutive rays.
        coherence: Coherence,
    },
}

impl Mode {
    /// Returns all modes of `accel`, single rays first.
    fn of(accel: &Accel) -> Vec<Mode> {
        let packets = match accel.packets() {
            [] => vec![None],
            packets => packets.iter().copied().map(Some).collect(),
        };
        let batch =
            |packet| [Coherence::Incoherent, Coherence::Coherent].map(|coherence| Mode::Batch { packet, coherence });
        std::iter::once(Mode::Single).chain(packets.into_iter().flat_map(batch)).collect()
    }

    /// Returns what follows a structure's name in reports.
    fn suffix(self) -> String {
        let Mode::Batch { packet, coherence } = self else { return String::new() };
        let batch = packet.map_or("batch".into(), |packet| packet.rays().to_string());
        format!("-{batch}{}", if coherence == Coherence::Coherent { "-coherent" } else { "" })
    }
}

/// A structure over a scene, with its measured rates.
pub(super) struct Row {
    /// Name in reports, such as `embree-robust`.
    pub(super) title: String,
    pub(super) structure: Structure,
    pub(super) build_seconds: f64,
    pub(super) bytes: usize,
    /// Its rates by mode. The first mode is that of single rays.
    pub(super) ways: Vec<Way>,
}

/// A structure's rates in one mode.
pub(super) struct Way {
    pub(super) mode: Mode,
    /// Rates by thread count, in the order of the request.
    pub(super) paces: Vec<Pace>,
}

/// Million rays per second at one thread count, round by round.
#[derive(Debug, Clone)]
pub(super) struct Pace {
    pub(super) threads: usize,
    /// All rays in render order.
    pub(super) raw: Vec<f64>,
    /// Rates by group of the stream.
    pub(super) groups: Vec<Vec<f64>>,
    /// Rates inside a render; empty for a structure that cannot render, and for batches.
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
        let (bytes, modes) = (accel.bytes(), Mode::of(&accel));
        Ok(Row::new(title((backend, build)), Structure::Accel(accel), modes, clock, bytes))
    }

    /// Builds obvhs's CWBVH.
    ///
    /// # Errors
    /// As [`Cwbvh::build`].
    pub(super) fn of_cwbvh(geometry: &Geometry) -> Result<Row> {
        let clock = Stopwatch::start();
        let tree = Cwbvh::build(geometry)?;
        let bytes = tree.bytes();
        Ok(Row::new("obvhs-cwbvh".into(), Structure::Cwbvh(tree), vec![Mode::Single], clock, bytes))
    }

    fn new(title: String, structure: Structure, modes: Vec<Mode>, clock: Stopwatch, bytes: usize) -> Row {
        let ways = modes.into_iter().map(|mode| Way { mode, paces: Vec::new() }).collect();
        Row { title, structure, build_seconds: clock.wall().as_secs_f64(), bytes, ways }
    }

    /// Returns the name in reports of its rates in `mode`, such as `embree-robust-16-coherent`.
    pub(super) fn title_of(&self, mode: Mode) -> String {
        format!("{}{}", self.title, mode.suffix())
    }

    /// Sets the structure's width of packets to that of `mode`.
    pub(super) fn prepare(&mut self, mode: Mode) {
        if let (Structure::Accel(accel), Mode::Batch { packet: Some(packet), .. }) = (&mut self.structure, mode) {
            accel.set_packet(packet);
        }
    }

    /// Traces the rays in `mode` and returns million rays per second.
    fn rate(&mut self, mode: Mode, group: &Group) -> f64 {
        self.prepare(mode);
        match &self.structure {
            Structure::Accel(accel) => rate(accel, mode, group),
            Structure::Cwbvh(tree) => rate(tree, mode, group),
        }
    }

    /// Times a pass with this row's backend, which is lent to the stage meanwhile.
    fn render(&mut self, stage: LoadedScene, view: &View, pass: u64) -> (LoadedScene, Option<f64>) {
        let Structure::Accel(accel) = &mut self.structure else { return (stage, None) };
        if let Some(&widest) = accel.packets().last() {
            accel.set_packet(widest);
        }
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

fn rate(accel: &impl Intersector, mode: Mode, group: &Group) -> f64 {
    let Group { questions, batches, .. } = group;
    let times = FEWEST.div_ceil(questions.len().max(1));
    let single = |chunk: &[RayQuery]| chunk.iter().filter(|question| question.ask(accel)).count();
    let hits = || match mode {
        Mode::Single => questions.par_chunks(CHUNK).map(single).sum::<usize>(),
        Mode::Batch { coherence, .. } => {
            let answers = batches.par_iter().map_init(Answers::new, |room, batch| batch.ask(accel, coherence, room));
            answers.sum::<usize>()
        }
    };
    let clock = Stopwatch::start();
    black_box((0..times).into_par_iter().map(|_| hits()).sum::<usize>());
    (times * questions.len()) as f64 / MILLION / clock.wall().as_secs_f64()
}

/// Times everything once. For each thread pool, the measurements are all rays, each group, and a pass. Within each
/// measurement the rows and their modes take turns.
pub(super) fn round(
    mut stage: LoadedScene,
    view: &View,
    (all, groups): (&Group, &[Group]),
    rows: &mut [Row],
    pools: &[rayon::ThreadPool],
    pass: u64,
) -> LoadedScene {
    for (at, pool) in pools.iter().enumerate() {
        turns(rows, pool, all, |way, rate| way.paces[at].raw.push(rate));
        for (number, group) in groups.iter().enumerate() {
            turns(rows, pool, group, |way, rate| way.paces[at].groups[number].push(rate));
        }
        for row in rows.iter_mut() {
            let rendered = pool.install(|| row.render(stage, view, pass));
            stage = rendered.0;
            row.ways[0].paces[at].render.extend(rendered.1);
        }
    }
    stage
}

/// Times the rays of `group` on all rows in all modes; `keep` stores the rates.
fn turns(rows: &mut [Row], pool: &rayon::ThreadPool, group: &Group, keep: impl Fn(&mut Way, f64)) {
    for row in rows {
        for way in 0..row.ways.len() {
            let mode = row.ways[way].mode;
            let rate = pool.install(|| row.rate(mode, group));
            keep(&mut row.ways[way], rate);
        }
    }
}
