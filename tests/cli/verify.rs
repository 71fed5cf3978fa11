//! All methods and backends on one scene.

use crate::run::{Place, Ran, cornell, is_mutable};
use std::io::{BufRead, BufReader, Read};
use std::time::{Duration, Instant};

/// A scene whose mirror and lamp `path-naive` does not see.
const MIRROR: &str = r#"{
  "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
  "extensionsUsed": ["KHR_lights_punctual"],
  "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 10.0}]}},
  "nodes": [
    {"camera": 0, "translation": [0, 0, 3]}, {"mesh": 0},
    {"translation": [0, 0, 2], "extensions": {"KHR_lights_punctual": {"light": 0}}}
  ],
  "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1, "aspectRatio": 1.0}}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]}],
  "bufferViews": [{"buffer": 0, "byteLength": 36}],
  "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA"}]
}"#;

fn box_line(options: &str) -> String {
    format!("verify {} {options}", cornell())
}

#[test]
fn right_candidates_agree_and_the_report_says_what_that_is_worth() {
    let place = Place::new();
    let report = place.report(&box_line("--spp 64 --methods path,path-nee"));
    let candidates = report["candidates"].as_array().unwrap();
    assert_eq!(candidates.len(), if cfg!(feature = "embree") { 4 } else { 2 });
    assert_eq!((report["agree"].as_bool(), report["replicates"].as_u64()), (Some(true), Some(32)));
    for candidate in candidates {
        assert_eq!(candidate["spp"], 64);
    }
    let seeds: std::collections::HashSet<u64> = candidates.iter().map(|c| c["seed"].as_u64().unwrap()).collect();
    assert_eq!(seeds.len(), candidates.len());
    for pair in report["pairs"].as_array().unwrap() {
        let detectable = pair["detectable"].as_f64().unwrap();
        assert!((1e-3..0.5).contains(&detectable), "{pair}");
    }
}

/// The same samples as `render` makes with the seed that the report names.
#[test]
fn a_candidate_can_be_rendered_again() {
    let place = Place::new();
    let report = place.report(&box_line("--spp 32 --backends obvhs -o pictures"));
    let candidate = &report["candidates"][1];
    let (method, seed) = (candidate["method"].as_str().unwrap(), &candidate["seed"]);
    let line = format!(
        "render {} --method {method} --backend obvhs --seed {seed} --spp 32 --replicates 32 -o x.exr",
        cornell()
    );
    let again = place.report(&line);
    let mean: f64 = candidate["mean"].as_array().unwrap().iter().map(|m| m.as_f64().unwrap()).sum::<f64>() / 3.0;
    // Two orders of summation of some thousand values of about the same size.
    assert!((again["error"]["mean"].as_f64().unwrap() / mean - 1.0).abs() < 1e-9, "{again}");
    let names: Vec<String> = std::fs::read_dir(place.path("pictures"))
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    // two files for each of eight methods, and for the pair that differs most
    assert_eq!(names.len(), 2 * 8 + 2, "{names:?}");
    assert!(names.iter().any(|n| n.starts_with("z-") && n.ends_with(".png")), "{names:?}");
}

#[test]
fn a_method_that_is_blind_is_left_out_and_the_table_says_why() {
    let place = Place::new();
    std::fs::write(place.path("s.gltf"), MIRROR).unwrap();
    let ran = place.run("verify s.gltf --spp 32 --size 16");
    assert_eq!(ran.code(), 0, "{}", ran.stderr());
    assert!(ran.stdout().contains("left out: path-naive does not see point"), "{}", ran.stdout());
    assert!(!ran.stdout().contains("path-naive/"), "{}", ran.stdout());
    assert!(ran.stdout().lines().last().unwrap().starts_with("no difference"), "{}", ran.stdout());
    place.run("verify s.gltf --methods path,path-naive --backends obvhs").fails(2, "nothing to compare");
}

#[test]
fn a_budget_is_kept() {
    let place = Place::new();
    let (start, budget) = (Instant::now(), 4.0);
    let report = place.report(&box_line("--budget 4s --backends obvhs"));
    let mut seconds: Vec<f64> =
        report["candidates"].as_array().unwrap().iter().map(|c| c["seconds"].as_f64().unwrap()).collect();
    let total: f64 = seconds.iter().sum();
    // Blocks of 32 passes of 32×32 pixels take a few hundredths of a second; a busy machine some tenths.
    assert!((0.7 * budget..1.5 * budget).contains(&total), "{seconds:?} of {:?}", start.elapsed());
    // A machine that stands still for a moment does so in the last block of one candidate: that one may be far over.
    seconds.sort_by(f64::total_cmp);
    let shares: Vec<f64> = seconds.iter().map(|s| s / budget * seconds.len() as f64).collect();
    let (stalled, others) = shares.split_last().unwrap();
    assert!(others.iter().all(|share| (0.5..1.6).contains(share)) && *stalled < 3.0, "{shares:?}");
}

#[test]
fn invalid_arguments_are_refused() {
    let place = Place::new();
    for (options, what) in [
        ("--methods guess", "guess"),
        ("--level 0", "level"),
        ("--budget 5s --spp 4", "--spp"),
        ("--method path", "--methods"),
        ("--time 4s", "--budget"),
        ("--clamp 1", "--clamp"),
        ("--methods path --backends obvhs", "nothing to compare"),
    ] {
        let ran = place.run(&box_line(options));
        assert_eq!(ran.code(), 2, "{options}: {}", ran.stderr());
        assert!(ran.stderr().contains(what), "{options}: {}", ran.stderr());
    }
    place.run("verify none.gltf").fails(3, "none.gltf");
    place.run("verify none.gltf -o none/pictures").fails(4, "cannot write");
}

#[test]
fn a_stopped_verification_says_that_nothing_was_verified() {
    let place = Place::new();
    let mut child = place.start(&box_line("--budget 1h"));
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut said = String::new();
    while !said.contains("etendue: rendering") {
        assert!(stderr.read_line(&mut said).unwrap() > 0, "{said}");
    }
    std::thread::sleep(Duration::from_millis(300));
    crate::signals::signal(&child, "INT");
    stderr.read_to_string(&mut said).unwrap();
    let mut output = child.wait_with_output().unwrap();
    output.stderr = said.into_bytes();
    Ran(output).fails(75, "nothing was verified");
}

/// Wrong in one method or differently in each: seen. (What is wrong alike in all of them is not:
/// `roughness-not-squared`.) Runs in the copy that tests/kill_matrix makes, since the ordinary binary has no mutations.
#[test]
fn wrong_methods_are_convicted() {
    if !is_mutable() {
        return;
    }
    let place = Place::new();
    // What is wrong is in the code of single paths.
    let line = |methods: &str, spp: u32| box_line(&format!("--methods {methods} --spp {spp} --execution scalar"));
    // The smallest difference, .8 %, is above what the tail may hide only with more samples.
    for (name, methods, spp) in
        [("mixed-heuristics", "path-nee,path", 4096), ("cosine-dropped", "path-naive,path", 1024)]
    {
        let ran = place.run_mutant(name, &line(methods, spp));
        ran.fails(7, "DIFFERENT");
        assert!(
            ran.stdout().contains("the image's") || ran.stdout().contains("most at pixels"),
            "{name}: {}",
            ran.stdout()
        );
    }
    assert_eq!(place.run_mutant("roughness-not-squared", &line("path-nee,path", 1024)).code(), 0);
}
