//! `bench methods`: its output, and errors of its arguments.

use crate::run::{Place, cornell};

/// The least that is a curve: five points, two renders.
const SMALL: &str = "--size 16x16 --budget 1ms --reference-budget 300ms --repetitions 2 --threads 2";

fn scene(name: &str) -> String {
    format!("{}/scenes/{name}/scene.gltf", env!("CARGO_MANIFEST_DIR"))
}

/// How many methods there are.
const METHODS: usize = 8;

#[test]
fn curves_have_five_points_and_ratios_leave_the_blind_out() {
    let place = Place::new();
    let scenes = format!("{} {}", scene("cornell-box"), scene("sphere-lamp"));
    let report = place.report(&format!("bench methods {scenes} {SMALL} --backends obvhs -o out"));
    for (at, blind) in [(0, 0), (1, 1)] {
        let scene = &report["scenes"][at];
        let curves = scene["curves"].as_array().unwrap();
        assert_eq!(curves.len(), METHODS);
        for curve in curves {
            assert_eq!(curve["runs"].as_array().unwrap().len(), 2);
            let points = curve["points"].as_array().unwrap();
            assert!(points.len() >= 5, "{curve}");
            let spp: Vec<u64> = points.iter().map(|p| p["spp"].as_u64().unwrap()).collect();
            assert!(spp[0] == 4 && spp.windows(2).all(|w| w[1] == 2 * w[0]), "{spp:?}");
            let seconds: Vec<f64> = points.iter().map(|p| p["cpu_seconds"].as_f64().unwrap()).collect();
            assert!(seconds[0] > 0.0 && seconds.windows(2).all(|w| w[1] > w[0]), "{seconds:?}");
        }
        let is_blind = |c: &&serde_json::Value| !c["blind_spots"].as_array().unwrap().is_empty();
        assert_eq!(curves.iter().filter(is_blind).count(), blind);
        let seeing = METHODS - blind;
        assert_eq!(scene["ratios"].as_array().unwrap().len(), seeing * (seeing - 1));
    }
    let rows = std::fs::read_to_string(place.path("out/points.csv")).unwrap();
    assert!(
        rows.starts_with("scene,curve,is_blind,repetition,spp,cpu_seconds,")
            && rows.lines().count() > 2 * METHODS * 2 * 5
    );
    assert!(place.path("out/index.html").is_file() && place.path("out/report.json").is_file());
    assert!(place.path("out/reference-cornell-box.exr").is_file());
}

/// At a fixed number of passes, relMSE is that of the film: with a render of the same picture as reference and its
/// noise known, what is measured agrees with the standard error that images carry. 64×64 pixels of 3 lanes in 2
/// renders; the noise of an average over 4096 pixels is some per cent, and a factor of 1.5 would show a reference that
/// is not subtracted (2) or an error of the mean instead of its square (√).
#[test]
fn errors_agree_with_those_that_images_carry() {
    let place = Place::new();
    let big = format!("{} --size 64x64", scene("cornell-box"));
    place.report(&format!("render {big} --spp 64 --seed 99 -o reference.exr"));
    let film = place.report(&format!("render {big} --spp 64 --seed 5 -o image.exr"));
    let line = format!(
        "bench methods {big} --methods path --backends obvhs --budget 1ms --repetitions 2 --reference reference.exr"
    );
    let report = place.report(&format!("{line} -o out"));
    let scene = &report["scenes"][0];
    let point = scene["curves"][0]["points"].as_array().unwrap().iter().find(|p| p["spp"] == 64).unwrap();
    let (measured, carried) =
        (point["relmse"]["value"].as_f64().unwrap(), film["error"]["relmse"]["value"].as_f64().unwrap());
    assert!((measured / carried - 1.0).abs() < 0.5, "{measured} {carried}");
    // The reference has as many samples as the image.
    let share = scene["reference_share"].as_f64().unwrap();
    assert!((share - 1.0).abs() < 0.5, "{share}");
}

/// Light that is sampled alone: the error of independent samples falls as 1/N.
#[test]
fn the_slope_of_independent_samples_is_minus_one() {
    let place = Place::new();
    let line = format!(
        "bench methods {} --size 32x32 --sampler independent --methods path-nee --backends obvhs",
        scene("cornell-box")
    );
    let report = place.report(&format!("{line} --budget 200ms --reference-budget 300s --repetitions 4 -o out"));
    let slope = &report["scenes"][0]["curves"][0]["slope_in_samples"];
    let end = |name: &str| slope[name].as_f64().unwrap();
    // The interval holds −1 in 95 of 100 runs; at three times its width in all but one of 1,000 (t, 3 degrees of
    // freedom).
    let (middle, half) = (end("value"), 3.0 * (end("high") - end("value")));
    assert!((middle + 1.0).abs() < half && half < 0.6, "{slope}");
}

#[test]
fn a_made_reference_is_taken_again() {
    let place = Place::new();
    let line = format!(
        "bench methods {} --methods path-nee --backends obvhs --size 16x16 --budget 1ms --repetitions 2",
        scene("cornell-box")
    );
    let first = place.run(&format!("{line} --reference-budget 300s -o out"));
    assert_eq!(first.code(), 0, "{}", first.stderr());
    assert!(first.stderr().contains("a reference is made by "), "{}", first.stderr());
    assert!(!first.stderr().contains("also compared"), "another method makes it: {}", first.stderr());
    let again = place.run(&format!("{line} --reference-budget 300s -o out"));
    assert!(again.stderr().contains("taking out/reference-cornell-box.exr"), "{}", again.stderr());
    let other = place.run(&format!("{line} --reference-budget 300s --depth 3 -o out"));
    assert!(other.stderr().contains("a reference is made by"), "other settings: {}", other.stderr());
}

#[test]
fn invalid_arguments_are_refused_before_rendering() {
    let place = Place::new();
    place.report(&format!("render {} --spp 4 -o small.exr", cornell()));
    std::fs::write(place.path("file"), "").unwrap();
    let scene = scene("cornell-box");
    for (line, code, what) in [
        (format!("{scene} --reference small.exr -o out"), 2, "32×32"),
        (format!("{scene} --reference a.exr,b.exr -o out"), 2, "--reference"),
        (format!("{scene} --reference none.exr -o out"), 3, "none.exr"),
        (format!("{scene} --spp 4 -o out"), 2, "--budget"),
        (format!("{scene} --method path -o out"), 2, "--methods"),
        (format!("{scene} --size 8x8 -o file/out"), 4, "file/out"),
        ("none.gltf -o out".into(), 3, "none.gltf"),
    ] {
        place.run(&format!("bench methods {line}")).fails(code, what);
    }
    for (line, what) in [("-o out", "SCENES"), ("s.gltf", "--output"), ("s.gltf --methods magic -o out", "magic")] {
        let ran = place.run(&format!("bench methods {line}"));
        assert!(ran.code() == 2 && ran.stderr().contains(what), "{}", ran.stderr());
    }
}
