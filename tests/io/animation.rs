//! Nodes at a time: closed forms, files made here, the sample models, and broken ones.

use crate::corpus::files_below;
use crate::defects::is_valid;
use crate::support::{File, load_bytes_at, merge, push, sentence, shared};
use etendue::io::gltf;
use etendue::io::scene_file::{self, ReadOptions};
use etendue::scene::description::Description;
use glam::{DMat3, DQuat, DVec3};
use serde_json::{Value, json};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4, PI};
use std::panic::catch_unwind;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Quaternions and matrices from numbers up to 1 by a handful of operations.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Adds an accessor of floats with that shape.
fn floats<const N: usize>(file: &mut File, shape: &str, values: &[[f32; N]]) -> usize {
    file.accessor(5126, shape, values.len(), bytemuck::cast_slice(values.as_flattened()))
}

/// Adds an animation with one channel to `node`; where it stands.
fn animate(file: &mut File, node: usize, path: &str, [input, output]: [usize; 2], interpolation: &str) -> usize {
    let sampler = json!({ "input": input, "output": output, "interpolation": interpolation });
    let channel = json!({ "sampler": 0, "target": { "node": node, "path": path } });
    let animations = file.json.as_object_mut().expect("an object").entry("animations").or_insert(json!([]));
    push(animations, json!({ "samplers": [sampler], "channels": [channel] }))
}

/// A triangle whose node moves so.
fn moving<const N: usize>(path: &str, times: &[f32], values: &[[f32; N]], interpolation: &str) -> File {
    let mut file = File::triangle(json!({}));
    let times: Vec<[f32; 1]> = times.iter().map(|&t| [t]).collect();
    let accessors =
        [floats(&mut file, "SCALAR", &times), floats(&mut file, if N == 3 { "VEC3" } else { "VEC4" }, values)];
    animate(&mut file, 0, path, accessors, interpolation);
    file
}

fn at(file: &File, seconds: f64) -> Description {
    file.load_at(seconds).unwrap_or_else(|e| panic!("{}", e.chain()))
}

fn place(file: &File, seconds: f64) -> DVec3 {
    at(file, seconds).instances[0].transform.translation
}

/// Where the node's x axis points.
fn axis(file: &File, seconds: f64) -> DVec3 {
    at(file, seconds).instances[0].transform.matrix3.x_axis
}

/// The direction in the plane of x and y at that angle from x.
fn angle(radians: f64) -> DVec3 {
    DVec3::new(radians.cos(), radians.sin(), 0.0)
}

/// The quaternion of a turn about z.
fn turn(radians: f64) -> [f32; 4] {
    DQuat::from_rotation_z(radians).as_quat().to_array()
}

#[test]
fn steps_stay_and_lines_go_straight() {
    let (times, values) = ([1.0, 2.0, 4.0], [[1.0, 0.0, 0.0], [3.0, 8.0, 0.0], [3.0, 8.0, -4.0]]);
    let [step, line] = ["STEP", "LINEAR"].map(|how| moving("translation", &times, &values, how));
    let first = DVec3::X;
    for (seconds, want) in
        [(-1.0, first), (0.0, first), (1.5, first), (2.0, DVec3::new(3.0, 8.0, 0.0)), (9.0, DVec3::new(3.0, 8.0, -4.0))]
    {
        assert_eq!(place(&step, seconds), want, "{seconds}");
    }
    for (seconds, want) in [
        (0.0, first),
        (1.0, first),
        (1.25, DVec3::new(1.5, 2.0, 0.0)),
        (3.5, DVec3::new(3.0, 8.0, -3.0)),
        (4.0, DVec3::new(3.0, 8.0, -4.0)),
        (1e300, DVec3::new(3.0, 8.0, -4.0)),
    ] {
        assert_eq!(place(&line, seconds), want, "{seconds}");
    }
    assert_eq!(at(&line, 0.0).animation_end, Some(4.0));
}

#[test]
fn cubic_splines_have_tangents_of_a_second() {
    // Of each key: the slope on its left, the value, the slope on its right. The outer slopes are never used.
    let (none, wild) = ([0.0; 3], [1e30; 3]);
    let smooth = moving("translation", &[1.0, 3.0], &[wild, none, none, none, [4.0, 0.0, 0.0], wild], "CUBICSPLINE");
    for (seconds, way) in [(0.0, 0.0), (1.0, 0.0), (1.5, 0.25), (2.0, 0.5), (2.5, 0.75), (3.0, 1.0), (7.0, 1.0)] {
        let want = 4.0 * way * way * (3.0 - 2.0 * way);
        assert!((place(&smooth, seconds).x - want).abs() <= 4.0 * ROUNDING, "{seconds}");
    }
    // x = (t − 1)², whose slope is 0 at 1 s and 4 at 3 s.
    let square =
        moving("translation", &[1.0, 3.0], &[wild, none, none, [4.0, 0.0, 0.0], [4.0, 0.0, 0.0], wild], "CUBICSPLINE");
    for seconds in [1.0, 1.5, 2.0, 2.875] {
        let want = (seconds - 1.0) * (seconds - 1.0);
        assert!((place(&square, seconds).x - want).abs() <= 8.0 * ROUNDING, "{seconds}");
    }
}

#[test]
fn rotations_turn_evenly_the_shorter_way() {
    let quarter = moving("rotation", &[0.0, 1.0], &[turn(0.0), turn(PI / 2.0)], "LINEAR");
    // Keys are rounded to f32.
    let close = |file: &File, seconds, radians| {
        let got = axis(file, seconds);
        assert!((got - angle(radians)).length() <= 2.0 * f64::from(f32::EPSILON), "{seconds}: {got}");
        assert!((got.length() - 1.0).abs() <= ROUNDING, "{seconds}: {}", got.length());
    };
    for way in [0.0, 0.2, 0.5, 0.9, 1.0] {
        close(&quarter, way, way * PI / 2.0);
    }
    let back = moving("rotation", &[0.0, 1.0], &[turn(0.0), turn(PI * 1.5)], "LINEAR");
    close(&back, 0.5, -FRAC_PI_4);
    let step = moving("rotation", &[0.0, 1.0], &[turn(0.3), turn(PI / 2.0)], "STEP");
    close(&step, 0.9, 0.3);
    // Without tangents at the middle both keys count the same: a quarter turn's half.
    let (first, last, none) = (turn(0.0), turn(PI / 2.0), [0.0; 4]);
    let spline = moving("rotation", &[0.0, 1.0], &[none, first, none, none, last, none], "CUBICSPLINE");
    close(&spline, 0.5, FRAC_PI_4);
    close(&spline, 1.0, PI / 2.0);
}

#[test]
fn rotations_may_be_normalised_integers() {
    let half: [(u32, Vec<u8>); 4] = [
        (5120, bytemuck::cast_slice(&[0i8, 0, 90, 90]).to_vec()),
        (5121, vec![0, 0, 180, 180]),
        (5122, bytemuck::cast_slice(&[0i16, 0, 23170, 23170]).to_vec()),
        (5123, bytemuck::cast_slice(&[0u16, 0, 46341, 46341]).to_vec()),
    ];
    for (kind, bytes) in half {
        let mut file = File::triangle(json!({}));
        let output = file.accessor(kind, "VEC4", 1, &bytes);
        let input = floats(&mut file, "SCALAR", &[[0.0]]);
        animate(&mut file, 0, "rotation", [input, output], "LINEAR");
        assert!(file.load_at(0.0).is_err(), "{kind} is not normalised");
        file.json["accessors"][output]["normalized"] = json!(true);
        assert!((axis(&file, 0.0) - DVec3::Y).length() <= ROUNDING, "{kind}");
        file.json["animations"][0]["channels"][0]["target"]["path"] = json!("scale");
        assert!(file.load_at(0.0).is_err(), "{kind} is not for scales");
    }
}

#[test]
fn sparse_values_are_read() {
    let mut file = moving("scale", &[0.0, 1.0], &[[1.0; 3], [1.0; 3]], "LINEAR");
    let (indices, values) = (file.view(&[1]), file.view(bytemuck::cast_slice(&[3.0f32, 3.0, 5.0])));
    file.json["accessors"][2]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": indices, "componentType": 5121 },
        "values": { "bufferView": values },
    });
    assert_eq!(at(&file, 0.5).instances[0].transform.matrix3, DMat3::from_diagonal(DVec3::new(2.0, 2.0, 3.0)));
}

#[test]
fn animations_are_played_together_and_the_last_of_two_wins() {
    let mut file = moving("translation", &[0.0, 1.0], &[[0.0; 3], [2.0, 0.0, 0.0]], "LINEAR");
    merge(&mut file.json["nodes"][0], json!({ "scale": [1, 2, 3], "translation": [9, 9, 9] }));
    let (times, values) =
        (floats(&mut file, "SCALAR", &[[0.0], [4.0]]), floats(&mut file, "VEC4", &[turn(0.0), turn(PI / 2.0)]));
    animate(&mut file, 0, "rotation", [times, values], "LINEAR");
    let [sin, cos] = [FRAC_1_SQRT_2; 2];
    let transform = at(&file, 2.0).instances[0].transform;
    let want = [cos, sin, 0.0, -2.0 * sin, 2.0 * cos, 0.0, 0.0, 0.0, 3.0];
    let got = transform.matrix3.to_cols_array();
    assert!(got.iter().zip(want).all(|(a, b)| (a - b).abs() <= 4.0 * f64::from(f32::EPSILON)), "{got:?}");
    assert_eq!((transform.translation, at(&file, 0.0).animation_end), (DVec3::new(2.0, 0.0, 0.0), Some(4.0)));
    let up = floats(&mut file, "VEC3", &[[0.0, 1.0, 0.0], [0.0, 3.0, 0.0]]);
    animate(&mut file, 0, "translation", [times, up], "LINEAR");
    assert_eq!(place(&file, 2.0), DVec3::new(0.0, 2.0, 0.0));
    assert_eq!(file.load().expect("a valid file").instances[0].transform.translation, DVec3::splat(9.0));
}

#[test]
fn meshes_cameras_and_lights_move_with_their_nodes() {
    let mut file = moving("translation", &[0.0, 1.0], &[[0.0; 3], [2.0, 0.0, 0.0]], "LINEAR");
    let lamp = json!({ "translation": [0, 0, 1], "extensions": { "KHR_lights_punctual": { "light": 0 } } });
    merge(
        &mut file.json,
        json!({
            "nodes": [{ "children": [1, 2, 3] }, { "mesh": 0 }, { "camera": 0, "translation": [0, 1e9, 0.1] }, lamp],
            "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } }],
            "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point" }] } }
        }),
    );
    let scene = at(&file, 0.25);
    assert_eq!(scene.instances[0].transform.translation, DVec3::new(0.5, 0.0, 0.0));
    assert_eq!(scene.cameras[0].transform.translation, DVec3::new(0.5, 1e9, 0.1));
    assert_eq!(scene.lights[0].transform.translation, DVec3::new(0.5, 0.0, 1.0));
    animate(&mut file, 2, "translation", [1, 2], "LINEAR");
    assert_eq!(at(&file, 0.25).cameras[0].transform.translation, DVec3::new(1.0, 0.0, 0.0));
}

#[test]
fn unsupported_animation_channels_are_reported() {
    let mut file = File::triangle(json!({}));
    let (times, values) = (floats(&mut file, "SCALAR", &[[0.0]]), floats(&mut file, "SCALAR", &[[1.0]]));
    animate(&mut file, 0, "weights", [times, values], "LINEAR");
    let channels = json!([
        { "sampler": 0, "target": { "path": "translation" } },
        { "sampler": 0, "target": { "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": "/x" } } } }
    ]);
    push(&mut file.json["animations"], json!({ "samplers": [{ "input": 0, "output": 0 }], "channels": channels }));
    let scene = at(&file, 0.0);
    assert_eq!(scene.animation_end, None);
    assert_eq!(
        scene.ignored,
        [
            "animations of morph targets are not played: the meshes are shown as modelled",
            "animations of anything but the translation, rotation and scale of nodes are not played"
        ]
    );
    let rest = file.load().expect("a valid file");
    assert_eq!(rest.ignored, ["animations are not played, as no frame is asked for: the scene is shown as it stands"]);
    let mut still = File::triangle(json!({ "animations": [] }));
    assert!(at(&still, 1.0).ignored.is_empty() && still.load().expect("a valid file").ignored.is_empty());
    still.json["animations"] = Value::Null;
    assert_eq!(at(&still, 1.0).animation_end, None);
}

#[test]
fn parts_that_are_scaled_to_zero_are_gone_at_that_time_alone() {
    let file = moving("scale", &[0.0, 1.0], &[[0.0; 3], [1.0; 3]], "STEP");
    assert_eq!((at(&file, 0.5).instances.len(), at(&file, 1.0).instances.len()), (0, 1));
}

/// The sentence of the error that the file must be at a time; without one it must load all the same.
fn error(file: &File) -> String {
    assert!(file.load().is_ok(), "what is not shown keeps the file from being shown");
    sentence("scene.glb", file.load_at(0.5))
}

#[test]
fn broken_animations_are_one_error_that_names_them() {
    let line = || moving("translation", &[0.0, 1.0], &[[0.0; 3], [1.0; 3]], "LINEAR");
    let with = |pointer: &str, value: Value| {
        let mut file = line();
        *file.json.pointer_mut(pointer).expect("a place") = value;
        error(&file)
    };
    let (target, sampler) = ("/animations/0/channels/0/target/node", "/animations/0/samplers/0");
    let [own, part] = ["animation 'animation 0': ", "translation of node 'n': "];
    assert_eq!(with(target, json!(7)), format!("{own}a channel moves node 7, which does not exist"));
    assert_eq!(with("/animations/0/channels/0/sampler", json!(1)), format!("{own}there is no sampler 1"));
    assert_eq!(with(&format!("{sampler}/input"), json!(9)), format!("{own}{part}accessor 9: it does not exist"));
    assert_eq!(with(&format!("{sampler}/output"), json!(9)), format!("{own}{part}accessor 9: it does not exist"));
    let spline = with(&format!("{sampler}/interpolation"), json!("CUBICSPLINE"));
    assert_eq!(
        spline,
        format!("{own}{part}accessor 2: it has 2 elements for 2 keys, of which each has three on a cubic spline")
    );
    assert!(with(&format!("{sampler}/interpolation"), json!("QUINTIC")).starts_with("the animations are not valid: "));
    assert!(with("/animations", json!({ "a": 1 })).starts_with("the animations are not valid: "));
    assert!(with(target, json!(-1)).starts_with("the animations are not valid: "));
    assert_eq!(
        with("/animations/0/channels/0/target/path", json!("rotation")),
        format!("{own}rotation of node 'n': accessor 2: it has elements of kind Vec3 where 4 components are needed")
    );
    let mut matrix = line();
    matrix.json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    matrix.json["animations"][0]["name"] = json!("RandomWalk");
    assert_eq!(
        error(&matrix),
        "animation 'RandomWalk': it moves node 'n', which has a matrix, and the two exclude each other"
    );
}

#[test]
fn hostile_keys_are_one_error() {
    let part = "animation 'animation 0': translation of node 'n': ";
    let keys = |times: &[f32], values: &[[f32; 3]]| error(&moving("translation", times, values, "LINEAR"));
    let two = [[0.0; 3]; 2];
    assert_eq!(keys(&[0.0, f32::NAN], &two), format!("{part}accessor 1: time 1 is not finite"));
    assert_eq!(keys(&[0.0, f32::INFINITY], &two), format!("{part}accessor 1: time 1 is not finite"));
    assert_eq!(keys(&[1.0, 0.0], &two), format!("{part}accessor 1: time 1 is not later than the one before it"));
    assert_eq!(keys(&[1.0, 1.0], &two), format!("{part}accessor 1: time 1 is not later than the one before it"));
    assert_eq!(keys(&[0.0, 1.0, 2.0], &two), format!("{part}accessor 2: it has 2 elements for 3 keys"));
    assert_eq!(keys(&[0.0], &two), format!("{part}accessor 2: it has 2 elements for 1 keys"));
    assert_eq!(
        keys(&[0.0, 1.0], &[[0.0; 3], [f32::NAN; 3]]),
        format!("{part}accessor 2: it has a value that is not finite")
    );
    let short = {
        let mut file = moving("translation", &[0.0, 1.0], &two, "LINEAR");
        file.json["accessors"][2]["count"] = json!(3);
        error(&file)
    };
    assert_eq!(short, format!("{part}accessor 2: 3 elements end at byte 36 of a buffer view of 24 bytes"));
    let none = {
        let mut file = moving("translation", &[0.0, 1.0], &two, "LINEAR");
        file.json["accessors"][1]["count"] = json!(0);
        sentence("scene.glb", file.load_at(0.5))
    };
    assert_eq!(none, format!("{part}accessor 1: it has no times"));
    let zero = error(&moving("rotation", &[0.0, 1.0], &[[0.0; 4], turn(0.0)], "LINEAR"));
    assert!(zero.ends_with("rotation of node 'n': accessor 2: it is not a unit quaternion"), "{zero}");
    // From a rotation to its negative, which a spline does not turn round: in the middle there is none.
    let (to, none) = (turn(0.0).map(|c| -c), [0.0; 4]);
    let through = error(&moving("rotation", &[0.0, 1.0], &[none, turn(0.0), none, none, to, none], "CUBICSPLINE"));
    assert!(through.ends_with("it is not a unit quaternion"), "{through}");
    let mut integers = moving("translation", &[0.0, 1.0], &two, "LINEAR");
    integers.json["accessors"][1]["componentType"] = json!(5125);
    assert_eq!(error(&integers), format!("{part}accessor 1: its component type is not for that"));
}

/// Each channel reads a few values of its accessor, however long that is.
#[test]
fn many_channels_over_long_accessors_are_cheap() {
    let many = 1 << 17;
    let times: Vec<f32> = (0..many).map(|i| i as f32).collect();
    let mut file = moving("translation", &times, &vec![[1.0; 3]; many], "LINEAR");
    let channel = file.json["animations"][0]["channels"][0].clone();
    file.json["animations"][0]["channels"] = Value::Array(vec![channel; 20_000]);
    let start = Instant::now();
    assert_eq!(place(&file, 0.5), DVec3::ONE);
    assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
}

#[test]
fn long_sparse_keys_shared_by_many_channels_are_one_error() {
    let many = 1 << 14;
    let mut file = moving("translation", &[0.0, 1.0], &[[0.0; 3]; 2], "LINEAR");
    let (indices, values) = (file.view(bytemuck::cast_slice(&vec![1u32; many])), file.view(&vec![0; 12 * many]));
    file.json["accessors"][2]["sparse"] = json!({
        "count": many,
        "indices": { "bufferView": indices, "componentType": 5125 },
        "values": { "bufferView": values },
    });
    let channel = file.json["animations"][0]["channels"][0].clone();
    file.json["animations"][0]["channels"] = Value::Array(vec![channel; 1 << 12]);
    assert!(error(&file).ends_with("64 times its size"), "{}", error(&file));
}

#[test]
fn no_changed_byte_of_an_animation_makes_the_loader_panic() {
    let none = [0.0; 4];
    let mut file = moving("rotation", &[0.0, 1.0], &[none, turn(0.0), none, none, turn(1.0), none], "CUBICSPLINE");
    let (indices, values) = (file.view(&[1, 0, 0, 0]), file.view(&[0; 16]));
    let part = json!({ "bufferView": indices, "componentType": 5121 });
    file.json["accessors"][2]["sparse"] = json!({ "count": 1, "indices": part, "values": { "bufferView": values } });
    let good = file.glb();
    for at in 0..good.len() {
        for flip in [0x01, 0x10, 0x80] {
            let mut bytes = good.clone();
            bytes[at] ^= flip;
            // Whether it still loads is the file's business: what counts is that the call returns.
            drop(load_bytes_at("flip.glb", &bytes, Some(0.5)));
        }
    }
}

fn sample(name: &str, seconds: f64) -> Option<Description> {
    let path = shared("gltf-samples")?.join(format!("{name}/glTF/{name}.gltf"));
    Some(
        scene_file::load_with(&path, &ReadOptions { seconds: Some(seconds), ..ReadOptions::default() })
            .unwrap_or_else(|e| panic!("{}", e.chain())),
    )
}

/// Its keys are every quarter of a second, a quarter turn about z each.
#[test]
fn the_animated_triangle_turns_once_a_second() {
    for seconds in [0.0, 0.125, 0.25, 0.4, 0.6, 0.9, 1.0, 3.0] {
        let Some(scene) = sample("AnimatedTriangle", seconds) else { return };
        let got = scene.instances[0].transform.matrix3.x_axis;
        // The file has three digits of the half's root.
        assert!((got - angle(2.0 * PI * seconds.min(1.0))).length() < 1e-3, "{seconds}: {got}");
        assert_eq!((scene.animation_end, scene.ignored.len()), (Some(1.0), 0));
    }
}

/// Nine cubes that grow, turn and rise by steps, lines and cubic splines, a quarter of the way from their second key to
/// their third: from half to whole, from −45° to −90°; those that rise have been falling from 10 to 6 for 11/40.
#[test]
fn the_interpolation_test_is_where_its_keys_put_it() {
    let Some(scene) = sample("InterpolationTest", 0.53125) else { return };
    let cube = |name: &str| scene.instances.iter().find(|i| i.name == name).expect("a cube").transform;
    // Keys have 24 bits, and the tangents below four digits.
    let close = |got: f64, want: f64, bound: f64| assert!((got - want).abs() < bound, "{got} is not {want}");
    for (name, want) in [("Cube", 0.5), ("Cube.001", 0.625), ("Cube.002", 0.578_125)] {
        close(cube(name).matrix3.x_axis.x, want, 1e-6);
    }
    let degrees = |name: &str| cube(name).matrix3.x_axis.y.atan2(cube(name).matrix3.x_axis.x).to_degrees();
    close(degrees("Cube.003"), -45.0, 1e-4);
    close(degrees("Cube.005"), -56.25, 1e-4);
    let [from, leaving, arriving, to] =
        [[-0.3827, 0.9239], [-0.0479, 0.9989], [-0.0355, 0.9994], [-FRAC_1_SQRT_2, FRAC_1_SQRT_2]];
    let length = 0.875 - 0.41667;
    let [z, w] = [0, 1]
        .map(|i| 0.84375 * from[i] + 0.15625 * to[i] + length * (0.140_625 * leaving[i] - 0.046_875 * arriving[i]));
    close(degrees("Cube.004"), 2.0 * f64::atan2(z, w).to_degrees(), 1e-2);
    let way: f64 = 11.0 / 40.0;
    for (name, want) in
        [("Cube.006", 10.0), ("Cube.009", 10.0 - 4.0 * way), ("Cube.008", 10.0 - 4.0 * way * way * (3.0 - 2.0 * way))]
    {
        close(cube(name).translation.y, want, 1e-5);
    }
    assert!((scene.animation_end.expect("an end") - 41.0 / 24.0).abs() < 1e-6);
}

/// The Khronos validator's verdict on animations, which is beside each case.
#[test]
fn validator_cases_are_played_or_one_error_and_valid_ones_are_played() {
    let Some(folder) = shared("gltf-validator/test") else { return };
    let cases: Vec<PathBuf> =
        files_below(&folder).into_iter().filter(|p| p.extension().is_some_and(|e| e == "gltf")).collect();
    let mut wrong = Vec::new();
    assert!(BROKEN.iter().all(|end| cases.iter().any(|case| case.ends_with(end))));
    for case in cases.iter().filter(|path| scene_file::load(path).is_ok()) {
        let result =
            catch_unwind(|| scene_file::load_with(case, &ReadOptions { seconds: Some(0.5), ..ReadOptions::default() }))
                .unwrap_or_else(|_| panic!("{} panics", case.display()));
        assert!(result.is_err() || !BROKEN.iter().any(|end| case.ends_with(end)), "{} is played", case.display());
        if let Err(error) = result {
            let chain = error.chain();
            assert!(chain.starts_with(&*case.to_string_lossy()) && !chain.contains('\n'), "{chain}");
            if !REFUSED.iter().any(|end| case.ends_with(end)) && is_valid(case) {
                wrong.push(chain);
            }
        }
    }
    assert!(wrong.is_empty(), "the validator finds no error: {wrong:#?}");
}

/// Files without an error to the validator that are refused all the same.
const REFUSED: [&str; 2] = [
    // Their times have no data, which makes them all zero: they do not ascend.
    "animation/valid.gltf",
    "skin/ignored_animated_transform.gltf",
];

/// Files with errors of the kind that must not be played: the others lack bounds that are not read, or have keys that
/// do no harm.
const BROKEN: [&str; 11] = [
    "animation/channel_node_matrix.gltf",
    "animation/empty_objects.gltf",
    "animation/sampler_input_format_invalid.gltf",
    "animation/sampler_output_count_invalid.gltf",
    "animation/sampler_output_format_invalid.gltf",
    "animation/sampler_too_few_cubic_frames.gltf",
    "animation/unresolved_channel_sampler.gltf",
    "animation/unresolved_channel_target.gltf",
    "animation/unresolved_sampler_input.gltf",
    "animation/unresolved_sampler_output.gltf",
    "animation_data/invalid_input_values.gltf",
];

/// Two animations of one translation, one of which also turns another way.
fn two_clips() -> File {
    let mut file = moving("translation", &[0.0, 1.0], &[[0.0; 3], [1.0, 0.0, 0.0]], "LINEAR");
    let times = floats(&mut file, "SCALAR", &[[0.0], [1.0]]);
    let up = floats(&mut file, "VEC3", &[[0.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
    animate(&mut file, 0, "translation", [times, up], "LINEAR");
    file.json["animations"][0]["name"] = json!("open");
    file.json["animations"][1]["name"] = json!("close");
    file
}

fn clip(file: &File, animation: Option<&str>) -> etendue::error::Result<Description> {
    let reading = ReadOptions { seconds: Some(0.5), animation, ..Default::default() };
    gltf::parse(&file.glb(), std::path::Path::new("nowhere"), &reading)
}

/// A clip is chosen by name or number; without a choice the later of two that move the same is played, and that is
/// said.
#[test]
fn clips_are_named_and_chosen() {
    let file = two_clips();
    let where_is = |animation| clip(&file, animation).expect("a valid file").instances[0].transform.translation;
    assert_eq!(where_is(Some("open")), DVec3::new(0.5, 0.0, 0.0));
    assert_eq!(where_is(Some("close")), DVec3::new(0.0, 1.0, 0.0));
    assert_eq!(where_is(Some("0")), DVec3::new(0.5, 0.0, 0.0));
    assert_eq!(where_is(None), DVec3::new(0.0, 1.0, 0.0));
    let both = clip(&file, None).expect("a valid file");
    assert_eq!(both.animations, ["open", "close"]);
    assert_eq!(file.load().expect("a valid file").animations, ["open", "close"]);
    let said = both.ignored.join(" ");
    let conflict = "animations 'open' and 'close' both move the translation of node";
    assert!(said.contains(conflict) && said.contains("the later one is played: --animation"), "{said}");
    let alone = clip(&file, Some("open")).expect("a valid file").ignored.join(" ");
    assert!(!alone.contains("both move"), "{alone}");
    let error = clip(&file, Some("2")).expect_err("no such clip");
    assert_eq!(error.kind, etendue::error::Kind::Usage);
    assert!(
        error.chain().contains("no animation '2'") && error.chain().contains("0 'open', 1 'close'"),
        "{}",
        error.chain()
    );
}
