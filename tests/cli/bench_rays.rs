//! `bench rays`: counts, comparisons, files, and errors of its arguments.

use crate::run::Place;
use serde_json::Value;

/// As few rays as show something.
const SMALL: &str = "--size 16x16 --threads 1,2";

fn scene(name: &str) -> String {
    format!("{}/scenes/{name}/scene.gltf", env!("CARGO_MANIFEST_DIR"))
}

fn cornell() -> String {
    format!("bench rays {} {SMALL}", scene("cornell-box"))
}

fn list<'a>(value: &'a Value, name: &str) -> &'a Vec<Value> {
    value[name].as_array().unwrap()
}

fn backends(rows: &[Value]) -> Vec<&str> {
    let mut names: Vec<&str> = rows.iter().map(|row| row["backend"].as_str().unwrap()).collect();
    names.dedup();
    names
}

/// The rows of rays one by one.
fn single(rows: &[Value]) -> Vec<Value> {
    rows.iter().filter(|row| row["batch"].is_null()).cloned().collect()
}

fn is_rate(rate: &Value) -> bool {
    let [least, median, most] = ["least", "median", "most"].map(|name| rate[name].as_f64().unwrap());
    least > 0.0 && least <= median && median <= most
}

#[test]
fn rows_are_backends_and_builds_and_classes_are_the_rays_of_the_pass() {
    let place = Place::new();
    let report = place.report(&format!("{} --rounds 2 --backends obvhs --builds robust,fast -o out", cornell()));
    let box_scene = &report["scenes"][0];
    let counted: u64 =
        ["camera", "bounce", "shadow"].iter().map(|kind| box_scene["counted"][*kind].as_u64().unwrap()).sum();
    let classes: u64 = list(box_scene, "classes").iter().map(|class| class["rays"].as_u64().unwrap()).sum();
    assert!(counted > 1000 && counted == classes && box_scene["rays"] == counted, "{box_scene}");
    assert_eq!(box_scene["classes"][0]["rays"], 256, "a camera ray for each pixel");
    let rows = list(box_scene, "rows");
    assert_eq!(backends(&single(rows)), ["obvhs-robust", "obvhs-fast", "obvhs-cwbvh"]);
    assert_eq!(backends(rows)[..3], ["obvhs-robust", "obvhs-robust-batch", "obvhs-robust-batch-coherent"]);
    assert!(rows.len() == 7 && box_scene["execution"] == "batched", "{box_scene}");
    for row in rows {
        let renders = row["backend"] != "obvhs-cwbvh" && row["batch"].is_null();
        assert!(row["build_seconds"].as_f64().unwrap() > 0.0 && row["bytes_per_triangle"].as_f64().unwrap() > 10.0);
        for (pace, threads) in list(row, "paces").iter().zip([1, 2]) {
            assert!(pace["threads"] == threads && is_rate(&pace["raw"]), "{pace}");
            assert!(list(pace, "classes").iter().all(|class| is_rate(&class["rate"])));
            assert_eq!(pace["render"].is_object(), renders);
            assert!(!renders || (is_rate(&pace["render"]) && is_rate(&pace["share"])));
        }
    }
    let categories = list(&report, "categories");
    let groups = list(box_scene, "classes").len();
    assert_eq!(categories.len(), rows.len() * groups);
    for category in categories.iter().filter(|category| category["backend"] != "obvhs-cwbvh") {
        assert!(category["true_differences"] == 0 && category["leaks"] == 0 && category["ties"].is_u64(), "{category}");
        assert_eq!(category["scene"], "cornell-box");
    }
    let lines = |name: &str| std::fs::read_to_string(place.path(name)).unwrap().lines().count();
    // raw and the classes of every row, render and share of two, for two numbers of threads
    assert_eq!(lines("out/rates.csv"), 1 + 2 * (rows.len() * (1 + groups) + 2 * 2));
    assert_eq!(lines("out/categories.csv"), 1 + categories.len());
    assert!(place.path("out/index.html").is_file() && place.path("out/report.json").is_file());
}

#[test]
fn the_console_has_rates_and_hits_of_every_row() {
    let ran = Place::new().run(&format!("{} --rounds 1 --backends obvhs --hard-cases --rays-per-case 50", cornell()));
    assert_eq!(ran.code(), 0, "{}", ran.stderr());
    let text = ran.stdout();
    for what in [
        "batched execution",
        "obvhs-robust-batch-coherent",
        "median of 1 rounds",
        "2 threads",
        "share",
        "by class: camera",
        "obvhs-cwbvh",
        "0 true differences",
        "rows have true",
    ] {
        assert!(text.contains(what), "{what}: {text}");
    }
}

#[cfg(feature = "embree")]
#[test]
fn backends_are_compared_with_embree() {
    let report = Place::new().report(&format!("{} --rounds 1", cornell()));
    let rows = single(list(&report["scenes"][0], "rows"));
    assert_eq!(backends(&rows), ["embree-robust", "obvhs-robust", "obvhs-cwbvh"]);
    assert!(list(&report, "categories").iter().all(|category| category["reference"] == "embree-robust"));
}

/// Every width of packets has a row with and without the hint, and hits what single rays do, up to ties and grazes.
#[test]
fn packets_hit_as_single_rays_do() {
    let report = Place::new().report(&format!("{} --rounds 1", cornell()));
    let (rows, categories) = (list(&report["scenes"][0], "rows"), list(&report, "categories"));
    let batches: Vec<&Value> = rows.iter().filter(|row| row["batch"].is_object()).collect();
    assert!(batches.len() >= 2 && batches.len() % 2 == 0, "{rows:?}");
    for pair in batches.chunks(2) {
        assert_eq!(pair[0]["batch"]["packet"], pair[1]["batch"]["packet"]);
        assert_eq!([&pair[0]["batch"]["coherent"], &pair[1]["batch"]["coherent"]], [false, true]);
    }
    for row in batches {
        let name = row["backend"].as_str().unwrap();
        let alone = rows.iter().filter_map(|row| row["backend"].as_str()).find(|&row| name.starts_with(row)).unwrap();
        let of = |backend: &str| -> Vec<&Value> {
            categories.iter().filter(|category| category["backend"] == backend).collect()
        };
        let count = |category: &Value, what: &str| category[what].as_u64().unwrap();
        for (together, single) in of(name).into_iter().zip(of(alone)) {
            assert_eq!([&together["name"], &together["rays"]], [&single["name"], &single["rays"]]);
            let grazes = count(together, "grazes") + count(single, "grazes");
            let apart = count(together, "hits").abs_diff(count(single, "hits"));
            assert!(together["true_differences"] == 0 && apart <= grazes, "{together} {single}");
        }
        assert!(!of(name).is_empty() && list(&row["paces"][0], "classes").iter().all(|class| is_rate(&class["rate"])));
    }
}

/// A stream holds its rays and the same comparison comes of it; renders of other sizes record other streams.
#[test]
fn saved_rays_are_taken_again() {
    let place = Place::new();
    let first = place.report(&format!("{} --rounds 0 --save a.rays", cornell()));
    let again = place.report(&format!("{} --rounds 0 --load a.rays", cornell()));
    assert_eq!(first["categories"], again["categories"]);
    assert_eq!(first["scenes"][0]["classes"], again["scenes"][0]["classes"]);
    assert!(again["scenes"][0]["counted"].is_null());
    let rays = first["scenes"][0]["rays"].as_u64().unwrap();
    let size = std::fs::metadata(place.path("a.rays")).unwrap().len();
    assert_eq!(size, 72 + "cornell-box".len() as u64 + 36 * rays + 32, "docs/ray-streams.md");
}

#[test]
fn pictures_of_too_many_rays_are_made_smaller() {
    let large = format!("{} --size 512x512 --rays 20000 --rounds 0", cornell().replace(SMALL, "--threads 1"));
    let report = Place::new().report(&large);
    let (rays, size) = (report["scenes"][0]["rays"].as_u64().unwrap(), &report["scenes"][0]["size"]);
    assert!((15_000..25_000).contains(&rays) && size[0].as_u64().unwrap() < 100, "{rays} rays of {size}");
}

#[test]
fn files_that_are_no_streams_are_refused_in_one_sentence() {
    let place = Place::new();
    place.report(&format!("{} --rounds 0 --save a.rays", cornell()));
    let whole = std::fs::read(place.path("a.rays")).unwrap();
    let mut flipped = whole.clone();
    flipped[200] ^= 1;
    let mut boastful = whole.clone();
    boastful[48..56].fill(0xff);
    for (name, bytes) in
        [("flipped", &flipped[..]), ("cut", &whole[..whole.len() / 2]), ("empty", &[]), ("boastful", &boastful)]
    {
        std::fs::write(place.path(name), bytes).unwrap();
        place.run(&format!("{} --load {name}", cornell())).fails(3, &format!("cannot read ray stream {name}: it"));
    }
    for (line, code, what) in [
        (format!("{} --load none.rays", cornell()), 3, "none.rays"),
        (format!("{} --load .", cornell()), 3, "it is not a file"),
        (format!("bench rays {} {SMALL} --load a.rays", scene("sphere-lamp")), 2, "another scene"),
        (format!("{} --save flipped/b.rays", cornell()), 4, "flipped/b.rays"),
        (format!("{} -o flipped/out", cornell()), 4, "flipped/out"),
    ] {
        place.run(&line).fails(code, what);
    }
}

#[test]
fn hard_cases_need_no_scene_and_their_rays_can_be_asked_again() {
    let place = Place::new();
    let report = place.report("bench rays --hard-cases --rays-per-case 100 --backends obvhs");
    let categories = list(&report, "categories");
    assert!(categories.len() >= 26 && categories.iter().all(|category| category["scene"].is_null()));
    let ours = categories.iter().filter(|category| category["backend"] == "obvhs-robust");
    assert!(ours.clone().count() >= 26 && ours.clone().all(|category| category["leaks"] == 0));
    let replay = place.report("bench rays --replay sphere-edges:12 --backends obvhs");
    assert!(replay["address"] == "sphere-edges:12" && replay["bits"].as_array().unwrap().len() == 8);
    assert_eq!(backends(list(&replay, "answers")), ["obvhs-robust", "obvhs-cwbvh"]);
    assert!(
        replay["answers"][0]["closest"]["t"].as_f64().unwrap() > 0.0 && replay["answers"][0]["agreement"] == "same"
    );
}

/// An address means the same ray in the stream of a render and in its file, whatever rows are asked.
#[test]
fn rays_of_scenes_can_be_asked_again() {
    let place = Place::new();
    place.report(&format!("{} --rounds 0 --save a.rays", cornell()));
    let recorded = place.report(&format!("{} --replay cornell-box/shadow:7", cornell()));
    let loaded = place.report(&format!("{} --replay cornell-box/shadow:7 --load a.rays --backends obvhs", cornell()));
    assert_eq!(recorded["bits"], loaded["bits"]);
    let text = place.run(&format!("{} --replay cornell-box/shadow:7", cornell())).stdout();
    assert!(
        text.starts_with("cornell-box/shadow:7\n") && text.contains("direction") && text.contains("obvhs-robust"),
        "{text}"
    );
}

#[test]
fn invalid_arguments_are_refused() {
    let place = Place::new();
    for (line, what) in [
        (format!("{} --spp 4", cornell()), "--rounds"),
        (format!("{} --backend obvhs", cornell()), "--backends"),
        (format!("{} --build fast", cornell()), "--builds"),
        (format!("{} --save a.rays {}", cornell(), scene("sphere-lamp")), "one scene"),
        (format!("{} --replay cornell-box/shadow:99999999", cornell()), "there are"),
        (format!("{} --replay cornell-box/umbra:1", cornell()), "no such rays, but camera, bounce-1"),
        (format!("{} --replay other/shadow:1", cornell()), "'other'"),
        ("bench rays --replay cornell-box/shadow:1".into(), "'cornell-box'"),
        ("bench rays --replay no-case:1".into(), "no such hard case"),
        (format!("{} --size 8x8 --threads 0", cornell().replace(SMALL, "")), "--threads 0"),
    ] {
        place.run(&line).fails(2, what);
    }
    for (line, what) in [
        ("", "SCENES"),
        ("--replay shadow", "no address"),
        ("s.gltf --builds loose", "loose"),
        ("s.gltf --rays 0", "0"),
    ] {
        let ran = place.run(&format!("bench rays {line}"));
        assert!(ran.code() == 2 && ran.stderr().contains(what), "{}", ran.stderr());
    }
    place.run("bench rays none.gltf").fails(3, "none.gltf");
}
