//! When a render is done: a number of samples, a time, an error, whichever comes first.

use crate::run::{Place, cornell};

fn reached(report: &serde_json::Value) -> bool {
    report["target"]["reached"].as_bool().unwrap()
}

#[test]
fn a_render_stops_when_it_is_good_enough() {
    let place = Place::new();
    let report = place.report(&format!("render {} --target-error 0.05 -o x.exr", cornell()));
    let (spp, look) = (report["render"]["spp"].as_u64().unwrap(), &report["target"]["last_look"]);
    assert!(reached(&report) && spp >= 16 && (spp / 4).is_power_of_two(), "{spp}");
    assert!(look["upper_limit"].as_f64().unwrap() <= 0.05 && look["passes"].as_u64() == Some(spp));
    // It would not have stopped had it looked at half as many samples, nor does a target above what it has reached go
    // on.
    let earlier = place.report(&format!("render {} --target-error 0.05 --spp {} -o x.exr", cornell(), spp / 2));
    assert!(spp == 16 || !reached(&earlier));
    let same = place.pixels(&format!("render {} --spp {spp} -o x.exr", cornell()));
    assert_eq!(report["pixel_hash"], same.as_str());
}

#[test]
fn a_target_that_is_missed_is_an_error_where_it_is_required() {
    let place = Place::new();
    let line = format!("render {} --target-error 1e-9 --spp 16 -o x.exr", cornell());
    let easy = place.run(&line);
    assert_eq!(easy.code(), 0);
    assert!(easy.stderr().contains("target error 1e-9 was not reached"), "{}", easy.stderr());
    place.run(&format!("{line} --require-target")).fails(5, "only known to be below");
    assert!(place.path("x.exr").exists(), "the picture is written all the same");
    place.run(&format!("render {} --spp 4 --require-target", cornell())).fails(2, "--target-error");
    place.run(&format!("render {} --target-error 1e-9 --spp 4 --require-target", cornell())).fails(5, "too few");
}

#[test]
fn targets_need_a_whole_picture_with_replicates() {
    let place = Place::new();
    let line = |more: &str| format!("render {} --target-error 0.1 {more}", cornell());
    place.run(&line("--shard 0/2")).fails(2, "whole picture");
    place.run(&line("--replicates 1")).fails(2, "replicates");
    place.run(&format!("render {} --target-error -1", cornell())).fails(2, "above zero");
}

#[test]
fn the_first_of_several_ends_the_render() {
    let place = Place::new();
    let spp =
        |more: &str| place.report(&format!("render {} {more} -o x.exr", cornell()))["render"]["spp"].as_u64().unwrap();
    assert_eq!(spp("--spp 8 --time 1h"), 8);
    assert_eq!(spp("--spp 8 --time 1h --target-error 1e-9"), 8);
    assert!(spp("--spp 1000000 --time 1s") < 1_000_000);
}

/// Within 5 % of the budget or one pass. The passes here are a thousandth of it; a busy machine may hold one of them
/// up, but not the last one of each of four renders.
#[test]
fn a_time_budget_is_used_up_and_not_overrun() {
    let off_by = || {
        let report = Place::new().report(&format!("render {} --time 1s -o x.exr", cornell()));
        (report["render"]["wall_seconds"].as_f64().unwrap() - 1.0).abs()
    };
    let tries: Vec<f64> = (0..4).map(|_| off_by()).collect();
    assert!(tries.iter().any(|&off| off <= 0.05), "{tries:?}");
}

#[test]
fn a_film_goes_on_until_it_is_good_enough() {
    let place = Place::new();
    place.report(&format!("render {} --spp 4 -o x.film", cornell()));
    let resumed = place.report("resume x.film --target-error 0.05 -o y.exr");
    let whole = place.report(&format!("render {} --target-error 0.05 -o z.exr", cornell()));
    assert!(reached(&resumed) && reached(&whole));
    assert_eq!(resumed["pixel_hash"], whole["pixel_hash"]);
}

#[test]
fn a_report_says_how_wrong_the_picture_may_be() {
    let report = Place::new().report(&format!("render {} --spp 64 -o x.exr", cornell()));
    let error = &report["error"];
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    assert!(number(&error["relmse"]["low"]) < number(&error["relmse"]["value"]));
    assert!(number(&error["relmse"]["value"]) < number(&error["relmse"]["high"]));
    let largest = &error["largest"];
    assert!((0.0..1.0).contains(&number(&largest["share"])) && number(&largest["value"]) > 0.0);
    // The sample can be rendered again: alone, its pixel is as bright as it.
    let [x, y, pass] = ["x", "y", "pass"].map(|key| largest[key].as_u64().unwrap());
    let (crop, passes) = (format!("{x},{y},{},{}", x + 1, y + 1), format!("{pass}..{}", pass + 1));
    let place = Place::new();
    place.report(&format!("render {} --spp 64 --crop {crop} --passes {passes} -o one.exr", cornell()));
    let image = etendue::io::exr::read(&place.path("one.exr")).unwrap();
    let mean = ["R", "G", "B"].iter().map(|c| f64::from(image.channel(c).unwrap()[0])).sum::<f64>() / 3.0;
    // The film's unit is 2⁻²⁴ of the mean, f32 has 2⁻²⁴ of the value: well below 1e-6 of it.
    assert!((mean / number(&largest["value"]) - 1.0).abs() < 1e-6, "{mean} {largest}");
    assert!(error["tail"]["shape"].is_f64());
}
