//! Measures the ray throughput of backends and checks that their answers agree.
//!
//! The rays of one pass are recorded on one thread. They are then replayed without shading on every backend with every
//! build, and on obvhs's CWBVH ([`crate::lab::bench_rays::cwbvh`]). They are replayed class by class, and all together
//! in render order. Each backend gets them one by one and in batches, with packets of each width and with both values
//! of [`crate::accel::Coherence`]. Rows take turns within each measurement of each round, so that background load
//! affects all of them alike. A full pass is timed in the same round. Its share of the raw rate shows the cost of
//! everything but ray tracing.
//!
//! Before the measurement, every row answers both queries for all rays and is compared with a reference. This
//! comparison is also the warm-up.

mod batch;
mod compare;
pub mod cwbvh;
mod page;
mod record;
mod recorder;
mod replay;
mod report;
mod row;
mod stream;
pub mod stream_file;

pub use compare::CategoryRow;
pub use recorder::{Query, RayQuery};
pub use replay::{Answer, Met, RayAddress, Replay};
pub use report::{BatchMode, ClassRate, ClassSize, PaceRates, Rate, RaysReport, RowRates, SceneRates};
pub use stream::RayStream;

use crate::accel::{Backend, Build};
use crate::error::{Error, Result};
use crate::geometry::Geometry;
use crate::integrator::{Execution, RayCounts};
use crate::lab::Conditions;
use crate::parallel::pool;
use crate::session::{LoadedScene, RenderSettings, writable};
use record::View;
use row::{Pace, Row};
use std::path::PathBuf;
use stream::Group;

/// A scene whose rays are recorded. They are recorded with the scene's own backend, so that addresses do not depend on
/// the measured ones.
pub struct RayBenchSubject {
    /// Name in reports and addresses.
    pub name: String,
    /// The scene.
    pub stage: LoadedScene,
    /// Settings of the picture.
    pub settings: RenderSettings,
}

/// A requested measurement.
pub struct RayBenchRequest {
    /// Backends and builds to measure, at least one.
    pub setups: Vec<(Backend, Build)>,
    /// Thread counts to measure with, at least one.
    pub threads: Vec<usize>,
    /// Number of rounds.
    pub rounds: u32,
    /// Approximate maximum of recorded rays.
    pub rays: u64,
    /// Number of rays compared per hard case; `None` skips the hard cases.
    pub hard_case_rays: Option<u64>,
    /// Stream file to load instead of recording.
    pub load: Option<PathBuf>,
    /// Stream file to save.
    pub save: Option<PathBuf>,
    /// Folder of the reports, if any.
    pub folder: Option<PathBuf>,
    /// The command line, shown in the report.
    pub command: String,
}

/// A scene with its rays and all structures that trace them.
struct Field {
    stage: LoadedScene,
    view: View,
    name: String,
    /// All rays of the stream.
    all: Group,
    groups: Vec<Group>,
    recording: Option<Recording>,
    rows: Vec<Row>,
    left_out: Vec<String>,
    /// One pool per thread count.
    pools: Vec<rayon::ThreadPool>,
}

/// Runs the measurement. Writes `report.json`, `rates.csv`, `categories.csv` and `index.html` if a folder was given.
/// Must be called from outside the rayon pool.
///
/// # Errors
/// Files cannot be written or read, a stream belongs to another scene, or a camera or backend does not exist.
pub fn run(
    request: &RayBenchRequest,
    subjects: Vec<RayBenchSubject>,
    note: &mut dyn FnMut(&str),
) -> Result<RaysReport> {
    if let Some(folder) = &request.folder {
        std::fs::create_dir_all(folder).map_err(|cause| Error::write(folder, cause))?;
        writable(&folder.join("report.json"))?;
    }
    request.save.as_deref().map_or(Ok(()), writable)?;
    let (mut scenes, mut categories) = (Vec::new(), Vec::new());
    for subject in subjects {
        let (rates, found) = measured(request, subject, note)?;
        scenes.push(rates);
        categories.extend(found);
    }
    if let Some(rays) = request.hard_case_rays {
        categories.extend(compare::hard(&request.setups, rays, request.most_threads(), note)?);
    }
    let (rounds, threads) = (request.rounds, request.threads.clone());
    let report = RaysReport { conditions: Conditions::now(&request.command), rounds, threads, scenes, categories };
    if let Some(folder) = &request.folder {
        report::write(folder, &report)?;
        page::write(folder, &report)?;
    }
    Ok(report)
}

/// Traces one ray on every row. The ray comes from a scene, given as `subject`, or from a hard case. Must be called
/// from outside the rayon pool.
///
/// # Errors
/// A usage error if there is no such ray; the errors of [`run`] about streams and backends.
pub fn replay(request: &RayBenchRequest, subject: Option<RayBenchSubject>, address: &RayAddress) -> Result<Replay> {
    if let Some(subject) = subject {
        let (stage, _, stream, _) = stream_of(request, subject)?;
        let ray = address.in_stream(&stream)?;
        let (rows, _) = rows(request, stage.scene.geometry())?;
        return Ok(replay::replay(address, stage.scene.geometry(), &ray, &rows));
    }
    let case = address.case()?;
    let (rows, _) = rows(request, case.geometry())?;
    Ok(replay::replay(address, case.geometry(), &case.ray(address.index), &rows))
}

impl RayBenchRequest {
    fn most_threads(&self) -> usize {
        self.threads.iter().copied().max().unwrap_or(1)
    }
}

/// Compares and measures one scene.
fn measured(
    request: &RayBenchRequest,
    subject: RayBenchSubject,
    note: &mut dyn FnMut(&str),
) -> Result<(SceneRates, Vec<CategoryRow>)> {
    let mut field = Field::new(request, subject)?;
    let name = field.name.clone();
    note(&format!("{name}: comparing the hits of {} rays", field.all.questions.len()));
    let categories = compare::streams(field.stage.scene.geometry(), &name, &field.groups, &mut field.rows);
    for round in 0..request.rounds {
        note(&format!("{name}: round {} of {}", round + 1, request.rounds));
        field = field.timed(round);
    }
    Ok((field.rates(), categories))
}

impl Field {
    fn new(request: &RayBenchRequest, subject: RayBenchSubject) -> Result<Field> {
        let (stage, view, stream, recording) = stream_of(request, subject)?;
        request.save.as_ref().map_or(Ok(()), |path| stream_file::write(path, &stream))?;
        let (mut rows, left_out) = rows(request, stage.scene.geometry())?;
        let groups = stream.groups();
        let pace = |&threads: &usize| Pace {
            threads,
            raw: Vec::new(),
            groups: vec![Vec::new(); groups.len()],
            render: Vec::new(),
        };
        let paces: Vec<Pace> = request.threads.iter().map(pace).collect();
        rows.iter_mut().flat_map(|row| &mut row.ways).for_each(|way| way.paces.clone_from(&paces));
        let pools = request.threads.iter().map(|&threads| pool(threads)).collect::<Result<Vec<_>>>()?;
        let (name, all) = (stream.name, Group::new("raw", stream.questions));
        Ok(Field { stage, view, name, all, groups, recording, rows, left_out, pools })
    }

    /// Runs one more round. Pass 0 is the recorded one, and each round renders another pass.
    fn timed(mut self, round: u32) -> Field {
        let pass = u64::from(round) + 1;
        let stage = row::round(self.stage, &self.view, (&self.all, &self.groups), &mut self.rows, &self.pools, pass);
        Field { stage, ..self }
    }

    fn rates(&self) -> SceneRates {
        let info = &self.stage.info;
        SceneRates {
            name: self.name.clone(),
            hash: self.stage.scene.hash().to_owned(),
            size: self.view.size(),
            triangles: info.triangles,
            placed_triangles: info.placed_triangles,
            rays: self.all.questions.len(),
            classes: report::sizes(&self.groups),
            counted: self.recording.map(|recording| recording.counted),
            execution: self.recording.and_then(|recording| recording.execution),
            rows: self.rows.iter().flat_map(|row| RowRates::of(row, &self.groups, info.triangles)).collect(),
            left_out: self.left_out.clone(),
        }
    }
}

/// Facts about a recorded pass.
#[derive(Clone, Copy)]
struct Recording {
    /// Its own ray counts.
    counted: RayCounts,
    /// How `path` was executed; `None` for other methods.
    execution: Option<Execution>,
}

/// The rays of a scene, recorded or loaded from a file.
fn stream_of(
    request: &RayBenchRequest,
    subject: RayBenchSubject,
) -> Result<(LoadedScene, View, RayStream, Option<Recording>)> {
    let RayBenchSubject { name, stage, settings } = subject;
    let view = View::within(&stage.scene, &settings, request.rays)?;
    let Some(path) = &request.load else {
        let (stage, stream, counted) = record::record(stage, &view, &name)?;
        let execution = view.execution(&stage.scene);
        return Ok((stage, view, stream, Some(Recording { counted, execution })));
    };
    let stream = stream_file::read(path)?;
    if stream.scene_hash != stage.scene.hash() {
        let (from, scene) = (path.display(), stage.path.display());
        return Err(Error::usage(format!("--load {from}: its rays were recorded in another scene than {scene}")));
    }
    Ok((stage, view, RayStream { name, ..stream }, None))
}

/// Builds every backend and build, then CWBVH if obvhs is among them. Also returns the rows that could not be built,
/// with the reasons.
fn rows(request: &RayBenchRequest, geometry: &Geometry) -> Result<(Vec<Row>, Vec<String>)> {
    let build = |&setup| Row::of_backend(geometry, setup, request.most_threads());
    let mut rows = request.setups.iter().map(build).collect::<Result<Vec<_>>>()?;
    if request.setups.iter().all(|(backend, _)| *backend != Backend::Obvhs) {
        return Ok((rows, Vec::new()));
    }
    match Row::of_cwbvh(geometry) {
        Ok(row) => rows.push(row),
        Err(reason) => return Ok((rows, vec![format!("obvhs-cwbvh: {}", reason.chain())])),
    }
    Ok((rows, Vec::new()))
}
