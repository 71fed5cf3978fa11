//! `render --techniques`: images of what each technique finds on its own.

use crate::run::{Place, cornell};
use etendue::io::exr;

/// Layers by name, values in file order.
fn layer<'a>(image: &'a exr::ExrImage, name: &str) -> &'a [f32] {
    &image.layers.iter().find(|l| l.name == name).unwrap_or_else(|| panic!("no layer {name}")).values
}

#[test]
fn every_technique_has_its_layers_and_its_place_on_the_sheet() {
    let place = Place::new();
    // Connections, on which the picture plays roulette and the parts do not, would be equal in the mean only.
    let line = "-m bdpt --without connect --depth 2 --spp 8 -o box.exr --techniques parts.exr --techniques-depth 2";
    let ran = place.run(&format!("render {} {line}", cornell()));
    assert_eq!(ran.code(), 0, "{}", ran.stderr());
    let lines = ran.stdout();
    assert_eq!(lines.lines().last(), Some("image: box.exr"));
    assert!(lines.contains("techniques: parts.exr, parts.png"), "{lines}");
    let [whole, parts] = ["box.exr", "parts.exr"].map(|name| exr::read(&place.path(name)).unwrap());
    let techniques = [(0, 2), (0, 3), (1, 2), (2, 1), (0, 4), (1, 3), (3, 1)];
    assert_eq!(parts.layers.len(), 2 * 3 * techniques.len());
    for lane in ["R", "G", "B"] {
        let all = techniques.map(|(s, t)| layer(&parts, &format!("s{s}t{t}.weighted.{lane}")));
        for (i, &want) in layer(&whole, lane).iter().enumerate() {
            let found: f32 = all.iter().map(|values| values[i]).sum();
            // 7 images of 2⁻²⁴ of the mean radiance for each of dozens of roundings: see agreement/techniques
            assert!((found - want).abs() < 1e-4 * (want + 1.0), "{lane} {i}: {found}, not {want}");
        }
        assert!(layer(&parts, &format!("s3t1.unweighted.{lane}")).iter().any(|&v| v > 0.0));
    }
    let sheet = image::open(place.path("parts.png")).unwrap().into_rgb8();
    // two halves of four columns, three rows of the picture's 32 pixels and a caption
    assert!(sheet.width() > 2 * 4 * 32 && sheet.height() > 3 * (32 + 16), "{}x{}", sheet.width(), sheet.height());
}

#[test]
fn techniques_left_out_have_no_layers() {
    let place = Place::new();
    let line = "-m bdpt --without splat,connect --spp 4 -o box.exr --techniques parts.exr --techniques-depth 1 --quiet";
    assert_eq!(place.run(&format!("render {} {line}", cornell())).code(), 0);
    let parts = exr::read(&place.path("parts.exr")).unwrap();
    let mut names: Vec<&str> = parts.layers.iter().filter_map(|l| l.name.strip_suffix(".weighted.G")).collect();
    names.sort_unstable();
    assert_eq!(names, ["s0t2", "s0t3", "s1t2"]);
}

#[test]
fn techniques_option_is_checked_before_the_scene_is_read() {
    let place = Place::new();
    for (line, what) in [
        ("--techniques t.exr", "bdpt"),
        ("-m light --techniques t.exr", "bdpt"),
        ("-m bdpt --techniques t.png", ".exr"),
        ("-m bdpt --techniques x.exr -o x.exr", "x.exr"),
        ("-m bdpt --techniques x.exr -o x.png", "x.png"),
        ("-m bdpt --techniques t.exr --shard 0/2", "--shard"),
        ("-m bdpt --techniques t.exr --passes 0..4", "--passes"),
        ("-m bdpt --techniques-depth 2", "--techniques"),
        ("-m bdpt --techniques t.exr --techniques-depth 17", "17"),
    ] {
        let ran = place.run(&format!("render none.gltf {line}"));
        assert_eq!(ran.code(), 2, "{line}: {}", ran.stderr());
        assert!(ran.stderr().contains(what), "{line}: {}", ran.stderr());
    }
    place.run("render none.gltf -m bdpt --techniques none/t.exr").fails(4, "cannot write");
    assert_eq!(std::fs::read_dir(place.path(".")).unwrap().count(), 0, "nothing was left behind");
}
