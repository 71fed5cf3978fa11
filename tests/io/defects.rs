//! Broken files: each is one clear error, quickly, without taking much memory.

use crate::corpus::files_below;
use crate::support::{File, glb, load_bytes, push, sentence, shared};
use serde_json::{Value, json};
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

#[test]
fn oversized_accessor_is_named_in_the_error() {
    let with = |key: &str, value: Value| {
        let mut file = File::triangle(json!({}));
        file.json["accessors"][0][key] = value;
        file.error()
    };
    let prefix = "mesh 'm': accessor 0: ";
    assert_eq!(with("count", json!(4)), format!("{prefix}4 elements end at byte 48 of a buffer view of 36 bytes"));
    assert!(with("count", json!(u64::MAX)).starts_with(&format!("{prefix}{} elements end at", u64::MAX)));
    assert!(with("count", json!(4_000_000_000u64)).starts_with(prefix));
    assert!(with("byteOffset", json!(u64::MAX)).starts_with(prefix));
    assert!(with("type", json!("VEC2")).starts_with(&format!("{prefix}it has elements of kind Vec2")));
    assert!(with("type", json!("MAT2")).starts_with(prefix));
    assert!(
        with("componentType", json!(5125))
            .starts_with(&format!("{prefix}component type U32, not normalised, is not for POSITION"))
    );
    assert_eq!(with("bufferView", json!(7)), "accessors[0].bufferView refers to something that does not exist");
}

#[test]
fn elements_without_data_are_bounded_by_the_file() {
    let mut file = File::triangle(json!({}));
    let view = file.view(&[0; 12]);
    let sparse = json!({ "count": 1, "indices": { "bufferView": view, "componentType": 5121 }, "values": { "bufferView": view } });
    let zeros = json!({ "componentType": 5126, "type": "VEC3", "count": 4_000_000_000u64, "sparse": sparse });
    let accessor = push(&mut file.json["accessors"], zeros);
    file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(accessor);
    assert!(file.error().contains("accessor 1: 4000000000 elements without data"), "{}", file.error());
    file.json["accessors"][1]["count"] = json!(3);
    file.json["accessors"][1]["sparse"]["count"] = json!(9);
    assert!(file.error().contains("accessor 1: its sparse part: 9 elements end at"), "{}", file.error());
    file.bytes[36] = 200;
    file.json["accessors"][1]["sparse"]["count"] = json!(1);
    assert!(file.error().contains("accessor 1: its sparse part: index 200 is out of range"), "{}", file.error());
}

#[test]
fn views_and_strides_are_checked() {
    let with = |key: &str, value: u64| {
        let mut file = File::triangle(json!({}));
        file.json["bufferViews"][0][key] = json!(value);
        file.error()
    };
    assert!(with("byteLength", 37).contains("buffer view 0: 37 bytes at 0 do not fit into buffer 0 (36 bytes)"));
    assert!(with("byteOffset", u64::MAX).contains("buffer view 0: "));
    assert!(with("byteStride", 8).contains("accessor 0: a stride of 8 bytes is less than an element"));
    assert_eq!(with("byteStride", 3), "bufferViews[0].byteStride has an invalid value");
    assert_eq!(with("buffer", 1), "bufferViews[0].buffer refers to something that does not exist");
}

#[test]
fn indices_out_of_range_are_errors() {
    let file =
        File::mesh(&crate::support::TRIANGLE, |f| json!({ "indices": f.accessor(5121, "SCALAR", 3, &[0, 1, 3]) }));
    assert_eq!(file.error(), "mesh 'm': index 3 is out of range, there are 3 vertices");
    let signed =
        File::mesh(&crate::support::TRIANGLE, |f| json!({ "indices": f.accessor(5122, "SCALAR", 3, &[0; 6]) }));
    assert!(signed.error().contains("accessor 1: I16 Scalar elements are not for indices"));
    let mut absent = File::triangle(json!({}));
    absent.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(99);
    assert!(absent.error().contains("accessor 99, which does not exist"));
}

#[test]
fn attributes_must_be_finite_and_as_many_as_the_vertices() {
    let nan = File::mesh(&[[0.0; 3], [f32::NAN; 3], [0.0; 3]], |_| json!({}));
    assert_eq!(nan.error(), "mesh 'm': accessor 0 has a value that is not finite");
    let few = File::mesh(
        &crate::support::TRIANGLE,
        |f| json!({ "attributes": { "TEXCOORD_0": f.accessor(5126, "VEC2", 2, &[0; 16]) } }),
    );
    assert_eq!(few.error(), "mesh 'm': accessor 1 has 2 elements for 3 vertices");
}

#[test]
fn a_missing_buffer_is_named() {
    let mut file = File::triangle(json!({ "buffers": [{ "byteLength": 36, "uri": "not%20here.bin" }] }));
    let error = file.error();
    assert!(error.starts_with("buffer 0: cannot read ") && error.contains("not here.bin: "), "{error}");
    file.json["buffers"] = json!([{ "byteLength": 36, "uri": "https://example.org/x.bin" }]);
    assert!(file.error().starts_with("buffer 0: the URI scheme 'https:' is not supported"));
    file.json["buffers"] = json!([{ "byteLength": 1_000_000 }]);
    assert_eq!(file.error(), "buffer 0: it claims 1000000 bytes and has 36");
    file.json["buffers"] = json!([{ "byteLength": 36 }]);
    let json = file.json.to_string();
    let without = sentence("scene.glb", load_bytes("scene.glb", &glb(json.as_bytes(), None)));
    assert_eq!(without, "mesh 'm': accessor 0: buffer view 0: buffer 0 has no data");
}

#[test]
fn a_required_extension_that_is_not_read_is_named() {
    let required = ["KHR_draco_mesh_compression", "KHR_materials_ior", "EXT_x"];
    let error = File::triangle(json!({ "extensionsRequired": required, "extensionsUsed": required })).error();
    assert_eq!(error, "the file requires what is not supported: KHR_draco_mesh_compression, EXT_x");
    let used = File::triangle(json!({ "extensionsUsed": required })).load().expect("a valid file");
    assert_eq!(used.ignored, ["KHR_draco_mesh_compression", "EXT_x"].map(|e| format!("the extension {e} is not read")));
}

#[test]
fn inconsistent_glb_containers_are_errors() {
    let good = File::triangle(json!({})).glb();
    for cut in 0..good.len() {
        sentence("cut.glb", load_bytes("cut.glb", &good[..cut]));
    }
    let with_word = |at: usize, word: u32| {
        let mut bytes = good.clone();
        bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
        sentence("lie.glb", load_bytes("lie.glb", &bytes))
    };
    assert!(with_word(4, 1).contains("version 1"));
    assert!(with_word(8, 0).contains("claims 0 bytes"));
    assert!(with_word(8, u32::MAX).contains("claims 4294967295 bytes"));
    assert!(with_word(12, u32::MAX).contains("cut off"));
    assert!(with_word(16, 0).contains("not JSON"));
}

#[test]
fn no_changed_byte_makes_the_loader_panic() {
    let mut file =
        File::mesh(&crate::support::TRIANGLE, |f| json!({ "indices": f.accessor(5121, "SCALAR", 3, &[0, 1, 2]) }));
    let view = file.view(&[1, 0, 0, 0]);
    let part = json!({ "bufferView": view, "componentType": 5121 });
    file.json["accessors"][0]["sparse"] = json!({ "count": 1, "indices": part, "values": { "bufferView": 0 } });
    let good = file.glb();
    assert!(file.load().is_ok());
    for at in 0..good.len() {
        for flip in [0x01, 0x10, 0x80] {
            let mut bytes = good.clone();
            bytes[at] ^= flip;
            // Whether it still loads is the file's business: what counts is that the call returns.
            drop(load_bytes("flip.glb", &bytes));
        }
    }
}

#[test]
fn text_that_is_not_gltf_says_where() {
    let error = |text: &str| sentence("s.gltf", load_bytes("s.gltf", text.as_bytes()));
    assert!(error("{ \"asset\": ").contains("line 1"));
    assert!(error(&"[".repeat(100_000)).contains("recursion limit"));
    assert!(error("{ \"asset\": { \"version\": \"2.0\" },\n \"nodes\": [{ \"mesh\": \"x\" }] }").contains("line 2"));
    assert!(error("{ \"asset\": { \"version\": \"1.0\" } }").contains("glTF version is 1.0"));
    assert!(error("[]").contains("version is missing"));
}

/// The Khronos validator's own cases, of which half are broken on purpose, with its verdict beside each.
#[test]
fn every_validator_case_loads_or_is_one_error_and_valid_ones_load() {
    let Some(folder) = shared("gltf-validator/test") else { return };
    let is_gltf = |path: &PathBuf| path.extension().is_some_and(|e| e == "gltf" || e == "glb");
    let cases: Vec<PathBuf> = files_below(&folder).into_iter().filter(is_gltf).collect();
    assert!(cases.len() > 300, "{} cases", cases.len());
    let mut wrongly_refused = Vec::new();
    for case in cases {
        let start = Instant::now();
        let result = catch_unwind(|| etendue::io::scene_file::load(&case))
            .unwrap_or_else(|_| panic!("{} panics", case.display()));
        // The largest case has some kilobytes; this is to find what never ends.
        assert!(start.elapsed() < Duration::from_secs(10), "{} takes too long", case.display());
        if let Err(error) = result {
            let chain = error.chain();
            assert!(chain.starts_with(&*case.to_string_lossy()) && !chain.contains('\n'), "{chain}");
            let refused =
                REFUSED.iter().any(|end| case.ends_with(end)) || chain.contains("requires what is not supported");
            if !refused && is_valid(&case) {
                wrongly_refused.push(chain);
            }
        }
    }
    assert!(wrongly_refused.is_empty(), "the validator finds no error: {wrongly_refused:#?}");
}

/// Files without an error to the validator that are refused all the same.
const REFUSED: [&str; 6] = [
    // Requires glTF 2.1.
    "asset/min_version_valid.gltf",
    // The mesh in the scene has a buffer without data.
    "root/unused_objects.gltf",
    "root/named_objects.gltf",
    // Lies on the network.
    "buffer/non_relative_uri.gltf",
    // Types that no specification has.
    "accessor/unknown_type.gltf",
    "light/unknown_type.gltf",
];

pub(crate) fn is_valid(case: &Path) -> bool {
    let report = PathBuf::from(format!("{}.report.json", case.display()));
    let Ok(text) = std::fs::read(report) else { return false };
    let report: Value = serde_json::from_slice(&text).expect("a report");
    report["issues"]["numErrors"] == 0
}

/// What writers leave around the JSON though the specification forbids it is read, and noted; UTF-16 is named.
#[test]
fn zeros_and_byte_order_marks_around_the_json_are_noted() {
    let mut file = File::triangle(json!({}));
    file.json["buffers"] = json!([{ "byteLength": file.bytes.len() }]);
    let json = file.json.to_string();
    let marked = [b"\xef\xbb\xbf", json.as_bytes()].concat();
    // To a multiple of four, which needs no spaces after it.
    let padded = [json.as_bytes(), &vec![0; 8 - json.len() % 4][..]].concat();
    for (bytes, what) in [(&marked, "byte order mark"), (&padded, "padded with zeros")] {
        let loaded = load_bytes("odd.glb", &glb(bytes, Some(&file.bytes))).expect("a valid file");
        assert!(loaded.ignored.iter().any(|note| note.contains(what)), "{:?}", loaded.ignored);
    }
    let text = json!({ "asset": { "version": "2.0" } }).to_string();
    let loaded = load_bytes("odd.gltf", &[b"\xef\xbb\xbf", text.as_bytes()].concat()).expect("a valid file");
    assert!(loaded.ignored[0].contains("byte order mark"));
    let wide: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert!(sentence("wide.gltf", load_bytes("wide.gltf", &[&[0xff, 0xfe], &wide[..]].concat())).contains("UTF-16"));
}
