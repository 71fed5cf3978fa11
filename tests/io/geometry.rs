//! Accessors and primitives.

use crate::support::{File, TRIANGLE, load_bytes, push};
use glam::{Vec2, Vec3, Vec4};
use serde_json::json;

const QUAD: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];

/// The z components of the (unnormalised) normals: the sign is the orientation.
fn normals_z(file: &File) -> Vec<f32> {
    let p = file.primitive();
    let corner = |i: u32| p.positions[i as usize];
    p.triangles.iter().map(|&[a, b, c]| (corner(b) - corner(a)).cross(corner(c) - corner(a)).z).collect()
}

#[test]
fn every_triangle_of_a_strip_faces_the_same_way() {
    assert_eq!(normals_z(&File::mesh(&QUAD, |_| json!({ "mode": 5 }))), [1.0, 1.0]);
}

#[test]
fn every_triangle_of_a_fan_faces_the_same_way() {
    let around = [QUAD[0], QUAD[1], QUAD[3], QUAD[2]];
    assert_eq!(normals_z(&File::mesh(&around, |_| json!({ "mode": 6 }))), [1.0, 1.0]);
}

#[test]
fn indexed_strips_drop_triangles_without_area() {
    let indices = [0u8, 1, 2, 2, 1, 3];
    let strip = File::mesh(&QUAD, |f| json!({ "mode": 5, "indices": f.accessor(5121, "SCALAR", 6, &indices) }));
    // (0 1 2), then (1 2 2) and (2 2 1) dropped, then the fourth, odd: (2 1 3) turned round.
    assert_eq!(strip.primitive().triangles, [[0, 1, 2], [2, 3, 1]]);
}

#[test]
fn points_and_lines_are_left_out_and_said() {
    for mode in 0..4 {
        let description = File::mesh(&QUAD, |_| json!({ "mode": mode })).load().expect("a valid file");
        assert!(description.meshes.is_empty() && description.instances.is_empty());
        assert_eq!(description.ignored, ["mesh 'm' has points or lines, which are left out"]);
    }
}

#[test]
fn a_primitive_without_positions_is_left_out_and_said() {
    let mut file = File::triangle(json!({}));
    file.json["meshes"][0]["primitives"][0]["attributes"] = json!({});
    let description = file.load().expect("a valid file");
    assert!(description.meshes.is_empty());
    assert_eq!(description.ignored, ["mesh 'm' has a part without positions, which is left out"]);
}

#[test]
fn normalised_integers_reach_both_ends_of_their_range() {
    let bytes: [i8; 12] = [127, -127, -128, 0, 0, 127, -1, 1, 64, 0, 127, 0];
    let positions = |normalized: bool| {
        let file = File::mesh(&TRIANGLE, |f| {
            // Rows of three bytes are padded to four.
            let padded: Vec<u8> =
                bytes.chunks(3).take(3).flat_map(|v| [v[0] as u8, v[1] as u8, v[2] as u8, 0]).collect();
            let accessor = f.accessor(5120, "VEC3", 3, &padded);
            let view = f.json["accessors"][accessor]["bufferView"].as_u64().expect("a view") as usize;
            f.json["bufferViews"][view]["byteStride"] = json!(4);
            f.json["accessors"][accessor]["normalized"] = json!(normalized);
            json!({ "attributes": { "POSITION": accessor } })
        });
        file.primitive().positions
    };
    assert_eq!(
        positions(true),
        [[1.0, -1.0, -1.0], [0.0, 0.0, 1.0], [-1.0 / 127.0, 1.0 / 127.0, 64.0 / 127.0]].map(Vec3::from)
    );
    assert_eq!(positions(false), [[127.0, -127.0, -128.0], [0.0, 0.0, 127.0], [-1.0, 1.0, 64.0]].map(Vec3::from));
}

#[test]
fn texture_coordinates_and_colours_may_be_integers() {
    let uvs = [0u16, 65535, 13107, 0, 0, 0];
    let colors = [255u8, 0, 51, 0, 255, 255, 255, 0, 0, 0, 0, 0];
    let file = File::mesh(&TRIANGLE, |f| {
        let uv = f.accessor(5123, "VEC2", 3, bytemuck::cast_slice(&uvs));
        let color = f.accessor(5121, "VEC3", 3, &colors);
        let view = f.json["accessors"][color]["bufferView"].as_u64().expect("a view") as usize;
        f.json["bufferViews"][view]["byteStride"] = json!(4);
        [uv, color].into_iter().for_each(|a| f.json["accessors"][a]["normalized"] = json!(true));
        json!({ "attributes": { "TEXCOORD_1": uv, "COLOR_0": color } })
    });
    let primitive = file.primitive();
    assert_eq!(primitive.uvs[0], None);
    assert_eq!(primitive.uvs[1], Some(vec![Vec2::new(0.0, 1.0), Vec2::new(0.2, 0.0), Vec2::ZERO]));
    let colors = primitive.colors.expect("colours");
    assert_eq!(colors[..2], [Vec4::new(1.0, 0.0, 0.2, 1.0), Vec4::new(1.0, 1.0, 1.0, 1.0)]);
}

#[test]
fn sets_beyond_those_that_are_read_are_said() {
    let file = File::mesh(&TRIANGLE, |f| {
        let uv = f.accessor(5126, "VEC2", 3, &[0; 24]);
        json!({ "attributes": { "TEXCOORD_2": uv, "TEXCOORD_3": uv }, "targets": [{ "POSITION": 0 }] })
    });
    let ignored = file.load().expect("a valid file").ignored;
    assert_eq!(
        ignored,
        [
            "texture coordinate set 2 is not read",
            "texture coordinate set 3 is not read",
            "morph targets are not read: the meshes are shown as modelled"
        ]
    );
}

#[test]
fn normals_are_normalised_and_zero_becomes_the_geometric_normal() {
    let normals = [[0.0f32, 3.0, 4.0], [0.0, 0.0, 0.0], [0.0, 0.0, 2.0]];
    let file = File::mesh(&TRIANGLE, |f| {
        let normal = f.accessor(5126, "VEC3", 3, bytemuck::cast_slice(&normals));
        json!({ "attributes": { "NORMAL": normal } })
    });
    let normals = file.primitive().normals.expect("normals");
    assert!((normals[0] - Vec3::new(0.0, 0.6, 0.8)).length() <= 2.0 * f32::EPSILON);
    assert_eq!(normals[1..], [Vec3::Z, Vec3::Z]);
    assert_eq!(File::triangle(json!({})).primitive().normals, None);
}

#[test]
fn a_sparse_accessor_without_data_starts_from_zero() {
    let mut file = File::triangle(json!({}));
    let indices = file.view(&[1, 2]);
    let values = file.view(bytemuck::cast_slice(&[[5.0f32, 0.0, 0.0], [0.0, 7.0, 0.0]]));
    let sparse = json!({ "count": 2, "indices": { "bufferView": indices, "componentType": 5121 }, "values": { "bufferView": values } });
    let positions = json!({ "componentType": 5126, "type": "VEC3", "count": 3, "sparse": sparse });
    let accessor = push(&mut file.json["accessors"], positions);
    file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(accessor);
    assert_eq!(file.primitive().positions, [Vec3::ZERO, Vec3::X * 5.0, Vec3::Y * 7.0]);
}

#[test]
fn vertices_that_no_triangle_uses_are_dropped() {
    let indices = [3u32, 1, 2];
    let file =
        File::mesh(&QUAD, |f| json!({ "indices": f.accessor(5125, "SCALAR", 3, bytemuck::cast_slice(&indices)) }));
    let primitive = file.primitive();
    assert_eq!(primitive.positions, [QUAD[1], QUAD[2], QUAD[3]].map(Vec3::from));
    assert_eq!(primitive.triangles, [[2, 0, 1]]);
}

#[test]
fn buffers_may_be_data_uris() {
    // Nine floats: 0 0 0, 1 0 0, 0 1 0.
    let data = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    let mut file = File::triangle(json!({}));
    file.json["buffers"] = json!([{ "byteLength": 36, "uri": format!("data:application/octet-stream;base64,{data}") }]);
    let mut description = load_bytes("scene.gltf", file.json.to_string().as_bytes()).expect("a valid file");
    assert_eq!(description.meshes.remove(0).primitives.remove(0).positions, TRIANGLE.map(Vec3::from));
}

#[test]
fn quantised_positions_are_read_though_the_extension_is_required() {
    let required =
        json!({ "extensionsRequired": ["KHR_mesh_quantization"], "extensionsUsed": ["KHR_mesh_quantization"] });
    let description = File::triangle(required).load().expect("a valid file");
    assert!(description.ignored.is_empty());
}

/// A triangle whose `attribute`, of `shape`, has components of `component`: nine bytes each, all zero but the last bit.
fn with_type(attribute: &str, shape: &str, component: u32, normalized: bool) -> File {
    File::mesh(&TRIANGLE, |f| {
        let accessor = f.accessor(component, shape, 3, &[0; 3 * 4 * 4]);
        f.json["accessors"][accessor]["normalized"] = json!(normalized);
        json!({ "attributes": { attribute: accessor } })
    })
}

/// The table of KHR_mesh_quantization and, for colours, that of the specification.
#[test]
fn every_attribute_has_the_types_of_the_table_and_no_others() {
    let [i8, u8, i16, u16, u32, f32] = [5120, 5121, 5122, 5123, 5125, 5126];
    let integers =
        [(i8, false), (i8, true), (u8, false), (u8, true), (i16, false), (i16, true), (u16, false), (u16, true)];
    let signed_units = [(i8, true), (i16, true)];
    let unsigned_units = [(u8, true), (u16, true)];
    for (attribute, shape, allowed) in [
        ("POSITION", "VEC3", &integers[..]),
        ("NORMAL", "VEC3", &signed_units[..]),
        ("TANGENT", "VEC4", &signed_units[..]),
        ("TEXCOORD_0", "VEC2", &integers[..]),
        ("TEXCOORD_1", "VEC2", &integers[..]),
        ("COLOR_0", "VEC4", &unsigned_units[..]),
    ] {
        for (component, normalized) in integers.into_iter().chain([(u32, false), (u32, true), (f32, false)]) {
            let mut file = with_type(attribute, shape, component, normalized);
            // Tangents are looked at where there are normals.
            if attribute == "TANGENT" {
                let normals = file.accessor(f32, "VEC3", 3, &[0; 36]);
                file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
            }
            let right = component == f32 || allowed.contains(&(component, normalized));
            assert_eq!(file.load().is_ok(), right, "{attribute} {component} {normalized}");
            if !right {
                assert!(file.error().ends_with(&format!("is not for {attribute}")), "{}", file.error());
            }
        }
    }
}

#[test]
fn quantised_normals_and_tangents_have_their_values() {
    let normals: [i8; 12] = [0, 0, 127, 0, 127, 0, 0, 0, 0, -128, 0, 0];
    let tangents: [i16; 12] = [32767, 0, 0, 32767, 0, 0, -32768, -32767, -32767, 0, 0, -1];
    let file = File::mesh(&TRIANGLE, |f| {
        let normal = f.accessor(5120, "VEC3", 3, bytemuck::cast_slice(&normals));
        let view = f.json["accessors"][normal]["bufferView"].as_u64().expect("a view") as usize;
        f.json["bufferViews"][view]["byteStride"] = json!(4);
        let tangent = f.accessor(5122, "VEC4", 3, bytemuck::cast_slice(&tangents));
        [normal, tangent].into_iter().for_each(|a| f.json["accessors"][a]["normalized"] = json!(true));
        json!({ "attributes": { "NORMAL": normal, "TANGENT": tangent } })
    });
    let primitive = file.primitive();
    assert_eq!(primitive.normals, Some(vec![Vec3::Z, Vec3::X, Vec3::NEG_Y]));
    let tangents = [Vec3::X.extend(1.0), Vec3::NEG_Z.extend(-1.0), Vec3::NEG_X.extend(-1.0)];
    assert_eq!(primitive.tangents, Some(tangents.to_vec()));
}

/// Bytes and shorts as they are, not normalised, as texture coordinates that a KHR_texture_transform scales down.
#[test]
fn quantised_texture_coordinates_may_be_whole_numbers() {
    let uvs: [i8; 12] = [0, 127, 0, 0, -128, 5, 0, 0, 1, 2, 0, 0];
    let file = File::mesh(&TRIANGLE, |f| {
        let uv = f.accessor(5120, "VEC2", 3, bytemuck::cast_slice(&uvs));
        let view = f.json["accessors"][uv]["bufferView"].as_u64().expect("a view") as usize;
        f.json["bufferViews"][view]["byteStride"] = json!(4);
        json!({ "attributes": { "TEXCOORD_0": uv } })
    });
    assert_eq!(file.primitive().uvs[0], Some([[0.0, 127.0], [-128.0, 5.0], [1.0, 2.0]].map(Vec2::from).to_vec()));
}

/// Vertex 0 is not used, so that vertex 3 is the third that is kept; it is displaced, and so is vertex 0.
#[test]
fn sparse_elements_find_their_vertices_among_those_that_are_used() {
    let file = File::mesh(&QUAD, |f| {
        let places = f.view(&[0, 3]);
        let values = f.view(bytemuck::cast_slice(&[[7.0f32; 3], [8.0, 9.0, 1.0]]));
        f.json["accessors"][0]["sparse"] = json!({
            "count": 2,
            "indices": { "bufferView": places, "componentType": 5121 },
            "values": { "bufferView": values },
        });
        json!({ "indices": f.accessor(5121, "SCALAR", 3, &[1, 2, 3]) })
    });
    let displaced = Vec3::new(8.0, 9.0, 1.0);
    assert_eq!(file.primitive().positions, [Vec3::from(QUAD[1]), Vec3::from(QUAD[2]), displaced]);
}
