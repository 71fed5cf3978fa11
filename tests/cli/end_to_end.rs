//! Whole renders of the Cornell box: what may and what must not change the pixels, and which files remain.

use crate::run::{Place, cornell};

#[test]
fn the_last_line_names_the_image() {
    let place = Place::new();
    let ran = place.run(&format!("render {} --spp 4 -o box.exr --png", cornell()));
    assert_eq!(ran.code(), 0, "{}", ran.stderr());
    assert_eq!(ran.stdout().lines().last(), Some("image: box.exr"));
    assert!(std::fs::metadata(place.path("box.exr")).unwrap().len() > 32 * 32 * 12);
    assert!(std::fs::metadata(place.path("box.png")).unwrap().len() > 0);
}

#[test]
fn the_picture_is_named_after_the_scenes_folder() {
    let place = Place::new();
    let ran = place.run(&format!("render {} --spp 4 --quiet", cornell()));
    assert_eq!(ran.stdout().lines().last(), Some("image: cornell-box.exr"), "{}", ran.stderr());
    assert_eq!(ran.stderr(), "");
}

#[test]
fn thread_counts_do_not_change_the_pixels() {
    let place = Place::new();
    let line = |threads| format!("render {} --spp 8 --threads {threads} -o x.exr", cornell());
    let [one, two, five] = [1, 2, 5].map(|threads| place.pixels(&line(threads)));
    assert_eq!(one, two);
    assert_eq!(one, five);
}

#[test]
fn seeds_do_change_the_pixels() {
    let place = Place::new();
    let line = |seed| format!("render {} --spp 4 --seed {seed} -o x.exr", cornell());
    assert_ne!(place.pixels(&line(1)), place.pixels(&line(2)));
}

#[test]
fn shards_merged_in_any_order_are_one_run() {
    let place = Place::new();
    let whole = place.pixels(&format!("render {} --spp 16 -o whole.exr", cornell()));
    for i in 0..3 {
        place.report(&format!("render {} --spp 16 --shard {i}/3 -o {i}.film", cornell()));
    }
    let merged = place.report("merge 2.film 0.film 1.film -o merged.exr");
    assert_eq!(merged["pixel_hash"], whole.as_str());
    assert_eq!(merged["render"]["passes"], "0-15");
    assert_eq!(place.pixels("merge 1.film 2.film 0.film -o merged.film"), whole);
    assert_eq!(place.pixels("resume merged.film -o again.exr"), whole);
}

#[test]
fn ranges_of_passes_are_parts_of_one_run() {
    let place = Place::new();
    let whole = place.pixels(&format!("render {} --spp 8 -o whole.exr", cornell()));
    place.report(&format!("render {} --passes 0..5 -o a.film", cornell()));
    place.run("merge a.film -o x.exr").fails(2, "passes 5-7 of 8 are missing");
    place.report(&format!("render {} --passes 5..8 -o b.film", cornell()));
    assert_eq!(place.pixels("merge b.film a.film -o x.exr"), whole);
}

#[test]
fn films_of_other_pictures_do_not_mix() {
    let place = Place::new();
    place.report(&format!("render {} --spp 8 --shard 0/2 -o a.film", cornell()));
    for (option, what) in [("--seed 5", "seeds"), ("--depth 2", "depth"), ("--filter tent", "filter")] {
        place.report(&format!("render {} --spp 8 --shard 1/2 -o b.film {option}", cornell()));
        place.run("merge a.film b.film -o x.exr").fails(2, what);
    }
    place.run("merge a.film a.film -o x.exr").fails(2, "both hold pass 0");
}

#[test]
fn more_samples_later_are_as_good_as_at_once() {
    let place = Place::new();
    let whole = place.pixels(&format!("render {} --spp 16 -o whole.exr", cornell()));
    place.report(&format!("render {} --spp 4 -o part.film", cornell()));
    let report = place.report("resume part.film --spp 16 -o part.exr");
    assert_eq!(report["pixel_hash"], whole.as_str());
    assert_eq!(report["render"]["sessions"], 2);
}

#[test]
fn spp_is_rounded_up_and_said() {
    let place = Place::new();
    let ran = place.run(&format!("render {} --spp 9 -o x.exr", cornell()));
    assert!(ran.stderr().contains("9 samples per pixel rounded up to 16"), "{}", ran.stderr());
    assert_eq!(place.report(&format!("render {} --spp 9 -o x.exr", cornell()))["render"]["spp"], 16);
}

#[test]
fn the_report_file_is_the_document_on_stdout() {
    let place = Place::new();
    let report = place.report(&format!("render {} --spp 4 -o x.exr --report x.json", cornell()));
    let file: serde_json::Value = serde_json::from_slice(&std::fs::read(place.path("x.json")).unwrap()).unwrap();
    assert_eq!(file, report);
    for key in ["wall_seconds", "cpu_seconds", "rays_per_second"] {
        assert!(report["render"][key].as_f64().unwrap() > 0.0, "{key}");
    }
    assert!(report["load"]["seconds"].is_f64() && report["build"]["seconds"].is_f64());
    let relmse = &report["error"]["relmse"];
    assert!(relmse["low"].as_f64().unwrap() <= relmse["value"].as_f64().unwrap());
    assert!(relmse["value"].as_f64().unwrap() <= relmse["high"].as_f64().unwrap());
    // The verdict is data, and its reasons have names and figures.
    let (trusted, reasons) =
        (report["error"]["trusted"].as_bool().unwrap(), report["error"]["reasons"].as_array().unwrap());
    assert_eq!(trusted, reasons.is_empty());
    assert!(reasons.iter().all(|r| r["reason"].is_string() && r["limit"].is_f64()));
    let image = etendue::io::exr::read(&place.path("x.exr")).unwrap();
    let attribute = |name: &str| image.attributes.get(name).cloned();
    assert_eq!(attribute("etendue.error.trusted"), Some(etendue::io::exr::Attribute::Int(i32::from(trusted))));
    assert_eq!(attribute("etendue.error.reasons").is_none(), trusted);
}

#[test]
fn clamping_is_called_biased() {
    let place = Place::new();
    let line = format!("render {} --spp 4 --clamp 0.5 -o x.exr", cornell());
    assert!(place.run(&line).stderr().contains("biased"));
    let clamp = &place.report(&line)["clamp"];
    assert_eq!(clamp["biased"], true);
    assert!(clamp["share_removed"].as_f64().unwrap() > 0.0);
}

#[test]
fn info_tells_what_is_there() {
    let info = Place::new().report(&format!("info {}", cornell()));
    assert!(info["triangles"].as_u64().unwrap() >= 12);
    assert!(info["memory"]["film_bytes"].as_u64().unwrap() > 0);
}

#[test]
fn a_failed_render_leaves_the_old_image_whole() {
    let place = Place::new();
    std::fs::write(place.path("x.exr"), "old").unwrap();
    place.run(&format!("render {} --camera nobody -o x.exr", cornell())).fails(2, "nobody");
    assert_eq!(std::fs::read(place.path("x.exr")).unwrap(), b"old");
}

/// Options that a method does not read are no part of a picture: films merge, and a finished picture is not rendered
/// again.
#[test]
fn options_that_the_method_does_not_read_change_nothing() {
    let place = Place::new();
    let render = |options: &str| place.report(&format!("render {} --spp 8 {options} -o x.exr", cornell()));
    for (method, unread, read) in [
        ("path", "--large-step .5 --heuristic power --lengths 5 --limit 0", "--depth 2"),
        ("light", "--heuristic power --without connect", "--depth 2"),
        ("bdpt", "--large-step .5 --mutations bidirectional=2", "--heuristic power"),
        ("mlt", "--large-step .5 --lengths 5", "--mutations bidirectional=2,lens=1 --limit 0"),
        ("pssmlt", "--lengths 5 --mutations bidirectional=2", "--large-step .5 --limit 0"),
    ] {
        let [plain, same, other] = ["", unread, read].map(|more| render(&format!("-m {method} {more}")));
        for hash in ["settings_hash", "identity", "pixel_hash"] {
            assert_eq!(plain[hash], same[hash], "{method}: {hash} with {unread}");
            assert_ne!(plain[hash], other[hash], "{method}: {hash} with {read}");
        }
    }
    place.report(&format!("render {} --spp 8 --passes 0..3 -o 0.film", cornell()));
    place.report(&format!("render {} --spp 8 --passes 3..8 --large-step .5 -o 1.film", cornell()));
    assert_eq!(place.run("merge 0.film 1.film -o x.exr").code(), 0);
}
