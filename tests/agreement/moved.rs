//! The scenes in scenes/ below another root node: moved by 1e6, scaled by 1e-4 and 1e4. The camera goes along, and the
//! intensities of point lights grow with the square of the scale, so that the picture must stay.
//!
//! The same seed takes the same decisions at every vertex unless rounding tips one over; what is measured is how often.
//! A path that tips over is one sample of noise and no error, but it moves its pixel by more than 1e-3.

use crate::picture::{BLOCK_LEVEL, Picture, Shot, limit_at, render};
use etendue::accel::Backend;
use etendue::integrator::Method;
use etendue::io::scene_file;
use etendue::scene::{BuildOptions, Scene};
use etendue_testing::deep;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Blocks of 8 × 8 pixels.
const BLOCK: usize = 8;

/// What the root node does.
#[derive(Debug, Clone, Copy)]
enum Root {
    Translated(f64),
    Scaled(f64),
}

const ROOTS: [Root; 3] = [Root::Translated(1e6), Root::Scaled(1e-4), Root::Scaled(1e4)];

impl Root {
    /// `document` with this node above all others.
    fn above(self, mut document: Value) -> Value {
        let roots = document["scenes"][0]["nodes"].take();
        let mut node = json!({ "name": "root", "children": roots });
        match self {
            Root::Translated(x) => node["translation"] = json!([x, -2.0 * x, 0.5 * x]),
            Root::Scaled(s) => {
                node["scale"] = json!([s, s, s]);
                let lights = document.pointer_mut("/extensions/KHR_lights_punctual/lights");
                for light in lights.and_then(Value::as_array_mut).into_iter().flatten() {
                    light["intensity"] = json!(light["intensity"].as_f64().expect("an intensity") * s * s);
                }
            }
        }
        let nodes = document["nodes"].as_array_mut().expect("nodes");
        nodes.push(node);
        document["scenes"][0]["nodes"] = json!([nodes.len() - 1]);
        document
    }
}

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name)
}

/// The glTF document of a scene; `None` if it was not generated (`make scenes`).
fn document(name: &str) -> Option<Value> {
    let text = std::fs::read_to_string(folder(name).join("scene.gltf"));
    assert!(text.is_ok() || !deep(), "{name} is missing: run `make scenes`");
    Some(serde_json::from_str(&text.ok()?).expect("JSON"))
}

/// The Cornell box with two point lights in place of its lamp.
fn with_point_lights(mut document: Value) -> Value {
    let lamp = document["nodes"].as_array().expect("nodes").iter().position(|n| n["name"] == "light").expect("a lamp");
    document["nodes"][lamp] = json!({
        "name": "light", "translation": [0.3, 1.7, 0.4], "extensions": { "KHR_lights_punctual": { "light": 0 } }
    });
    let kind = json!({ "type": "point", "intensity": 2.0, "color": [1.0, 0.8, 0.5] });
    document["extensions"] = json!({ "KHR_lights_punctual": { "lights": [kind] } });
    document["extensionsUsed"].as_array_mut().expect("extensions").push(json!("KHR_lights_punctual"));
    document
}

/// `document`, whose buffers lie in `home`, through the loader.
fn load(document: &Value, home: &Path, backend: Backend) -> Scene {
    let temporary = tempfile::tempdir().expect("a folder");
    std::fs::copy(home.join("scene.bin"), temporary.path().join("scene.bin")).expect("copied");
    let path = temporary.path().join("scene.gltf");
    std::fs::write(&path, document.to_string()).expect("written");
    let description = scene_file::load(&path).expect("a valid scene");
    Scene::build(description, &BuildOptions { backend, threads: 1, ..BuildOptions::default() }).expect("a valid scene")
}

/// How far a picture is from the one it should equal.
#[derive(Debug)]
struct Distance {
    /// Share of pixels that differ by more than 1e-3 in a lane.
    pixels: f64,
    /// Largest |z| of a block's lane.
    block: f64,
    /// Relative difference of the means.
    mean: f64,
}

impl Distance {
    fn between(a: &Picture, b: &Picture) -> Self {
        let differ = |(a, b): (&[f64], &[f64])| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1e-3 * a.abs()); // the issue's
        let pixels = a.mean.chunks(3).zip(b.mean.chunks(3)).filter(|&p| differ(p)).count();
        let n = a.side / BLOCK;
        let z = a.blocks(n).into_iter().zip(b.blocks(n)).map(|(a, b)| a.z(b).abs());
        Distance {
            pixels: pixels as f64 / (a.side * a.side) as f64,
            block: z.fold(0.0, f64::max),
            mean: b.overall().mean / a.overall().mean - 1.0,
        }
    }

    /// 99.9 % of pixels within 1e-3, every block within Šidák's limit at level 1e-3, the mean within 1e-4.
    fn is_small(&self, side: usize) -> bool {
        let blocks = (side / BLOCK).pow(2) * 3;
        self.pixels <= 1e-3 && self.block <= limit_at(BLOCK_LEVEL, blocks) && self.mean.abs() <= 1e-4 // the figures
    }
}

fn shot() -> Shot {
    let (side, spp) = if deep() { (128, 256) } else { (64, 64) };
    Shot { depth: Some(64), ..Shot::new(Method::Path, side, spp) }
}

fn stays(name: &str, document: &Value, home: &Path) {
    for &backend in Backend::AVAILABLE {
        let here = render(&load(document, home, backend), shot());
        for root in ROOTS {
            let there = render(&load(&root.above(document.clone()), home, backend), shot());
            let distance = Distance::between(&here, &there);
            println!("{name} {backend:?} {root:?}: {distance:?}");
            assert!(distance.is_small(here.side), "{name} {backend:?} {root:?}: {distance:?}");
        }
    }
}

#[test]
fn cornell_box_is_invariant_under_translation_and_scale() {
    stays("cornell-box", &document("cornell-box").expect("committed"), &folder("cornell-box"));
}

#[test]
fn point_lit_room_is_invariant_under_translation_and_scale() {
    let room = with_point_lights(document("cornell-box").expect("committed"));
    stays("point lights", &room, &folder("cornell-box"));
}

#[test]
fn mirror_and_glass_balls_are_invariant_under_translation_and_scale() {
    for name in ["modified-cornell", "glass-caustic"] {
        if let Some(document) = document(name) {
            stays(name, &document, &folder(name));
        }
    }
}

/// Without the square of the scale, or with a mean off by 2e-4, the comparison fails.
#[test]
fn the_comparison_convicts_a_wrong_picture() {
    let room = with_point_lights(document("cornell-box").expect("committed"));
    let home = folder("cornell-box");
    let scene = |document: &Value| load(document, &home, Backend::default());
    let here = render(&scene(&room), Shot { spp: 16, ..shot() });
    let mut dim = Root::Scaled(1e-4).above(room);
    dim["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = json!(2.0);
    let there = render(&scene(&dim), Shot { spp: 16, ..shot() });
    assert!(!Distance::between(&here, &there).is_small(here.side));
    assert!(Distance::between(&here, &here).is_small(here.side));
    let side = here.side;
    let brighter = Picture { mean: here.mean.iter().map(|m| m * (1.0 + 2e-4)).collect(), ..here.clone() }; // twice the limit
    assert!(!Distance::between(&here, &brighter).is_small(side));
}
