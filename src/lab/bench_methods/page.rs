//! Writes the report as an HTML page.

use super::contestant::BenchCase;
use super::curve::{CurvePoint, ErrorCurve, Interval, Slope};
use super::reference::Reference;
use super::report::{MethodsReport, Ratio, SceneReport};
use super::{BenchScene, MethodsRequest};
use crate::error::Result;
use crate::io::atomic::write_atomically;
use crate::lab::html::{FigurePicture, Page, Plot, Series, compare, facts, gallery, key, ramp, table};
use crate::session::{ToneMapping, megabytes};
use maud::{Markup, html};
use std::io::Write;

/// Smallest relative error shown; 1 has the brightest colour.
const LEAST_SHOWN: f64 = 0.01;

const LEAD: &str = "Error against time, methods and backends side by side. Error is relMSE: the mean over pixels and \
    channels of (image − reference)² / (reference² + ε). Points are geometric means over independent renders, bands \
    and brackets 95 % intervals.";

const NOTES: [&str; 5] = [
    "Time runs from the pilot to the last pass; warm-up, loading, building and the comparison with the reference are \
     not in it. Processor time is user and system time of all threads.",
    "All curves of all scenes take turns, repetition by repetition, so that whatever else the machine does falls on \
     all of them. Within a repetition all have the same seed.",
    "Efficiency is 1 / (relMSE × processor seconds) at the last point. Ratios are paired by repetition (Student's t on \
     their logarithms).",
    "Slopes are fitted to the logarithms, render by render; their intervals come from the scatter between renders. \
     Independent samples have −1 against samples.",
    "The dotted line in a plot has slope −1.",
];

/// Writes `index.html`.
pub(super) fn write(
    request: &MethodsRequest,
    report: &MethodsReport,
    subjects: &[BenchScene],
    fields: &[Vec<BenchCase<'_>>],
    references: &[Reference],
) -> Result<()> {
    let mut page = Page::new("Error against time", LEAD);
    for (at, scene) in report.scenes.iter().enumerate() {
        page.section(&scene.name, &section(scene, subjects[at].stages[0].1.tone, &fields[at], &references[at], at)?);
    }
    if !report.over_scenes.is_empty() {
        let caption = "Efficiency of the row over that of the column: geometric mean over the scenes that both see \
            whole, 95 % interval";
        page.section("Over all scenes", &ratios(caption, &report.over_scenes));
    }
    page.section("Machine and command", &machine(report));
    page.section("How to read this", &html! { ul { @for note in NOTES { li { (note) } } } });
    write_atomically(&request.folder.join("index.html"), |file| file.write_all(page.html().as_bytes()))
}

fn machine(report: &MethodsReport) -> Markup {
    let budget = format!("{} s for the {} repetitions of each curve", report.budget_seconds, report.repetitions);
    report.conditions.markup([("Threads", report.threads.to_string()), ("Time", budget)], "report.json and points.csv")
}

fn section(
    scene: &SceneReport,
    look: ToneMapping,
    field: &[BenchCase<'_>],
    reference: &Reference,
    at: usize,
) -> Result<Markup> {
    let [width, height] = scene.size;
    let record = &scene.reference;
    let against = |x: &str, seconds: fn(&CurvePoint) -> f64| {
        let series = series(scene, seconds);
        let title =
            format!("{}: relMSE against {x}, both logarithmic. The numbers are in the table below.", scene.name);
        html! { figure { (Plot { title: &title, x, y: "relMSE", series: &series, guide: Some(-1.0) }.draw()) } }
    };
    let pictures = pictures(look, field, reference, scene)?;
    let group = format!("p{at}");
    Ok(html! {
        (facts([
            ("Images", format!("{width} × {height}, {}", scene.settings)),
            ("Reference", record.origin.clone()),
            ("Its own relMSE", own_error(scene)),
            ("ε", format!("{:.3e}, the square of a tenth of the reference's mean", record.epsilon)),
        ]))
        (blind(&scene.curves))
        (key(&series(scene, |p| p.cpu_seconds)))
        div.grid { (against("processor seconds", |p| p.cpu_seconds)) (against("wall-clock seconds", |p| p.wall_seconds)) }
        (curves(&scene.curves))
        (ratios("Efficiency of the row over that of the column, 95 % interval", &scene.ratios))
        h3 { "Images" }
        p.soft { "The last image of the first repetition; times differ, so compare by the plots. Maps show the error \
            of each pixel relative to the reference." }
        (compare(&group, &pictures))
        (ramp("Relative error of a pixel", ["1 % or less", "10 %", "100 % or more"]))
        details { summary { "All images and maps, small" } (gallery(&group, &pictures)) }
    })
}

fn own_error(scene: &SceneReport) -> String {
    let Some(noise) = scene.reference.noise else {
        return "unknown and not subtracted: small errors are overstated by it".into();
    };
    let share = scene.reference_share.unwrap_or(f64::NAN);
    let poor = if scene.is_reference_poor() { ", more than the tenth that makes errors trustworthy" } else { "" };
    let cut = if scene.reference.is_cut_short { "; its time was over too soon" } else { "" };
    format!("{noise:.2e}, subtracted; {share:.2} of the least error compared{poor}{cut}")
}

fn blind(curves: &[ErrorCurve]) -> Markup {
    let blind: Vec<&ErrorCurve> = curves.iter().filter(|c| !c.blind_spots.is_empty()).collect();
    html! {
        @if !blind.is_empty() {
            p { "Left out of ratios, since they do not see all of the scene and end at another image:" }
            ul { @for curve in blind { li { (curve.label) ": " (curve.blind_spots.join("; ")) } } }
        }
    }
}

/// Colour by method, dashes by backend.
fn series(scene: &SceneReport, x: fn(&CurvePoint) -> f64) -> Vec<Series> {
    let part = |label: &str, at: usize| label.split(", ").nth(at).unwrap_or_default().to_owned();
    let number = |at: usize, label: &str| {
        let mut seen: Vec<String> = scene.curves.iter().map(|c| part(&c.label, at)).collect();
        let mut names = std::collections::HashSet::new();
        seen.retain(|name| names.insert(name.clone()));
        seen.iter().position(|name| *name == part(label, at)).unwrap_or(0)
    };
    let one = |curve: &ErrorCurve| {
        let seen = curve.points.iter().filter_map(|p| Some((x(p), p.relmse?)));
        let (curve_points, band) = seen.map(|(x, e)| ([x, e.value], [e.low, e.high])).unzip();
        let mark = if curve.blind_spots.is_empty() { "" } else { " (blind)" };
        Series {
            label: format!("{}{mark}", curve.label),
            hue: number(0, &curve.label),
            dash: number(1, &curve.label),
            curve: curve_points,
            band,
        }
    };
    scene.curves.iter().map(one).collect()
}

fn curves(curves: &[ErrorCurve]) -> Markup {
    let head = [
        "",
        "spp",
        "CPU s",
        "wall s",
        "relMSE",
        "efficiency",
        "slope in time",
        "slope in samples",
        "Mrays/s",
        "Mrays/CPU s",
        "memory",
        "built in",
    ];
    let row = |curve: &ErrorCurve| {
        let last = curve.points.last();
        let number = |f: fn(&CurvePoint) -> f64| last.map_or("–".into(), |p| format!("{:.3}", f(p)));
        let mark = if curve.blind_spots.is_empty() { "" } else { " (blind)" };
        vec![
            format!("{}{mark}", curve.label),
            last.map_or("–".into(), |p| p.spp.to_string()),
            number(|p| p.cpu_seconds),
            number(|p| p.wall_seconds),
            last.and_then(|p| p.relmse).map_or("lost in noise".into(), scientific),
            curve.efficiency.filter(|_| curve.blind_spots.is_empty()).map_or("–".into(), plain),
            curve.slope_in_time.map_or("–".into(), slope),
            curve.slope_in_samples.map_or("–".into(), slope),
            format!("{:.2}", curve.mrays_per_second),
            format!("{:.2}", curve.mrays_per_cpu_second),
            megabytes(curve.memory_bytes),
            format!("{:.3} s", curve.build_seconds),
        ]
    };
    let rows: Vec<Vec<String>> = curves.iter().map(row).collect();
    table("At the last point; brackets are 95 % intervals", &head.map(String::from), &rows)
}

/// Table of ratios.
fn ratios(caption: &str, ratios: &[Ratio]) -> Markup {
    let mut names: Vec<&str> = Vec::new();
    ratios.iter().for_each(|r| {
        if !names.contains(&r.of.as_str()) {
            names.push(&r.of);
        }
    });
    if names.is_empty() {
        return html! {};
    }
    let cell = |of: &str, to: &str| match ratios.iter().find(|r| r.of == of && r.to == to) {
        Some(ratio) => ratio.efficiency.map_or("lost in noise".into(), plain),
        None => "–".into(),
    };
    let row = |of: &&str| std::iter::once((*of).to_owned()).chain(names.iter().map(|to| cell(of, to))).collect();
    let head: Vec<String> = std::iter::once("").chain(names.iter().copied()).map(String::from).collect();
    table(caption, &head, &names.iter().map(row).collect::<Vec<_>>())
}

fn pictures(
    look: ToneMapping,
    field: &[BenchCase<'_>],
    reference: &Reference,
    scene: &SceneReport,
) -> Result<Vec<FigurePicture>> {
    let crop = field.first().map(|c| c.settings.layout().crop);
    let [width, height] = crop.map_or([0, 0], |c| [c.x1 - c.x0, c.y1 - c.y0]);
    let show = |name: &str, rgb: &[f32]| FigurePicture::of_values(name, width, height, rgb, look.exposure, look.curve);
    let mut pictures = Vec::new();
    for (contestant, curve) in field.iter().zip(&scene.curves) {
        let last = curve.points.last().map_or(0, |p| p.spp);
        pictures.push(show(&format!("{}, {last} spp", curve.label), &contestant.picture)?);
    }
    pictures.insert(1.min(pictures.len()), show("reference", &reference.rgb)?);
    for (contestant, curve) in field.iter().zip(&scene.curves) {
        let name = format!("error of {}", curve.label);
        pictures.push(FigurePicture::of_shares(&name, width, height, &errors(&contestant.picture, reference))?);
    }
    Ok(pictures)
}

/// Relative error of each pixel on a logarithmic scale: 0 for [`LEAST_SHOWN`], 1 for 1.
fn errors(rgb: &[f32], reference: &Reference) -> Vec<f32> {
    let epsilon = reference.record.epsilon;
    let term = |(&i, &r): (&f32, &f32)| f64::from(i - r).powi(2) / (f64::from(r).powi(2) + epsilon);
    let pixel = |(image, truth): (&[f32], &[f32])| {
        let error = (image.iter().zip(truth).map(term).sum::<f64>() / image.len() as f64).sqrt();
        1.0 - (error.max(LEAST_SHOWN).ln() / LEAST_SHOWN.ln()) as f32
    };
    rgb.chunks(3).zip(reference.rgb.chunks(3)).map(pixel).collect()
}

fn scientific(i: Interval) -> String {
    format!("{:.2e} [{:.2e}, {:.2e}]", i.value, i.low, i.high)
}

/// Formats with three significant digits.
fn plain(i: Interval) -> String {
    let digits = (2 - i.value.log10().floor() as i32).clamp(0, 6) as usize;
    format!("{:.digits$} [{:.digits$}, {:.digits$}]", i.value, i.low, i.high)
}

fn slope(s: Slope) -> String {
    format!("{:.2} [{:.2}, {:.2}]", s.value, s.low, s.high)
}
