//! How many rays per second backends answer, and whether they answer the same.
//!
//! The rays of one pass are recorded on one thread and replayed raw, with nothing in between, on every backend with every build
//! and on obvhs's CWBVH ([`crate::accel::bvh::cwbvh`]), class by class and all in the order of the render. Rows take turns
//! within each measurement of each round, so that whatever else the machine does falls on all of them; a pass is timed in the
//! same round, and its share of the raw rate says what of a render is not ray tracing.
//!
//! Before that all rows answer both queries about all rays and are compared with a reference, which is also their warm-up.

mod compare;
mod page;
mod record;
mod replay;
mod report;
mod row;
mod stream;
pub mod stream_file;

pub use compare::CategoryRow;
pub use replay::{Address, Answer, Met, Replay};
pub use report::{ClassRate, ClassSize, PaceRates, Rate, RaysReport, RowRates, SceneRates};
pub use stream::Stream;

use super::{Conditions, Settings, Stage, writable};
use crate::accel::{Backend, Build};
use crate::error::{Error, Result};
use crate::geometry::Geometry;
use crate::integrator::RayCounts;
use record::View;
use row::{Pace, Row};
use std::path::PathBuf;
use stream::Group;

/// A scene whose rays are recorded. Its own backend is what records them, so that addresses do not depend on what is measured.
pub struct Subject {
    /// What it is called in reports and addresses.
    pub name: String,
    /// The scene.
    pub stage: Stage,
    /// The picture.
    pub settings: Settings,
}

/// What is asked for.
pub struct Request {
    /// Backends and builds to measure, at least one.
    pub setups: Vec<(Backend, Build)>,
    /// Numbers of threads to measure with, at least one.
    pub threads: Vec<usize>,
    /// How often everything is measured.
    pub rounds: u32,
    /// About how many rays are recorded at most.
    pub rays: u64,
    /// How many rays of each hard case are compared; `None` for no hard cases.
    pub hard_case_rays: Option<u64>,
    /// A stream that is taken instead of recording one.
    pub load: Option<PathBuf>,
    /// Where the stream is kept.
    pub save: Option<PathBuf>,
    /// Where reports go, if anywhere.
    pub folder: Option<PathBuf>,
    /// The command that asks for it, to be shown.
    pub command: String,
}

/// A scene with its rays and everything that answers them.
struct Field {
    stage: Stage,
    view: View,
    stream: Stream,
    groups: Vec<Group>,
    counted: Option<RayCounts>,
    rows: Vec<Row>,
    left_out: Vec<String>,
    /// One for each number of threads.
    pools: Vec<rayon::ThreadPool>,
}

/// Measures, and writes `report.json`, `rates.csv`, `categories.csv` and `index.html` where a folder was asked for. Call it from
/// outside the rayon pool.
///
/// # Errors
/// Files that cannot be written or read, a stream of another scene, a camera or backend that is not there.
pub fn run(request: &Request, subjects: Vec<Subject>, note: &mut dyn FnMut(&str)) -> Result<RaysReport> {
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

/// Asks every row about one ray of a scene, which is `subject`, or of a hard case. Call it from outside the rayon pool.
///
/// # Errors
/// A usage error if there is no such ray; what [`run`] says of streams and backends.
pub fn replay(request: &Request, subject: Option<Subject>, address: &Address) -> Result<Replay> {
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

impl Request {
    fn most_threads(&self) -> usize {
        self.threads.iter().copied().max().unwrap_or(1)
    }
}

/// Everything about one scene.
fn measured(request: &Request, subject: Subject, note: &mut dyn FnMut(&str)) -> Result<(SceneRates, Vec<CategoryRow>)> {
    let mut field = Field::new(request, subject)?;
    let name = field.stream.name.clone();
    note(&format!("{name}: comparing the hits of {} rays", field.stream.questions.len()));
    let categories = compare::streams(field.stage.scene.geometry(), &name, &field.groups, &field.rows);
    for round in 0..request.rounds {
        note(&format!("{name}: round {} of {}", round + 1, request.rounds));
        field = field.timed(round);
    }
    Ok((field.rates(), categories))
}

impl Field {
    fn new(request: &Request, subject: Subject) -> Result<Field> {
        let (stage, view, stream, counted) = stream_of(request, subject)?;
        request.save.as_ref().map_or(Ok(()), |path| stream_file::write(path, &stream))?;
        let (mut rows, left_out) = rows(request, stage.scene.geometry())?;
        let groups = stream.groups();
        let pace =
            |&threads: &usize| Pace { threads, raw: Vec::new(), groups: vec![Vec::new(); groups.len()], render: Vec::new() };
        rows.iter_mut().for_each(|row| row.paces = request.threads.iter().map(pace).collect());
        let pools = request.threads.iter().map(|&threads| record::pool(threads)).collect::<Result<Vec<_>>>()?;
        Ok(Field { stage, view, stream, groups, counted, rows, left_out, pools })
    }

    /// One more round: pass 0 is the recorded one, and each round renders another.
    fn timed(mut self, round: u32) -> Field {
        let pass = u64::from(round) + 1;
        let stage = row::round(self.stage, &self.view, (&self.stream, &self.groups), &mut self.rows, &self.pools, pass);
        Field { stage, ..self }
    }

    fn rates(&self) -> SceneRates {
        let info = &self.stage.info;
        SceneRates {
            name: self.stream.name.clone(),
            hash: self.stage.scene.hash().to_owned(),
            size: self.view.size(),
            triangles: info.triangles,
            placed_triangles: info.placed_triangles,
            rays: self.stream.questions.len(),
            classes: report::sizes(&self.groups),
            counted: self.counted,
            rows: self.rows.iter().map(|row| RowRates::of(row, &self.groups, info.triangles)).collect(),
            left_out: self.left_out.clone(),
        }
    }
}

/// The rays of a scene, recorded or from a file.
fn stream_of(request: &Request, subject: Subject) -> Result<(Stage, View, Stream, Option<RayCounts>)> {
    let Subject { name, stage, settings } = subject;
    let view = View::within(&stage.scene, &settings, request.rays)?;
    let Some(path) = &request.load else {
        let (stage, stream, counted) = record::record(stage, &view, &name)?;
        return Ok((stage, view, stream, Some(counted)));
    };
    let stream = stream_file::read(path)?;
    if stream.scene_hash != stage.scene.hash() {
        let (from, scene) = (path.display(), stage.path.display());
        return Err(Error::usage(format!("--load {from}: its rays were recorded in another scene than {scene}")));
    }
    Ok((stage, view, Stream { name, ..stream }, None))
}

/// What answers: every backend and build, then CWBVH where obvhs is among them, or why not.
fn rows(request: &Request, geometry: &Geometry) -> Result<(Vec<Row>, Vec<String>)> {
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
