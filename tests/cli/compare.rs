//! `compare` on renders of the Cornell box and on files from elsewhere.

use crate::run::{Place, cornell};
use etendue::io::exr::{self, Attribute, Layer};
use std::path::Path;

/// Renders `name` with `options`.
fn render(place: &Place, name: &str, options: &str) {
    let ran = place.run(&format!("render {} --spp 16 --quiet -o {name} {options}", cornell()));
    assert_eq!(ran.code(), 0, "{}", ran.stderr());
}

/// The document of a comparison that ends with `code`.
fn compare(place: &Place, line: &str, code: i32) -> serde_json::Value {
    let ran = place.run(&format!("compare {line} --json"));
    assert_eq!(ran.code(), code, "{} {}", ran.stdout(), ran.stderr());
    serde_json::from_str(&ran.stdout()).unwrap()
}

/// Writes `path` again after a change of its layers; the header stays.
fn change(path: &Path, to: &Path, edit: impl FnOnce(&mut Vec<Layer>)) {
    let mut image = exr::read(path).unwrap();
    edit(&mut image.layers);
    let attributes: Vec<(String, Attribute)> = image.attributes.into_iter().collect();
    exr::write(to, image.width, image.height, Some(image.crop), &image.layers, &attributes).unwrap();
}

/// Other seeds, one mean: the seeds are fixed, and the level is a thousandth.
#[test]
fn another_seed_makes_no_difference_and_another_depth_does() {
    let place = Place::new();
    render(&place, "a.exr", "--seed 1");
    render(&place, "b.exr", "--seed 2 --aov albedo");
    let same = compare(&place, "a.exr b.exr --difference d.png --z z.exr --flip f.png", 0);
    assert_eq!(same["verdict"]["outcome"], "no-difference", "{same}");
    assert!(same["metrics"]["relmse"].as_f64().unwrap() > 0.0 && same["metrics"]["flip_hdr"].as_f64().unwrap() > 0.0);
    assert_eq!((&same["image"]["seed"], &same["reference"]["seed"]), (&1.into(), &2.into()));
    assert_eq!((&same["image"]["spp"], &same["image"]["hash_matches"]), (&16.into(), &true.into()));
    // Sixteen tiles of 8 pixels, four of 16 and the image, three channels each.
    assert_eq!((&same["verdict"]["tile"], &same["verdict"]["tests"]), (&8.into(), &63.into()));
    for name in ["d.png", "f.png"] {
        assert_eq!(image_size(&place.path(name)), [32, 32], "{name}");
    }
    let z = exr::read(&place.path("z.exr")).unwrap();
    // Of t statistics with few degrees of freedom most are small: the median of |t| is 0.77 at 3 to 6.
    let mut scores: Vec<f32> = z.channel("G").unwrap().iter().map(|z| z.abs()).collect();
    scores.sort_unstable_by(f32::total_cmp);
    assert!((0.5..1.0).contains(&scores[512]), "{}", scores[512]);

    render(&place, "c.exr", "--seed 3 --depth 2");
    let differ = compare(&place, "c.exr b.exr", 7);
    assert_eq!(differ["verdict"]["outcome"], "differ");
    assert!(differ["verdict"]["rejections"][0]["difference"].as_f64().unwrap() < 0.0, "cut paths are darker: {differ}");
    let ran = place.run("compare c.exr b.exr");
    ran.fails(7, "c.exr and b.exr differ: the means differ at level 0.001");
    assert!(ran.stdout().contains("differs    "), "{}", ran.stdout());
}

fn image_size(path: &Path) -> [u32; 2] {
    let bytes = std::fs::read(path).unwrap();
    [16, 20].map(|at| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()))
}

#[test]
fn identical_pixels_and_equal_seeds_are_called_so() {
    let place = Place::new();
    render(&place, "a.exr", "--seed 1");
    let same = compare(&place, "a.exr a.exr", 0);
    assert_eq!((&same["verdict"]["outcome"], &same["metrics"]["mse"]), (&"identical".into(), &0.0.into()));
    assert!(same["metrics"]["psnr"].is_null(), "infinite");
    render(&place, "b.exr", "--seed 1 --depth 2");
    let ran = place.run("compare a.exr b.exr");
    assert_eq!(ran.code(), 0, "{}", ran.stderr());
    assert!(ran.stdout().contains("verdict    not tested: both have seed 1"), "{}", ran.stdout());
}

#[test]
fn what_was_changed_after_rendering_is_noticed() {
    let place = Place::new();
    render(&place, "a.exr", "--seed 1");
    render(&place, "b.exr", "--seed 2");
    let (a, b) = (place.path("a.exr"), place.path("b.exr"));
    change(&a, &a, |layers| {
        let green = layers.iter_mut().find(|l| l.name == "G").unwrap();
        green.values[7] = f32::NAN;
        green.values[8] = f32::INFINITY;
    });
    let found = compare(&place, "a.exr b.exr --difference d.png", 0);
    assert_eq!((&found["image"]["hash_matches"], &found["reference"]["hash_matches"]), (&false.into(), &true.into()));
    assert_eq!((&found["metrics"]["non_finite"], &found["verdict"]["pixels_left_out"]), (&2.into(), &2.into()));
    for figure in ["mse", "mae", "relmse", "smape", "psnr", "flip_ldr", "flip_hdr"] {
        assert!(found["metrics"][figure].is_f64(), "{figure}: {found}");
    }
    change(&b, &b, |layers| {
        layers.iter_mut().filter(|l| l.name == "B").for_each(|l| l.values.iter_mut().for_each(|v| *v *= 1.2))
    });
    let ran = place.run("compare b.exr a.exr");
    ran.fails(7, "differ");
    assert!(ran.stdout().contains("NOT those in its header"), "{}", ran.stdout());
}

/// A file without errors and provenance, with alpha: figures only.
#[test]
fn images_of_other_programs_give_figures() {
    let place = Place::new();
    render(&place, "a.exr", "--seed 1 --transparent");
    let image = exr::read(&place.path("a.exr")).unwrap();
    let colors: Vec<Layer> = image.layers.into_iter().filter(|l| ["R", "G", "B", "A"].contains(&&*l.name)).collect();
    let brighter = colors.iter().cloned().map(|l| Layer { values: l.values.iter().map(|v| v * 2.0).collect(), ..l });
    exr::write(&place.path("f.exr"), 32, 32, None, &brighter.collect::<Vec<_>>(), &[]).unwrap();
    let found = compare(&place, "f.exr a.exr --epsilon 0", 0);
    assert_eq!(found["verdict"]["outcome"], "untested");
    // Twice as bright: |2R − R|² / R² = 1, |2R − R| / (2R + R) = 1/3 where R is not 0; rounding of f64 sums alone.
    let lit = found["metrics"]["relmse"].as_f64().unwrap();
    assert!((found["metrics"]["smape"].as_f64().unwrap() - lit / 3.0).abs() < 1e-12 && lit > 0.5, "{found}");
    assert!(found["image"]["hash_matches"].is_null());
    place.run("compare f.exr a.exr --z z.png").fails(2, "standard errors");
}

#[test]
fn images_of_other_scenes_or_sizes_are_not_compared() {
    let place = Place::new();
    render(&place, "a.exr", "");
    let half = ["R", "G", "B"].map(|name| Layer { name: name.into(), values: vec![1.0; 16 * 16] });
    exr::write(&place.path("small.exr"), 16, 16, None, &half, &[]).unwrap();
    render(&place, "crop.exr", "--crop 0,0,8,8");
    let depth = Layer { name: "Z".into(), values: vec![1.0; 32 * 32] };
    exr::write(&place.path("depth.exr"), 32, 32, None, &[depth], &[]).unwrap();
    std::fs::write(place.path("text.exr"), "no image").unwrap();
    for (line, code, what) in [
        ("a.exr small.exr", 2, "a.exr is 32x32, small.exr is 16x16"),
        ("crop.exr a.exr", 2, "crop.exr is 32x32 cropped to 0,0,8,8"),
        ("a.exr depth.exr", 2, "depth.exr has no channels R, G and B"),
        ("a.exr text.exr", 3, "text.exr"),
        ("a.exr none.exr", 3, "none.exr"),
        ("a.exr a.exr --difference d.jpg", 2, ".png or .exr"),
        ("a.exr a.exr --z none/z.png", 4, "cannot write"),
    ] {
        place.run(&format!("compare {line}")).fails(code, what);
    }
    for line in ["compare a.exr", "compare a.exr a.exr --level 1", "compare a.exr a.exr --epsilon -1"] {
        assert_eq!(place.run(line).code(), 2, "{line}");
    }
}

/// What pixels share is in the record that images carry, and no part of the pixels: where those were edited it says
/// nothing of them.
#[test]
fn methods_whose_pixels_share_samples_are_compared_by_their_record() {
    let place = Place::new();
    for method in ["light", "bdpt", "pssmlt", "mmlt", "mlt"] {
        render(&place, "a.exr", &format!("-m {method} --seed 1"));
        render(&place, "b.exr", &format!("-m {method} --seed 2"));
        let same = compare(&place, "a.exr b.exr", 0);
        assert_eq!(same["verdict"]["outcome"], "no-difference", "{method}: {same}");
    }
    render(&place, "c.exr", "-m mlt --seed 3 --depth 1");
    assert_eq!(compare(&place, "c.exr b.exr", 7)["verdict"]["outcome"], "differ");
    let b = place.path("b.exr");
    change(&b, &b, |layers| {
        layers.iter_mut().filter(|l| l.name == "B").for_each(|l| l.values.iter_mut().for_each(|v| *v *= 1.2))
    });
    let edited = compare(&place, "a.exr b.exr", 0);
    assert!(edited["verdict"]["reason"].as_str().unwrap().contains("b.exr were changed after rendering"), "{edited}");
}

/// The record of a crop is that of its pixels, and shards make the record of the whole.
#[test]
fn crops_and_shards_have_their_records() {
    let place = Place::new();
    let record = |name: &str| exr::read(&place.path(name)).unwrap().attributes["etendue.tiles"].clone();
    for method in ["path", "bdpt", "mmlt"] {
        let line = format!("-m {method} --crop 3,5,21,17 --seed 1");
        render(&place, "whole.exr", &line);
        render(&place, "0.film", &format!("{line} --passes 0..7"));
        render(&place, "1.film", &format!("{line} --passes 7..16"));
        assert_eq!(place.run("merge 1.film 0.film -o merged.exr").code(), 0);
        assert_eq!(record("merged.exr"), record("whole.exr"), "{method}");
        render(&place, "other.exr", &format!("-m {method} --crop 3,5,21,17 --seed 2"));
        assert_eq!(compare(&place, "merged.exr other.exr", 0)["verdict"]["outcome"], "no-difference", "{method}");
    }
}

#[test]
fn too_few_replicates_are_reported() {
    let place = Place::new();
    render(&place, "a.exr", "--seed 1 --replicates 1");
    render(&place, "b.exr", "--seed 2 --replicates 2");
    render(&place, "c.exr", "--seed 3");
    for (line, what) in [("a.exr c.exr", "a.exr has no standard errors"), ("b.exr c.exr", "b.exr has 2 replicates")] {
        let found = compare(&place, line, 0);
        assert_eq!(found["verdict"]["outcome"], "untested");
        assert!(found["verdict"]["reason"].as_str().unwrap().contains(what), "{found}");
    }
}
