//! `--env` and its companions: where files are looked for, what is refused, and that a picture remembers its
//! environment.

use crate::run::Place;
use etendue::io::exr::{self, Layer};

/// A triangle that fills the lower left half of the view.
const SCENE: &str = r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0},{"camera":0,"translation":[0.3,0.3,1]}],
"cameras":[{"type":"orthographic","orthographic":{"xmag":0.6,"ymag":0.6,"zfar":9,"znear":0.1}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"buffers":[{"byteLength":36,
"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
"bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
"min":[0,0,0],"max":[1,1,0]}]}"#;

const LINE: &str = "render s/scene.gltf --size 8x8 --spp 8 --filter box";

/// A place with the scene in `s/` and a map of these four texels (2×2) in `s/map.exr`.
fn place(texels: [f32; 4]) -> Place {
    let place = Place::new();
    std::fs::create_dir(place.path("s")).unwrap();
    std::fs::write(place.path("s/scene.gltf"), SCENE).unwrap();
    write_map(&place, "s/map.exr", texels);
    place
}

fn write_map(place: &Place, name: &str, texels: [f32; 4]) {
    let layers = ["R", "G", "B"].map(|c| Layer { name: c.into(), values: texels.to_vec() });
    exr::write(&place.path(name), 2, 2, None, &layers, &[]).unwrap();
}

#[test]
fn paths_are_seen_from_where_they_are_written() {
    let place = place([1.0, 2.0, 3.0, 4.0]);
    let by_line = place.pixels(&format!("{LINE} --env s/map.exr --env-scale 2 -o a.exr"));
    let environment = &place.report(&format!("{LINE} --env s/map.exr --env-scale 2 -o a.exr"))["scene"]["environment"];
    assert_eq!(
        (&environment["environment"]["File"], &environment["scale"]),
        (&"map.exr".into(), &2.0.into()),
        "{environment}"
    );
    place.run(&format!("{LINE} --env map.exr -o a.exr")).fails(3, "map.exr");
    std::fs::write(place.path("s/render.toml"), "env = \"map.exr\"\nenv-scale = 2.0\n").unwrap();
    assert_eq!(place.pixels(&format!("{LINE} -o a.exr")), by_line);
    // The command line's environment comes without the file's scale.
    assert_ne!(place.pixels(&format!("{LINE} --env s/map.exr -o a.exr")), by_line);
    assert_eq!(place.pixels(&format!("{LINE} --env s/map.exr --env-scale 2 -o a.exr")), by_line);
}

#[test]
fn rotation_and_scale_change_the_picture_and_whole_turns_do_not() {
    let place = place([1.0, 2.0, 3.0, 4.0]);
    let pixels = |more: &str| place.pixels(&format!("{LINE} --env s/map.exr {more} -o a.exr"));
    let plain = pixels("");
    assert_eq!(pixels("--env-rotation 360 --env-scale 1"), plain);
    assert_ne!(pixels("--env-rotation -45"), plain);
    assert_ne!(pixels("--env-scale 0.5"), plain);
    let grey = place.pixels(&format!("{LINE} --env 1 -o a.exr"));
    assert_eq!(place.pixels(&format!("{LINE} --environment 0.5,0.5,0.5 --env-scale 2 -o a.exr")), grey);
}

#[test]
fn environments_that_make_no_sense_are_refused() {
    let place = place([1.0, f32::NAN, 3.0, 4.0]);
    for (more, what) in [
        ("--env-rotation 5", "env-rotation turns a map"),
        ("--env 1 --env-rotation 5", "env-rotation turns a map"),
        ("--env-scale 2", "env-scale scales an environment"),
        ("--env s/map.exr --env-scale -1", "env-scale must be"),
        ("--env s/map.exr --env-rotation inf", "env-rotation must be"),
        ("--env sky.png", "'sky.png' is not an environment"),
        ("--env -1", "radiance must be"),
    ] {
        let ran = place.run(&format!("{LINE} {more} -o a.exr"));
        assert!(ran.code() == 2 && ran.stderr().contains(what), "{more}: {}", ran.stderr());
    }
    place.run(&format!("{LINE} --env s/map.exr -o a.exr")).fails(3, "map.exr: 1 of its 4 texels");
    place.run("info s/scene.gltf --env s/map.exr").fails(3, "map.exr: 1 of its 4 texels");
}

/// With `--transparent` the camera sees no map, and surfaces still do.
#[test]
fn transparent_hides_maps_from_the_camera_alone() {
    let place = place([1.0; 4]);
    place.report(&format!("{LINE} --env s/map.exr --transparent -o a.exr"));
    let image = exr::read(&place.path("a.exr")).unwrap();
    let channel = |name: &str| image.channel(name).unwrap();
    let (red, alpha) = (channel("R"), channel("A"));
    let holes = alpha.iter().zip(red).filter(|(alpha, _)| **alpha <= 0.0);
    assert!(holes.clone().count() > 8 && holes.clone().all(|(_, red)| *red <= 0.0), "{red:?} {alpha:?}");
    assert!(alpha.iter().zip(red).any(|(alpha, red)| *alpha >= 1.0 && *red > 0.1), "{red:?} {alpha:?}");
}

#[test]
fn films_remember_their_environment_and_refuse_others() {
    let place = place([1.0, 2.0, 3.0, 4.0]);
    let shard = |i: usize, env: &str| place.report(&format!("{LINE} {env} --shard {i}/2 -o {i}.film --aov instance"));
    let whole = place.pixels(&format!("{LINE} --env s/map.exr --env-rotation 30 -o a.exr --aov instance"));
    shard(0, "--env s/map.exr --env-rotation 30");
    // The same pixels at another place are the same environment.
    std::fs::copy(place.path("s/map.exr"), place.path("other.exr")).unwrap();
    shard(1, "--env other.exr --env-rotation 30");
    assert_eq!(place.pixels("merge 0.film 1.film -o a.exr"), whole);
    write_map(&place, "other.exr", [1.0, 2.0, 3.0, 5.0]);
    for env in [
        "--env other.exr --env-rotation 30",
        "--env s/map.exr",
        "--env s/map.exr --env-rotation 30 --env-scale 2",
        "--env 1",
    ] {
        shard(1, env);
        place.run("merge 0.film 1.film -o a.exr").fails(2, "scenes");
    }
}

#[test]
fn resuming_needs_the_same_map_wherever_it_is_now() {
    let place = place([1.0, 2.0, 3.0, 4.0]);
    let whole = place.pixels(&format!("{LINE} --spp 16 --env s/map.exr -o a.exr").replace("--spp 8 ", ""));
    place.report(&format!("{LINE} --env s/map.exr -o a.film"));
    std::fs::rename(place.path("s/map.exr"), place.path("moved.exr")).unwrap();
    place.run("resume a.film --spp 16").fails(3, "map.exr");
    write_map(&place, "wrong.exr", [1.0, 2.0, 3.0, 5.0]);
    place.run("resume a.film --spp 16 --env wrong.exr").fails(2, "scenes");
    assert_eq!(place.pixels("resume a.film --spp 16 --env moved.exr"), whole);
}
