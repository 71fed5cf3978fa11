//! Nodes, cameras and lights.

use crate::support::{File, merge};
use etendue::scene::description::{Projection, PunctualKind};
use glam::{DMat3, DVec3, DVec4};
use serde_json::{Value, json};

fn nodes(nodes: Value) -> File {
    File::triangle(json!({ "nodes": nodes }))
}

#[test]
fn transforms_far_from_the_origin_keep_their_digits() {
    let far = [1_000_000.123_456_789, -2_000_000.000_000_1, 0.1];
    let file = nodes(json!([
        { "translation": far, "children": [1] },
        { "translation": [0.000_000_001, 0, 0], "children": [2] },
        { "mesh": 0, "matrix": [2, 0, 0, 0, 0, 3, 0, 0, 0, 0, 4, 0, 0.25, 0, 0, 1] }
    ]));
    let description = file.load().expect("a valid file");
    let transform = description.instances[0].transform;
    assert_eq!(transform.matrix3, DMat3::from_diagonal(DVec3::new(2.0, 3.0, 4.0)));
    // Two roundings of the sum in f64; in f32 the first digit lost would be 0.06.
    let want = DVec3::from(far) + DVec3::new(0.250_000_001, 0.0, 0.0);
    assert!((transform.translation - want).abs().cmple(want.abs() * 2.0 * f64::EPSILON).all());
}

#[test]
fn rotations_rounded_to_f32_do_not_scale() {
    let half = f64::from(std::f32::consts::FRAC_1_SQRT_2);
    let description = nodes(json!([{ "mesh": 0, "rotation": [0, 0, half, half] }])).load().expect("a valid file");
    let x = description.instances[0].transform.matrix3.x_axis;
    // An f32 quaternion left as it is would be off by about 3e-8.
    assert!((x - DVec3::Y).length() <= 8.0 * f64::EPSILON, "{x}");
}

#[test]
fn the_default_scene_is_loaded_else_the_first_else_all_roots() {
    let names = |more: Value| {
        let mut file =
            nodes(json!([{ "name": "a", "mesh": 0 }, { "name": "b", "mesh": 0, "children": [2] }, { "mesh": 0 }]));
        merge(&mut file.json, more);
        file.load().expect("a valid file").instances.into_iter().map(|i| i.name).collect::<Vec<_>>()
    };
    assert_eq!(names(json!({ "scenes": [{ "nodes": [0] }, { "nodes": [1] }], "scene": 1 })), ["b", "node 2"]);
    assert_eq!(names(json!({ "scenes": [{ "nodes": [0] }, { "nodes": [1] }] })), ["a"]);
    assert_eq!(names(json!({})), ["a", "b", "node 2"]);
    assert!(names(json!({ "scenes": [{}] })).is_empty());
}

#[test]
fn cycles_and_second_parents_are_errors() {
    let own = nodes(json!([{ "name": "loop", "children": [1] }, { "children": [0] }]));
    assert!(own.error().contains("every node is below another one"), "{}", own.error());
    let mut listed = own;
    listed.json["scenes"] = json!([{ "nodes": [0] }]);
    assert!(listed.error().contains("node 'loop' is its own ancestor"), "{}", listed.error());
    let itself =
        File::triangle(json!({ "scenes": [{ "nodes": [0] }], "nodes": [{ "name": "self", "children": [0] }] }));
    assert!(itself.error().contains("node 'self' is its own ancestor"), "{}", itself.error());
    let shared = nodes(json!([{ "name": "p", "children": [2] }, { "name": "q", "children": [2] }, { "name": "c" }]));
    assert_eq!(shared.error(), "node 'c' has two parents, 'p' and 'q'");
}

#[test]
fn a_chain_of_many_thousand_nodes_is_followed_to_its_end() {
    let depth = 100_000;
    let mut chain: Vec<Value> = (1..depth).map(|i| json!({ "translation": [1, 0, 0], "children": [i] })).collect();
    chain.push(json!({ "mesh": 0 }));
    let description = nodes(Value::Array(chain)).load().expect("a valid file");
    assert_eq!(description.instances[0].transform.translation, DVec3::X * f64::from(depth - 1));
}

#[test]
fn parts_scaled_to_zero_are_left_out_and_said() {
    let file = nodes(json!([{ "name": "flat", "scale": [1, 0, 1], "children": [1] }, { "mesh": 0 }, { "mesh": 0 }]));
    let description = file.load().expect("a valid file");
    assert_eq!((description.instances.len(), description.ignored.len()), (2, 0));
    let file = nodes(json!([{ "scale": [0, 0, 0], "children": [1] }, { "name": "gone", "mesh": 0 }, { "mesh": 0 }]));
    let description = file.load().expect("a valid file");
    assert_eq!((description.instances.len(), description.hides), (1, true));
    assert_eq!(description.ignored[1], "node 'gone' is scaled to zero: its mesh and its light are left out");
}

#[test]
fn transforms_that_overflow_or_are_not_affine_are_errors() {
    let huge = nodes(json!([{ "scale": [1e300, 1, 1], "children": [1] }, { "name": "big", "scale": [1e300, 1, 1] }]));
    assert_eq!(huge.error(), "node 'big' has a transform that is not finite");
    let projective = nodes(json!([{ "name": "p", "matrix": [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] }]));
    assert!(projective.error().starts_with("node 'p': the matrix is not affine"));
    assert!(nodes(json!([{ "name": "r", "rotation": [0, 0, 0, 0] }])).error().starts_with("node 'r': the rotation"));
}

#[test]
fn cameras_keep_f64() {
    let yfov = 0.700_000_000_000_000_1;
    let file = File::triangle(json!({
        "nodes": [{ "camera": 0, "translation": [0.1, 0, 0] }, { "camera": 1 }],
        "cameras": [
            { "type": "perspective", "perspective": { "yfov": yfov, "znear": 0.1 } },
            { "type": "orthographic", "name": "o", "orthographic": { "xmag": 0.1, "ymag": 0.2, "znear": 0, "zfar": 1 } }
        ]
    }));
    let cameras = file.load().expect("a valid file").cameras;
    assert_eq!(cameras[0].projection, Projection::Perspective { yfov, aspect: None });
    assert_eq!((cameras[0].name.as_str(), cameras[0].transform.translation), ("camera 0", DVec3::X * 0.1));
    assert_eq!(cameras[1].projection, Projection::Orthographic { xmag: 0.1, ymag: 0.2 });
    for (key, bad) in [("yfov", json!(0)), ("yfov", json!(4)), ("aspectRatio", json!(-1))] {
        let mut file = File::triangle(file.json.clone());
        file.json["cameras"][0]["perspective"][key] = bad;
        let description = file.load().expect("a valid file");
        let left = if key == "aspectRatio" { 2 } else { 1 };
        assert_eq!((description.cameras.len(), description.ignored.len()), (left, 1), "{:?}", description.ignored);
    }
}

#[test]
fn punctual_lights_keep_their_numbers() {
    let at =
        |light: u32| json!({ "translation": [0, 1, 0], "extensions": { "KHR_lights_punctual": { "light": light } } });
    let nodes = [0, 1, 2].map(at);
    let file = File::triangle(json!({
        "nodes": nodes,
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [
            { "type": "point", "intensity": 8, "color": [1, 0.5, 0], "range": 3 },
            { "type": "spot", "name": "s", "spot": { "innerConeAngle": 0.25, "outerConeAngle": 0.5 } },
            { "type": "directional", "intensity": 2 }
        ] } }
    }));
    let description = file.load().expect("a valid file");
    let [point, spot, sun] = &description.lights[..] else { panic!("three lights") };
    assert_eq!((point.kind, point.intensity.to_rgb()), (PunctualKind::Point, [8.0, 4.0, 0.0]));
    assert_eq!((spot.kind, spot.name.as_str()), (PunctualKind::Spot { inner: 0.25, outer: 0.5 }, "s"));
    assert_eq!((sun.kind, sun.intensity.to_rgb()), (PunctualKind::Directional, [2.0; 3]));
    assert_eq!(point.transform.translation.extend(1.0), DVec4::new(0.0, 1.0, 0.0, 1.0));
    assert_eq!(description.ignored.len(), 1);
    assert!(description.ignored[0].contains("range"));
}

/// A triangle whose node, moved by (1, 0, 0), stands for two copies.
fn copies(attributes: impl FnOnce(&mut File) -> Value) -> File {
    let mut file = File::triangle(json!({ "extensionsRequired": ["EXT_mesh_gpu_instancing"] }));
    let attributes = attributes(&mut file);
    file.json["nodes"][0]["translation"] = json!([1, 0, 0]);
    file.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    file
}

#[test]
fn instances_of_the_extension_stand_below_their_node() {
    let file = copies(|f| {
        let moves = f.accessor(5126, "VEC3", 2, bytemuck::cast_slice(&[0.0f32, 0.0, 0.0, 0.0, 2.0, 0.0]));
        // None, then a quarter turn around z in normalised bytes, whose length is not quite 1.
        let turns = f.accessor(5120, "VEC4", 2, bytemuck::cast_slice(&[0i8, 0, 0, 127, 0, 0, 90, 90]));
        f.json["accessors"][turns]["normalized"] = json!(true);
        let sizes = f.accessor(5126, "VEC3", 2, bytemuck::cast_slice(&[1.0f32, 1.0, 1.0, 3.0, 1.0, 1.0]));
        json!({ "TRANSLATION": moves, "ROTATION": turns, "SCALE": sizes })
    });
    let scene = file.load().expect("a valid file");
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 2));
    let at = |copy: usize| scene.instances[copy].transform.transform_point3(DVec3::X);
    assert_eq!(at(0), DVec3::new(2.0, 0.0, 0.0));
    // Scaled, then turned, then moved; sines of 45 degrees in f64.
    assert!((at(1) - DVec3::new(1.0, 5.0, 0.0)).length() < 8.0 * f64::EPSILON, "{}", at(1));
}

#[test]
fn defects_of_the_extension_are_errors() {
    let error = |attributes: fn(&mut File) -> Value| copies(attributes).error();
    let differing = error(|f| {
        let two = f.accessor(5126, "VEC3", 2, &[0; 24]);
        json!({ "TRANSLATION": two, "SCALE": 0 })
    });
    assert_eq!(differing, "node 'n': EXT_mesh_gpu_instancing has 2 elements of one attribute and 3 of another");
    assert!(
        error(|_| json!({ "TRANSLATION": 77 })).ends_with("TRANSLATION of EXT_mesh_gpu_instancing: it does not exist")
    );
    assert!(error(|_| json!({ "ROTATION": 0 })).contains("4 components"));
    let zero = error(|f| json!({ "ROTATION": f.accessor(5126, "VEC4", 1, &[0; 16]) }));
    assert!(zero.contains("rotation 0 of EXT_mesh_gpu_instancing is not a unit quaternion"), "{zero}");
    let bytes = error(|f| json!({ "SCALE": f.accessor(5120, "VEC3", 1, &[1; 3]) }));
    assert!(bytes.contains("component type that is not for it"), "{bytes}");
    let flat = copies(|f| json!({ "SCALE": f.accessor(5126, "VEC3", 1, &[0; 12]) })).load().expect("a valid file");
    assert_eq!(flat.ignored, ["copies of node 'n' are scaled to a line or a point and are left out"]);
}

/// A million copies of what takes no bytes in the file, for each of many nodes.
#[test]
fn copies_without_data_are_bounded() {
    let mut file = copies(|f| {
        f.view(&[0; 1 << 16]);
        let zeros = json!({ "componentType": 5126, "type": "VEC3", "count": 1 << 16 });
        json!({ "TRANSLATION": crate::support::push(&mut f.json["accessors"], zeros) })
    });
    assert_eq!(file.load().expect("a valid file").instances.len(), 1 << 16);
    let node = file.json["nodes"][0].clone();
    file.json["nodes"] = Value::Array(vec![node; 100]);
    assert!(file.error().ends_with("64 times its size"), "{}", file.error());
}

/// Axes of the camera of the last of `nodes`, of which only the first is a root.
fn axes(chain: Value) -> glam::DMat3 {
    let mut file = nodes(chain);
    file.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 1.0, "znear": 0.1 } }]);
    file.load().expect("a valid file").cameras.remove(0).transform.matrix3
}

#[test]
fn cameras_ignore_scale_and_keep_right_angles() {
    let turn = json!([0, 0, (std::f64::consts::FRAC_PI_8).sin(), (std::f64::consts::FRAC_PI_8).cos()]);
    for scale in [json!([-1, -1, -1]), json!([2, -3, 0]), json!([0, 0, 0]), json!([1, 1, -1])] {
        let own = axes(json!([{ "camera": 0, "scale": scale }]));
        let above = axes(json!([{ "scale": scale, "children": [1] }, { "camera": 0 }]));
        assert_eq!([own, above], [glam::DMat3::IDENTITY; 2], "{scale}");
    }
    for scale in [json!([1, 3, 1]), json!([-2, 3, 0.5])] {
        let sheared = axes(json!([{ "scale": scale, "children": [1] }, { "camera": 0, "rotation": turn }]));
        // Columns of unit length at right angles, right-handed; a dozen roundings.
        let off = (sheared.transpose() * sheared - glam::DMat3::IDENTITY).to_cols_array();
        assert!(off.iter().all(|x| x.abs() < 12.0 * f64::EPSILON) && sheared.determinant() > 0.0, "{sheared}");
        assert_eq!(sheared.z_axis, DVec3::Z);
    }
    let matrix = [1, 0, 0, 0, 0, 3, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1];
    assert_eq!(axes(json!([{ "camera": 0, "matrix": matrix }])), glam::DMat3::IDENTITY);
}

#[test]
fn doubtful_lights_shine_as_far_as_they_say_something() {
    let light = |light: Value| {
        let mut file = nodes(json!([{ "extensions": { "KHR_lights_punctual": { "light": 0 } } }]));
        file.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
        file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
        let description = file.load().expect("a valid file");
        (description.lights.first().map(|l| (l.kind, l.intensity.max_lane())), description.ignored.len())
    };
    let spot = |inner: f64, outer: f64| {
        light(json!({ "type": "spot", "spot": { "innerConeAngle": inner, "outerConeAngle": outer } }))
    };
    let cone = |inner, outer| Some((PunctualKind::Spot { inner, outer }, 1.0));
    assert_eq!(spot(0.25, 0.5), (cone(0.25, 0.5), 0));
    assert_eq!(spot(0.5, 0.5), (cone(0.5, 0.5), 1));
    assert_eq!(spot(0.75, 0.5), (cone(0.5, 0.5), 1));
    assert_eq!(spot(-0.5, 0.5), (cone(0.0, 0.5), 1));
    assert_eq!(spot(0.5, 2.0), (cone(0.5, std::f32::consts::FRAC_PI_2), 1));
    assert_eq!(spot(0.0, -1.0), (None, 1));
    assert_eq!(light(json!({ "type": "spot" })), (cone(0.0, std::f32::consts::FRAC_PI_4), 1));
    assert_eq!(light(json!({ "type": "area" })), (None, 1));
    assert_eq!(light(json!({ "type": "point", "intensity": -2 })), (Some((PunctualKind::Point, 0.0)), 1));
}
