//! Measured results as one JSON document and as tables.

use super::compare::CategoryRow;
use super::row::{Mode, Pace, Row};
use super::stream::Group;
use crate::accel::{Coherence, Packet};
use crate::error::Result;
use crate::integrator::{Execution, RayCounts};
use crate::lab::{Conditions, report_files};
use serde::Serialize;
use std::path::Path;

/// All measured results.
#[derive(Debug, Clone, Serialize)]
pub struct RaysReport {
    /// The program, the machine and the command.
    #[serde(flatten)]
    pub conditions: Conditions,
    /// Number of rounds per rate.
    pub rounds: u32,
    /// Thread counts.
    pub threads: Vec<usize>,
    /// Rates by scene.
    pub scenes: Vec<SceneRates>,
    /// Hit comparisons: by scene, class and backend, then by hard case and backend.
    pub categories: Vec<CategoryRow>,
}

/// Ray rates of a scene.
#[derive(Debug, Clone, Serialize)]
pub struct SceneRates {
    /// Its name.
    pub name: String,
    /// Hash of its content.
    pub hash: String,
    /// Size of the picture whose passes are timed. The stream is recorded from it unless it is loaded from a file.
    pub size: [u32; 2],
    /// Triangles in distinct meshes.
    pub triangles: usize,
    /// Triangles as placed, counted once per instance.
    pub placed_triangles: usize,
    /// Number of rays of the stream.
    pub rays: usize,
    /// Number of rays of each class.
    pub classes: Vec<ClassSize>,
    /// Ray counts of the recorded pass itself; `None` if the stream was loaded from a file.
    pub counted: Option<RayCounts>,
    /// Execution of `path` in the recorded pass, which orders its rays; `None` for other methods, and if the stream was
    /// loaded from a file.
    pub execution: Option<Execution>,
    /// Rates by backend and build, and by how rays are given to them.
    pub rows: Vec<RowRates>,
    /// Rows that could not be measured, with the reasons.
    pub left_out: Vec<String>,
}

/// Number of rays of a class.
#[derive(Debug, Clone, Serialize)]
pub struct ClassSize {
    /// The class.
    pub name: String,
    /// Its rays.
    pub rays: usize,
}

/// Ray rates of a backend on a scene.
#[derive(Debug, Clone, Serialize)]
pub struct RowRates {
    /// The backend and its build, and how it gets its rays: `embree-robust`, `embree-robust-16-coherent`.
    pub backend: String,
    /// How it gets batches of rays; `None` for rays one by one.
    pub batch: Option<BatchMode>,
    /// Build time of the structure in seconds, measured once.
    pub build_seconds: f64,
    /// Bytes of the structure per triangle of the distinct meshes.
    pub bytes_per_triangle: f64,
    /// Rates by thread count.
    pub paces: Vec<PaceRates>,
}

/// How a backend gets batches of rays.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct BatchMode {
    /// Rays in a packet; `None` for a backend without packets.
    pub packet: Option<u32>,
    /// Whether it is told that consecutive rays take similar ways.
    pub coherent: bool,
}

/// Million rays per second at one thread count.
#[derive(Debug, Clone, Serialize)]
pub struct PaceRates {
    /// The thread count.
    pub threads: usize,
    /// All rays in render order, without shading.
    pub raw: Rate,
    /// Rates by ray class.
    pub classes: Vec<ClassRate>,
    /// Rays of a render; `None` for a structure that cannot render, and for batches.
    pub render: Option<Rate>,
    /// Render rate over raw rate, round by round.
    pub share: Option<Rate>,
}

/// Million rays per second of a class.
#[derive(Debug, Clone, Serialize)]
pub struct ClassRate {
    /// The class.
    pub name: String,
    /// Its rate.
    pub rate: Rate,
}

/// Statistics of a quantity over the rounds.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Rate {
    /// The median.
    pub median: f64,
    /// The smallest value, of the slowest round.
    pub least: f64,
    /// The largest value, of the fastest round.
    pub most: f64,
}

impl Rate {
    /// Statistics of at least one round; `None` for none.
    fn of(rounds: &[f64]) -> Option<Rate> {
        let mut sorted = rounds.to_vec();
        sorted.sort_by(f64::total_cmp);
        let middle = [(sorted.len().checked_sub(1)?) / 2, sorted.len() / 2].map(|at| sorted[at]);
        Some(Rate { median: 0.5 * (middle[0] + middle[1]), least: *sorted.first()?, most: *sorted.last()? })
    }
}

impl RowRates {
    /// Returns the rates of a structure by mode.
    pub(super) fn of(row: &Row, groups: &[Group], triangles: usize) -> Vec<RowRates> {
        let rates = row.ways.iter().map(|way| RowRates {
            backend: row.title_of(way.mode),
            batch: BatchMode::of(way.mode),
            build_seconds: row.build_seconds,
            bytes_per_triangle: row.bytes as f64 / triangles.max(1) as f64,
            paces: way.paces.iter().filter_map(|pace| PaceRates::of(pace, groups)).collect(),
        });
        rates.collect()
    }
}

impl BatchMode {
    fn of(mode: Mode) -> Option<BatchMode> {
        let Mode::Batch { packet, coherence } = mode else { return None };
        Some(BatchMode { packet: packet.map(Packet::rays), coherent: coherence == Coherence::Coherent })
    }
}

impl PaceRates {
    fn of(pace: &Pace, groups: &[Group]) -> Option<PaceRates> {
        let class =
            |(group, rounds): (&Group, &Vec<f64>)| Some(ClassRate { name: group.name.into(), rate: Rate::of(rounds)? });
        let shares: Vec<f64> = pace.render.iter().zip(&pace.raw).map(|(render, raw)| render / raw).collect();
        Some(PaceRates {
            threads: pace.threads,
            raw: Rate::of(&pace.raw)?,
            classes: groups.iter().zip(&pace.groups).filter_map(class).collect(),
            render: Rate::of(&pace.render),
            share: Rate::of(&shares),
        })
    }
}

/// Returns the number of rays of each group.
pub(super) fn sizes(groups: &[Group]) -> Vec<ClassSize> {
    groups.iter().map(|group| ClassSize { name: group.name.into(), rays: group.questions.len() }).collect()
}

/// A line of `rates.csv`.
#[derive(Serialize)]
struct RateLine<'a> {
    scene: &'a str,
    backend: &'a str,
    threads: usize,
    /// `raw`, a class, `render` or `share`.
    what: &'a str,
    median: f64,
    least: f64,
    most: f64,
}

/// A line of `categories.csv`.
#[derive(Serialize)]
struct CategoryLine<'a> {
    scene: &'a str,
    name: &'a str,
    backend: &'a str,
    reference: &'a str,
    rays: u64,
    hits: u64,
    leaks: u64,
    true_differences: u64,
    ties: u64,
    grazes: u64,
    addresses: String,
}

/// Writes `report.json`, `rates.csv` and `categories.csv`.
pub(super) fn write(folder: &Path, report: &RaysReport) -> Result<()> {
    report_files::json(&folder.join("report.json"), report)?;
    report_files::csv(&folder.join("rates.csv"), report.scenes.iter().flat_map(rate_lines))?;
    report_files::csv(&folder.join("categories.csv"), report.categories.iter().map(category_line))
}

fn rate_lines(scene: &SceneRates) -> Vec<RateLine<'_>> {
    let mut lines = Vec::new();
    for (row, pace) in scene.rows.iter().flat_map(|row| row.paces.iter().map(move |pace| (row, pace))) {
        let classes = pace.classes.iter().map(|class| (&*class.name, Some(class.rate)));
        let all = [("raw", Some(pace.raw))].into_iter().chain(classes);
        for (what, rate) in all.chain([("render", pace.render), ("share", pace.share)]) {
            let Some(Rate { median, least, most }) = rate else { continue };
            lines.push(RateLine {
                scene: &scene.name,
                backend: &row.backend,
                threads: pace.threads,
                what,
                median,
                least,
                most,
            });
        }
    }
    lines
}

fn category_line(row: &CategoryRow) -> CategoryLine<'_> {
    let (category, tally) = (&row.category, &row.category.tally);
    CategoryLine {
        scene: row.scene.as_deref().unwrap_or_default(),
        name: &category.name,
        backend: &category.backend,
        reference: &category.reference,
        rays: tally.rays,
        hits: tally.hits,
        leaks: tally.leaks,
        true_differences: tally.true_differences,
        ties: tally.ties,
        grazes: tally.grazes,
        addresses: row.addresses.join(" "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_medians_and_shares_are_paired_by_round() {
        let group = Group::new("camera", Vec::new());
        let pace = Pace {
            threads: 2,
            raw: vec![4.0, 2.0, 8.0],
            groups: vec![vec![1.0, 3.0, 2.0]],
            render: vec![1.0, 1.0, 6.0],
        };
        let rates = PaceRates::of(&pace, &[group]).unwrap();
        let numbers = |rate: Rate| [rate.median, rate.least, rate.most];
        assert_eq!(numbers(rates.raw), [4.0, 2.0, 8.0]);
        assert_eq!(numbers(rates.classes[0].rate), [2.0, 1.0, 3.0]);
        assert_eq!(numbers(rates.share.unwrap()), [0.5, 0.25, 0.75]);
        assert_eq!(numbers(Rate::of(&[4.0, 1.0, 3.0, 2.0]).unwrap()), [2.5, 1.0, 4.0]);
        let cannot_render = PaceRates::of(&Pace { render: Vec::new(), ..pace }, &[]).unwrap();
        assert!(cannot_render.render.is_none() && cannot_render.share.is_none());
    }
}
