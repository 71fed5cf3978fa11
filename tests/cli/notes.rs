//! What the console says of a scene: lamps that are there twice, sizes at which arithmetic ends, views that an image
//! does not fit, values that a file should not have.

use crate::run::Place;
use base64::Engine;
use serde_json::{Value, json};

/// A glowing triangle of that size in metres under a lamp, seen by a camera that is twice as wide as tall.
fn scene(size: f64) -> Value {
    let corners = [[0.0, 0.0, 0.0], [size, 0.0, 0.0], [0.0, size, 0.0]].map(|p| p.map(|x| x as f32));
    let bytes: Vec<u8> = corners.iter().flatten().flat_map(|x: &f32| x.to_le_bytes()).collect();
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 1, 2] }],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": 1 }] } },
        "nodes": [
            { "name": "lamp", "mesh": 0 }, { "camera": 0, "translation": [0, 0, 4.0 * size] },
            { "name": "bulb", "translation": [0, 0, size], "extensions": { "KHR_lights_punctual": { "light": 0 } } }],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.7, "aspectRatio": 2, "znear": 0.1 } }],
        "materials": [{ "emissiveFactor": [1, 1, 1] }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
        "accessors": [{ "componentType": 5126, "type": "VEC3", "count": 3, "bufferView": 0, "min": corners[0], "max": [size, size, 0] }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "buffers": [{ "byteLength": 36, "uri": format!("data:application/octet-stream;base64,{data}") }]
    })
}

fn place(scene: &Value) -> Place {
    let place = Place::new();
    std::fs::write(place.path("s.gltf"), scene.to_string()).unwrap();
    place
}

#[test]
fn lamps_that_are_there_twice_are_named() {
    let mut twice = scene(1.0);
    assert!(!place(&twice).run("info s.gltf").stdout().contains("coincide"));
    for (node, name) in [(0, "lamp copy"), (2, "bulb copy")] {
        let mut copy = twice["nodes"][node].clone();
        copy["name"] = name.into();
        twice["nodes"].as_array_mut().unwrap().push(copy);
    }
    twice["scenes"][0]["nodes"] = json!([0, 1, 2, 3, 4]);
    let said = place(&twice).run("info s.gltf").stdout();
    for pair in ["lights 'bulb' and 'bulb copy' coincide", "lights 'lamp' and 'lamp copy' coincide"] {
        assert!(said.contains(pair), "{said}");
    }
}

/// Within the sizes that are taken the picture does not depend on them; beyond, the reason is said.
#[test]
fn sizes_are_right_or_refused_with_the_reason() {
    let color = |size: f64| {
        let mut glowing = scene(size);
        glowing["scenes"][0]["nodes"] = json!([0, 1]);
        let place = place(&glowing);
        let report = place.report("render s.gltf --size 16x8 --spp 16 -o x.exr");
        report["error"]["mean"].as_f64().unwrap()
    };
    let one = color(1.0);
    for size in [1e-17, 1e-6, 1e6, 1e17] {
        // Edges move by roundings of f32, and a thousandth of a pixel by that.
        assert!((color(size) - one).abs() < 1e-3 * one && one > 0.01, "{size}: {} {one}", color(size));
    }
    for (size, what) in [(1e-30, "only radii of"), (1e35, "only radii of")] {
        place(&scene(size)).run("render s.gltf --size 4x2 --spp 1 -o x.exr").fails(3, what);
    }
}

#[test]
fn an_image_of_another_shape_shows_more_and_says_so() {
    let place = place(&scene(1.0));
    let said = |size: &str| place.run(&format!("render s.gltf --size {size} --spp 1 -o x.exr")).stderr();
    assert!(!said("16x8").contains("shape of camera"), "{}", said("16x8"));
    assert!(said("8x8").contains("2.0000 to 1: it shows more above and below"), "{}", said("8x8"));
    assert!(said("32x8").contains("2.0000 to 1: it shows more right and left"), "{}", said("32x8"));
}

#[test]
fn values_that_have_a_default_are_noted_and_strict_refuses_them() {
    let mut odd = scene(1.0);
    odd["materials"][0]["alphaMode"] = "MASKED".into();
    let place = place(&odd);
    let said = place.run("render s.gltf --size 4x2 --spp 1 -o x.exr");
    assert!(
        said.code() == 0 && said.stderr().contains("materials[0].alphaMode has an invalid value"),
        "{}",
        said.stderr()
    );
    place.run("render s.gltf --size 4x2 --spp 1 --strict -o x.exr").fails(3, "alphaMode");
}
