//! Files of bad and of extreme lights: a right picture, or one sentence and the exit code of scenes.

use crate::run::Place;
use base64::Engine;
use serde_json::{Value, json};

fn accessor(view: u32, count: usize, mut kind: Value) -> Value {
    kind["bufferView"] = json!(view);
    kind["count"] = json!(count);
    kind
}

/// A floor of side 4 under a mesh of these vertices and indices, which has a material, and a camera that looks down.
fn file(corners: &[[f32; 3]], triangles: &[[u32; 3]], material: Value) -> Value {
    let floor = [[-2.0f32, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0], [-2.0, 0.0, -2.0]];
    let parts: [&[u8]; 4] = [
        bytemuck::cast_slice(&floor),
        bytemuck::cast_slice(&[0u32, 1, 2, 0, 2, 3]),
        bytemuck::cast_slice(corners),
        bytemuck::cast_slice(triangles),
    ];
    let mut begin = 0;
    let views = parts.map(|part| {
        begin += part.len();
        json!({ "buffer": 0, "byteOffset": begin - part.len(), "byteLength": part.len() })
    });
    let data = base64::engine::general_purpose::STANDARD.encode(parts.concat());
    let positions = |view: u32, count: usize| {
        let kind = json!({ "componentType": 5126, "type": "VEC3" });
        accessor(view, count, kind)
    };
    let indices = |view: u32, count: usize| {
        let kind = json!({ "componentType": 5125, "type": "SCALAR" });
        accessor(view, 3 * count, kind)
    };
    let primitive = |first: u32, material: u32| {
        let attributes = json!({ "POSITION": first });
        json!({ "attributes": attributes, "indices": first + 1, "material": material })
    };
    let down = std::f64::consts::FRAC_1_SQRT_2;
    json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 1, 2] }],
        "nodes": [
            { "mesh": 0 }, { "mesh": 1 },
            { "camera": 0, "translation": [0, 2, 0], "rotation": [-down, 0, 0, down] }],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } }],
        "materials": [{ "name": "floor", "pbrMetallicRoughness": { "metallicFactor": 0 } }, material],
        "meshes": [{ "primitives": [primitive(0, 0)] }, { "primitives": [primitive(2, 1)] }],
        "accessors": [positions(0, 4), indices(1, 2), positions(2, corners.len()), indices(3, triangles.len())],
        "bufferViews": views,
        "buffers": [{ "byteLength": begin, "uri": format!("data:application/octet-stream;base64,{data}") }]
    })
}

/// A triangle beside the view that shines down.
const CORNERS: [[f32; 3]; 3] = [[1.2, 1.0, -0.5], [1.7, 1.0, 0.0], [1.2, 1.0, 0.5]];

/// A fan of 20 triangles in its place: so many lights that the tree selects them.
fn lit(material: Value) -> Value {
    let [a, apex, b] = CORNERS;
    let between = |i: u32| [a[0], a[1], a[2] + (b[2] - a[2]) * i as f32 / 20.0];
    let corners: Vec<[f32; 3]> = (0..=20).map(between).chain([apex]).collect();
    let triangles: Vec<[u32; 3]> = (0..20).map(|i| [i, 21, i + 1]).collect();
    file(&corners, &triangles, material)
}

fn written(scene: &Value) -> Place {
    let place = Place::new();
    std::fs::write(place.path("s.gltf"), scene.to_string()).unwrap();
    place
}

const RENDER: &str = "render s.gltf --size 16x16 --spp 4 -o x.exr";

/// The mean of the picture, of which no sample may be other than finite.
fn mean(scene: &Value) -> f64 {
    let report = written(scene).report(&format!("{RENDER} --fail-on-nonfinite"));
    report["error"]["mean"].as_f64().unwrap()
}

fn glowing(factor: [f64; 3], strength: f64) -> Value {
    let extensions = json!({ "KHR_materials_emissive_strength": { "emissiveStrength": strength } });
    json!({ "name": "a", "emissiveFactor": factor, "extensions": extensions })
}

fn strong(strength: f64) -> Value {
    glowing([1.0; 3], strength)
}

#[test]
fn emission_out_of_range_is_refused() {
    let refused =
        [glowing([1e39, 0.0, 0.0], 1.0), glowing([0.0, -1.0, 0.0], 1.0), strong(-1.0), strong(1e39), strong(3e38)];
    for material in refused {
        written(&lit(material)).run(RENDER).fails(3, "the emission is out of range");
    }
}

#[test]
fn positions_out_of_range_are_refused() {
    for bad in [f32::NAN, f32::INFINITY] {
        let mut corners = CORNERS;
        corners[1][2] = bad;
        written(&file(&corners, &[[0, 1, 2]], strong(1.0))).run(RENDER).fails(3, "has a value that is not finite");
    }
    let far = CORNERS.map(|corner| corner.map(|x| x * 1e30));
    written(&file(&far, &[[0, 1, 2]], strong(1.0))).run(RENDER).fails(3, "the scene has a radius of ");
    let mut lamp = lit(strong(1.0));
    let far = json!({ "name": "far", "type": "point", "intensity": 1 });
    lamp["extensions"] = json!({ "KHR_lights_punctual": { "lights": [far] } });
    let shines = json!({ "KHR_lights_punctual": { "light": 0 } });
    let node = json!({ "name": "far", "translation": [1e30, 0, 0], "extensions": shines });
    lamp["nodes"].as_array_mut().unwrap().push(node);
    lamp["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    written(&lamp).run(RENDER).fails(3, "light 'far' is farther than 1e18 times the size of the scene");
}

/// Triangles without area emit nothing, however many and strong they are.
#[test]
fn triangles_without_area_emit_nothing() {
    let line = [[1.2f32, 1.0, -0.5], [1.2, 1.0, 0.5], [1.2, 1.0, 0.0]];
    let dark = mean(&file(&line, &[[0, 1, 2], [0, 0, 0], [1, 0, 1]].repeat(20), strong(1e9)));
    assert!(dark == 0.0, "{dark}");
}

/// The same twenty times over, in two strengths: the sum of both, each where it is representable.
#[test]
fn strong_and_weak_lamps_add_up() {
    let one = mean(&lit(strong(1.0)));
    assert!(one > 0.0);
    for strength in [1e30, 1e-30] {
        // f32 scales the strength, and the film the picture.
        assert!((mean(&lit(strong(strength))) / one / strength - 1.0).abs() < 1e-5, "{strength}"); // a few roundings
    }
    let mut both = lit(strong(1e30));
    let mut weak = both["meshes"][1].clone();
    weak["primitives"][0]["material"] = json!(2);
    both["meshes"].as_array_mut().unwrap().push(weak);
    both["materials"].as_array_mut().unwrap().push(strong(1e-30));
    both["nodes"][0] = json!({ "mesh": 0, "children": [3] });
    both["nodes"].as_array_mut().unwrap().push(json!({ "mesh": 2, "translation": [0, 0.1, 0] }));
    // Samples are others, and their mean is within a part of it.
    assert!((0.5..2.0).contains(&(mean(&both) / one / 1e30)));
}

/// A million triangles at one place load and render in seconds. Each of them is sampled, though rays hit but one:
/// without scattered rays they shine a million times.
#[test]
fn a_million_coincident_triangles_are_one_lamp() {
    let mean = |triangles: &[[u32; 3]], strength| {
        let place = written(&file(&CORNERS, triangles, strong(strength)));
        place.report(&format!("{RENDER} --method path-nee"))["error"]["mean"].as_f64().unwrap()
    };
    let (one, many) = (mean(&[[0, 1, 2]], 1e6), mean(&vec![[0, 1, 2]; 1_000_000], 1.0));
    // The numbers that choose points are the same, those that choose the light change nothing.
    assert!((many / one - 1.0).abs() < 1e-3, "{many} {one}"); // f32 probabilities of a millionth
}
