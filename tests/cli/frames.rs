//! `--frame` and `--fps`: which time of a scene's animations is shown, and that a film remembers it.

use crate::run::Place;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;

const LINE: &str = "render s.gltf --size 8x8 --spp 8 --filter box";

/// A place with a scene whose triangle moves out of the view within a second.
fn place() -> Place {
    let triangle = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let (times, moves) = ([0.0f32, 1.0], [0.0f32, 0.0, 0.0, 2.4, 0.0, 0.0]);
    let bytes: Vec<u8> = triangle.iter().chain(&times).chain(&moves).flat_map(|f| f.to_le_bytes()).collect();
    let view = |offset: usize, length: usize| json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
    let accessor = |view: usize, shape: &str, count: usize| {
        let floats = 5126;
        json!({ "bufferView": view, "componentType": floats, "type": shape, "count": count })
    };
    let scene = json!({
        "asset": { "version": "2.0" },
        "nodes": [{ "mesh": 0 }, { "camera": 0, "translation": [0.3, 0.3, 1] }],
        "cameras": [{ "type": "orthographic", "orthographic": { "xmag": 0.6, "ymag": 0.6, "zfar": 9, "znear": 0.1 } }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "buffers": [{
            "byteLength": bytes.len(),
            "uri": format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bytes))
        }],
        "bufferViews": [view(0, 36), view(36, 8), view(44, 24)],
        "accessors": [accessor(0, "VEC3", 3), accessor(1, "SCALAR", 2), accessor(2, "VEC3", 2)],
        "animations": [{
            "samplers": [{ "input": 1, "output": 2 }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }]
        }]
    });
    let place = Place::new();
    std::fs::write(place.path("s.gltf"), scene.to_string()).unwrap();
    place
}

#[test]
fn frames_are_pictures_of_their_times() {
    let place = place();
    let pixels = |more: &str| place.pixels(&format!("{LINE} {more} -o a.exr"));
    let rest = pixels("");
    assert_eq!(pixels("--fps 30"), rest);
    // At time 0 nothing has moved.
    assert_eq!(pixels("--frame 0"), rest);
    let quarter = pixels("--frame 6");
    assert_ne!(quarter, rest);
    assert_ne!(pixels("--frame 12"), quarter);
    assert_eq!(pixels("--frame 3 --fps 12"), quarter);
    std::fs::write(place.path("render.toml"), "fps = 12\nframe = 3\n").unwrap();
    assert_eq!(pixels(""), quarter);
    assert_eq!(pixels("--frame 6 --fps 24"), quarter);
}

#[test]
fn settings_name_the_frame_only_where_there_is_one() {
    let place = place();
    let settings = |more: &str| place.report(&format!("{LINE} {more} -o a.exr"))["settings"].clone();
    assert_eq!(settings("--frame 6")["frame"], json!({ "number": 6, "fps": 24.0 }));
    assert!(settings("").get("frame").is_none());
}

#[test]
fn frames_past_the_end_and_of_nothing_are_warned_of() {
    let place = place();
    let warnings = |more: &str| {
        let ran = place.run(&format!("{LINE} {more} -o a.exr"));
        assert_eq!(ran.code(), 0, "{}", ran.stderr());
        ran.stderr()
    };
    assert!(!warnings("--frame 24").contains("frame"));
    let late = warnings("--frame 30");
    assert!(late.contains("warning: frame 30, at 1.250 s, is past the end of the animation, at 1.000 s"), "{late}");
    assert!(warnings("").contains("animations are not played, as no frame is asked for"));
    let ran = place.run("info s.gltf --frame 30");
    assert!(ran.stdout().contains("warning    frame 30, at 1.250 s, is past the end"), "{}", ran.stdout());
    let text = std::fs::read_to_string(place.path("s.gltf")).unwrap().replace("animations", "extras");
    std::fs::write(place.path("s.gltf"), text).unwrap();
    let none = warnings("--frame 3");
    assert!(none.contains("frame 3 was asked for, and no node is animated"), "{none}");
}

#[test]
fn warnings_that_all_frames_share_are_printed_once() {
    let place = place();
    let text = std::fs::read_to_string(place.path("s.gltf")).unwrap();
    let text = text.replacen('{', r#"{"extensionsUsed":["EXT_of_nobody"],"#, 1);
    std::fs::write(place.path("s.gltf"), text).unwrap();
    let ran = place.run(&format!("{LINE} --frames 28-30 -o {{frame}}.exr"));
    assert_eq!(ran.code(), 0, "{}", ran.stderr());
    let stderr = ran.stderr();
    assert_eq!(stderr.matches("EXT_of_nobody").count(), 1, "{stderr}");
    assert_eq!(stderr.matches("is past the end").count(), 3, "{stderr}");
}

#[test]
fn frames_that_make_no_sense_are_refused() {
    let place = place();
    for (more, what) in [
        ("--frame -1", "'-1' for '--frame"),
        ("--frame 1.5", "'1.5' for '--frame"),
        ("--frame 1 --fps 0", "fps must be above zero"),
        ("--frame 1 --fps -24", "fps must be above zero"),
        ("--fps inf", "fps must be above zero"),
        ("--fps nan", "fps must be above zero"),
    ] {
        let ran = place.run(&format!("{LINE} {more} -o a.exr"));
        assert!(ran.code() == 2 && ran.stderr().contains(what), "{more}: {}", ran.stderr());
    }
    let text = std::fs::read_to_string(place.path("s.gltf")).unwrap().replace("\"input\":1", "\"input\":9");
    std::fs::write(place.path("s.gltf"), text).unwrap();
    assert_eq!(place.run(&format!("{LINE} -o a.exr")).code(), 0);
    place.run(&format!("{LINE} --frame 1 -o a.exr")).fails(3, "s.gltf: animation 'animation 0': translation of node");
}

#[test]
fn films_remember_their_frame_and_refuse_others() {
    let place = place();
    let shard = |i: usize, more: &str| place.report(&format!("{LINE} {more} --shard {i}/2 -o {i}.film --aov instance"));
    let whole = place.pixels(&format!("{LINE} --frame 6 -o a.exr --aov instance"));
    shard(0, "--frame 6");
    shard(1, "--frame 6");
    assert_eq!(place.pixels("merge 0.film 1.film -o a.exr"), whole);
    for (more, what) in [
        ("--frame 7", "different frames: 6 at 24 per second and 7 at 24 per second"),
        ("--frame 6 --fps 30", "different frames"),
        ("", "different frames: 6 at 24 per second and none"),
    ] {
        shard(1, more);
        place.run("merge 0.film 1.film -o a.exr").fails(2, what);
    }
}

#[test]
fn resuming_renders_the_same_frame() {
    let place = place();
    let whole = place.pixels(&format!("{LINE} --frame 6 -o a.exr").replace("--spp 8", "--spp 16"));
    place.report(&format!("{LINE} --frame 6 -o a.film"));
    // What render.toml says now is not what the film began with.
    std::fs::write(place.path("render.toml"), "frame = 20\n").unwrap();
    assert_eq!(place.pixels("resume a.film --spp 16"), whole);
}
