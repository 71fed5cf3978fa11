//! Errors of command lines, configuration files and output paths.

use crate::run::Place;

/// An empty glTF scene, enough where the scene is never reached.
const EMPTY: &str = r#"{"asset":{"version":"2.0"}}"#;

#[test]
fn wrong_command_lines_are_told_apart_from_other_failures() {
    let place = Place::new();
    for (line, what) in [
        ("", "Usage"),
        ("paint", "paint"),
        ("render", "SCENE"),
        ("render s.gltf --spp 0", "spp must be from 1"),
        ("render s.gltf --size big", "'big' is not a size"),
        ("render s.gltf --crop 0,0,9999,1", "outside"),
        ("render s.gltf --crop 5,5,5,9", "rectangle"),
        ("render s.gltf --target-error low", "--target-error"),
        ("render s.gltf --time soon", "'soon' is not a time"),
        ("render s.gltf --shard 4/4", "shard"),
        ("render s.gltf --shard 1..4", "shard"),
        ("render s.gltf --passes 4..4", "range"),
        ("render s.gltf --shard 0/2 --passes 1..2", "--passes"),
        ("render s.gltf --threads 0", "--threads"),
        ("render s.gltf --clamp -1", "clamp"),
        ("render s.gltf --aov beauty", "beauty"),
        ("render s.gltf -o x.jpg", ".exr, .png or .film"),
        ("merge", "FILMS"),
    ] {
        let ran = place.run(line);
        assert_eq!(ran.code(), 2, "{line}: {}", ran.stderr());
        assert!(ran.stderr().contains(what), "{line}: {}", ran.stderr());
        assert_eq!(ran.stdout(), "", "{line}");
    }
    assert_eq!(std::fs::read_dir(place.path(".")).unwrap().count(), 0, "nothing was left behind");
}

#[test]
fn help_and_version_are_answers() {
    let place = Place::new();
    for (line, what) in [("--help", "Examples:"), ("render --help", "--spp"), ("--version", env!("CARGO_PKG_VERSION"))]
    {
        let ran = place.run(line);
        assert_eq!((ran.code(), ran.stderr()), (0, String::new()), "{line}");
        assert!(ran.stdout().contains(what), "{line}");
    }
}

#[test]
fn a_scene_that_is_not_there_is_not_worth_a_retry() {
    Place::new().run("render none.gltf -o x.exr").fails(3, "none.gltf");
    Place::new().run("info none.gltf").fails(3, "none.gltf");
    Place::new().run("resume none.film").fails(3, "none.film");
    Place::new().run("merge none.film -o x.exr").fails(3, "none.film");
}

#[test]
fn a_file_that_is_no_film_is_refused() {
    let place = Place::new();
    std::fs::write(place.path("x.film"), "no film at all").unwrap();
    place.run("resume x.film").fails(3, "x.film");
    place.run("merge x.film -o y.exr").fails(3, "x.film");
}

#[test]
fn outputs_that_cannot_be_written_are_told_before_the_scene_is_read() {
    let place = Place::new();
    for option in
        ["-o none/x.exr", "-o x.exr --film none/x.film", "-o x.exr --report none/x.json", "-o /dev/null/x.exr"]
    {
        place.run(&format!("render none.gltf {option}")).fails(4, "cannot write");
    }
}

#[test]
fn configuration_mistakes_name_file_line_and_key() {
    let place = Place::new();
    std::fs::write(place.path("s.gltf"), EMPTY).unwrap();
    std::fs::write(place.path("render.toml"), "spp = 4\nsped = 3\n").unwrap();
    for command in ["render", "info"] {
        let ran = place.run(&format!("{command} s.gltf"));
        ran.fails(2, "render.toml");
        ran.fails(2, "line 2");
        ran.fails(2, "sped");
    }
}
