//! Writes the report as an HTML page.

use super::compare::CategoryRow;
use super::report::{PaceRates, Rate, RaysReport, RowRates, SceneRates};
use crate::error::Result;
use crate::io::atomic::write_atomically;
use crate::lab::html::{Page, Plot, Series, facts, key, table};
use crate::named::Named;
use maud::{Markup, html};
use std::io::Write;
use std::path::Path;

const LEAD: &str = "Rays of one render pass, recorded and replayed with nothing in between on every backend and build: \
    how many million a second are answered, what share of that a render reaches, and whether all hit the same. Rates \
    are medians over rounds; brackets hold the slowest and the fastest round.";

const NOTES: [&str; 9] = [
    "Raw is all that was recorded, replayed in the order of the render; the classes are replayed each by itself. \
     camera: from the camera. bounce-n: from the n-th scattering event of a path. shadow: toward lights; it is only \
     asked whether there is anything.",
    "Names that end with 8 or 16: the rays go in batches of 1,024 to the backend, which traces them in packets of 8 \
     or 16. batch: a backend without packets gets the same batches. coherent: the backend is told that consecutive \
     rays take similar ways, whether they do or not; path tells so of camera rays and of shadow rays of their hits. \
     Other rows get the rays one by one. The order is that of the recorded pass: pixels row by row, and in batched \
     execution all rays of a batch's bounce together.",
    "Rows take turns within every measurement, so that whatever else the machine does falls on all of them.",
    "In the render: rays that a pass counts over its wall-clock time, which has everything in it that is not ray \
     tracing. The share is that rate over the raw rate of the same row, number of threads and round.",
    "obvhs-cwbvh is obvhs's own eight-wide compressed tree with its own traversal and triangle test, which lose rays \
     at edges and within 1e-4 of their origin; instances are flattened. It is measured on scenes as it is, cannot be \
     rendered with, and is not asked hard cases.",
    "Bytes are those of the structure, for each triangle of distinct meshes. Each structure is built once.",
    "A tie is another triangle at a distance that rounding cannot tell apart, a graze one that is passed within \
     rounding of its edge. Any other difference is a true one: one of the two is wrong.",
    "A leak is a ray that leaves a closed body; it is counted in hard cases whose rays all begin inside of one, and \
     nowhere else.",
    "True differences in far-origin and scale-1e-40 are errors of Embree: an exact judge (tests/accel) finds obvhs's \
     answers right.",
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
    let source = match (&scene.counted, scene.execution) {
        (None, _) => "taken from a file".into(),
        (_, None) => "recorded in a pass".into(),
        (_, Some(execution)) => format!("recorded in a pass of {} execution", execution.name()),
    };
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

/// Two tables: the main rates, and the rates by class.
fn rates(scene: &SceneRates) -> Markup {
    let lines = |line: &dyn Fn(&RowRates, &PaceRates) -> Vec<String>| -> Vec<Vec<String>> {
        scene.rows.iter().flat_map(|row| row.paces.iter().map(move |pace| line(row, pace))).collect()
    };
    let all = lines(&|row, pace| {
        let built = [format!("{:.3} s", row.build_seconds), format!("{:.0}", row.bytes_per_triangle)];
        let rates = [cell(2, Some(pace.raw)), cell(2, pace.render), cell(3, pace.share)];
        [row.backend.clone(), pace.threads.to_string()].into_iter().chain(rates).chain(built).collect()
    });
    let classes = lines(&|row, pace| {
        let rates = pace.classes.iter().map(|class| cell(2, Some(class.rate)));
        [row.backend.clone(), pace.threads.to_string()].into_iter().chain(rates).collect()
    });
    let head = ["", "threads", "raw", "in the render", "share", "built in", "bytes / triangle"].map(String::from);
    let names = scene.classes.iter().map(|class| class.name.clone());
    let class_head: Vec<String> = ["", "threads"].map(String::from).into_iter().chain(names).collect();
    html! {
        (table("Million rays per second", &head, &all))
        (table("Million rays per second, raw, each class by itself", &class_head, &classes))
    }
}

/// Formats a rate with its spread.
fn cell(digits: usize, rate: Option<Rate>) -> String {
    rate.map_or("–".into(), |r| format!("{:.digits$} [{:.digits$}, {:.digits$}]", r.median, r.least, r.most))
}

/// Plot of rates over thread counts, one colour per row of single rays.
fn scaling(scene: &SceneRates) -> Markup {
    let series = |of: fn(&PaceRates) -> Option<Rate>| -> Vec<Series> {
        let line = |(hue, row): (usize, &RowRates)| {
            let points = row.paces.iter().filter_map(|pace| Some((pace.threads as f64, of(pace)?)));
            let (curve, band) = points.map(|(x, rate)| ([x, rate.median], [rate.least, rate.most])).unzip();
            Series { label: row.backend.clone(), hue, dash: 0, curve, band }
        };
        scene.rows.iter().filter(|row| row.batch.is_none()).enumerate().map(line).collect()
    };
    let figure = |y: &str, series: &[Series]| {
        let title =
            format!("{}: {y} against threads, both logarithmic. The numbers are in the table above.", scene.name);
        html! { figure { (Plot { title: &title, x: "threads", y, series, guide: Some(1.0) }.draw()) } }
    };
    let (raw, render) = (series(|pace| Some(pace.raw)), series(|pace| pace.render));
    html! {
        h3 { "Threads" }
        p.soft { "Dotted: twice the rate with twice the threads." }
        (key(&raw))
        div.grid { (figure("Mrays/s raw", &raw)) (figure("Mrays/s in the render", &render)) }
    }
}

fn hits(caption: &str, found: &[&CategoryRow]) -> Markup {
    let head =
        ["", "backend", "beside", "rays", "hits", "ties", "grazes", "true differences", "leaks"].map(String::from);
    let line = |row: &&CategoryRow| {
        let (category, tally) = (&row.category, &row.category.tally);
        let counts = [tally.rays, tally.hits, tally.ties, tally.grazes, tally.true_differences];
        let mut line = vec![category.name.clone(), category.backend.clone(), category.reference.clone()];
        line.extend(counts.map(|count| count.to_string()));
        line.push(if row.scene.is_some() { "–".into() } else { tally.leaks.to_string() });
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
