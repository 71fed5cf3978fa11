//! The report as a page to read.

use super::compare::CategoryRow;
use super::report::{PaceRates, Rate, RaysReport, RowRates, SceneRates};
use crate::error::Result;
use crate::io::atomic::write_atomically;
use crate::io::page::{Page, Plot, Series, facts, key, table};
use maud::{Markup, html};
use std::io::Write;
use std::path::Path;

const LEAD: &str = "Rays of one render pass, recorded and replayed with nothing in between on every backend and build: how many \
    million a second are answered, what share of that a render reaches, and whether all hit the same. Rates are medians over rounds; \
    brackets hold the slowest and the fastest round.";

const NOTES: [&str; 8] = [
    "All is what was recorded, in the order of the render; the classes are replayed each by itself. camera: from the camera. bounce-n: \
     from the n-th scattering event of a path. shadow: toward lights; it is only asked whether there is anything.",
    "Rows take turns within every measurement, so that whatever else the machine does falls on all of them.",
    "In the render: rays that a pass counts over its wall-clock time, which has everything in it that is not ray tracing. The share is \
     that rate over the raw rate of the same row, number of threads and round.",
    "obvhs-cwbvh is obvhs's own eight-wide compressed tree with its own traversal and triangle test, which lose rays at edges and within \
     1e-4 of their origin; instances are flattened. It is measured as it is and cannot be rendered with.",
    "Bytes are those of the structure, for each triangle of distinct meshes. Each structure is built once.",
    "A tie is another triangle at a distance that rounding cannot tell apart, a graze one that is passed within rounding of its edge. \
     Any other difference is a true one: one of the two is wrong.",
    "A leak is a ray that leaves a closed body; it is counted in hard cases whose rays all begin inside of one, and nowhere else.",
    "True differences in far-origin and scale-1e-40 are errors of Embree: an exact judge (tests/accel) finds obvhs's answers right.",
];

/// Writes `index.html`.
pub(super) fn write(folder: &Path, report: &RaysReport) -> Result<()> {
    let mut page = Page::new("Rays per second", LEAD);
    for scene in &report.scenes {
        let found: Vec<_> = report.categories.iter().filter(|row| row.scene.as_ref() == Some(&scene.name)).collect();
        page.section(&scene.name, &section(scene, &found, report));
    }
    let hard: Vec<_> = report.categories.iter().filter(|row| row.scene.is_none()).collect();
    if !hard.is_empty() {
        page.section("Hard cases", &hits("Rays that go wrong in ray tracers", &hard));
    }
    let threads: Vec<String> = report.threads.iter().map(usize::to_string).collect();
    let more = [("Threads", threads.join(", ")), ("Rounds", report.rounds.to_string())];
    let files = "report.json, rates.csv and categories.csv";
    page.section("Machine and command", &report.conditions.markup(more, files));
    page.section("How to read this", &html! { ul { @for note in NOTES { li { (note) } } } });
    write_atomically(&folder.join("index.html"), |file| file.write_all(page.html().as_bytes()))
}

fn section(scene: &SceneRates, found: &[&CategoryRow], report: &RaysReport) -> Markup {
    let [width, height] = scene.size;
    let classes: Vec<String> = scene.classes.iter().map(|class| format!("{} {}", class.rays, class.name)).collect();
    let source = if scene.counted.is_some() { "recorded in a pass" } else { "taken from a file" };
    html! {
        (facts([
            ("Triangles", format!("{}, as placed {}", scene.triangles, scene.placed_triangles)),
            ("Rays", format!("{}, {source}: {}", scene.rays, classes.join(", "))),
            ("Passes", format!("{width} × {height}")),
        ]))
        @for reason in &scene.left_out { p { "Left out: " (reason) "." } }
        (rates(scene))
        @if report.threads.len() > 1 { (scaling(scene)) }
        (hits("What is hit, beside the reference", found))
    }
}

fn rates(scene: &SceneRates) -> Markup {
    let classes = scene.classes.iter().map(|class| class.name.as_str());
    let head =
        ["", "threads", "all"].into_iter().chain(classes).chain(["in the render", "share", "built in", "bytes / triangle"]);
    let head: Vec<String> = head.map(String::from).collect();
    let cell = |digits: usize, rate: Option<Rate>| {
        rate.map_or("–".into(), |r| format!("{:.digits$} [{:.digits$}, {:.digits$}]", r.median, r.least, r.most))
    };
    let line = |row: &RowRates, pace: &PaceRates| {
        let mut line = vec![row.backend.clone(), pace.threads.to_string(), cell(2, Some(pace.raw))];
        line.extend(pace.classes.iter().map(|class| cell(2, Some(class.rate))));
        line.extend([cell(2, pace.render), cell(3, pace.share)]);
        line.extend([format!("{:.3} s", row.build_seconds), format!("{:.0}", row.bytes_per_triangle)]);
        line
    };
    let lines: Vec<Vec<String>> = scene.rows.iter().flat_map(|row| row.paces.iter().map(move |pace| line(row, pace))).collect();
    table("Million rays per second", &head, &lines)
}

/// Rates over threads: colour by row, dashes for the render.
fn scaling(scene: &SceneRates) -> Markup {
    let series = |(hue, row): (usize, &RowRates)| {
        let line = |label: &str, dash: usize, of: fn(&PaceRates) -> Option<Rate>| {
            let points = row.paces.iter().filter_map(|pace| Some((pace.threads as f64, of(pace)?)));
            let (curve, band) = points.map(|(x, rate)| ([x, rate.median], [rate.least, rate.most])).unzip();
            Series { label: format!("{}, {label}", row.backend), hue, dash, curve, band }
        };
        [line("raw", 0, |pace| Some(pace.raw)), line("in the render", 1, |pace| pace.render)]
    };
    let series: Vec<Series> = scene.rows.iter().enumerate().flat_map(series).filter(|s| !s.curve.is_empty()).collect();
    let title =
        format!("{}: million rays per second against threads, both logarithmic. The numbers are in the table above.", scene.name);
    let plot = Plot { title: &title, x: "threads", y: "Mrays/s", series: &series, guide: Some(1.0) };
    html! {
        h3 { "Threads" }
        p.soft { "The dotted line would be twice the rate with twice the threads." }
        (key(&series))
        div.grid { figure { (plot.draw()) } }
    }
}

fn hits(caption: &str, found: &[&CategoryRow]) -> Markup {
    let head = ["", "backend", "beside", "rays", "hits", "ties", "grazes", "true differences", "leaks"].map(String::from);
    let line = |row: &&CategoryRow| {
        let (category, tally) = (&row.category, &row.category.tally);
        let counts = [tally.rays, tally.hits, tally.ties, tally.grazes, tally.true_differences, tally.leaks];
        let mut line = vec![category.name.clone(), category.backend.clone(), category.reference.clone()];
        line.extend(counts.map(|count| count.to_string()));
        line
    };
    let suspects: Vec<&&CategoryRow> = found.iter().filter(|row| !row.addresses.is_empty()).collect();
    html! {
        (table(caption, &head, &found.iter().map(line).collect::<Vec<_>>()))
        @if !suspects.is_empty() {
            details {
                summary { "Where true differences and leaks can be asked again" }
                p.soft { "Give an address to --replay, beside the other arguments of the command below." }
                ul { @for row in suspects { li { (row.category.backend) ": " code { (row.addresses.join(" ")) } } } }
            }
        }
    }
}
