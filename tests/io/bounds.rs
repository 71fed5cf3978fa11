//! What a file may unfold to is bounded by its size: sharing is cheap where it can be, and one error where it cannot.

use crate::support::{File, TRIANGLE, sentence};
use etendue::error::Kind;
use glam::Vec3;
use serde_json::{Value, json};
use std::sync::Arc;

/// Many vertices, of which the first three are a triangle.
fn long(vertices: usize) -> Vec<[f32; 3]> {
    (0..vertices).map(|i| TRIANGLE[i % 3]).collect()
}

/// A file whose mesh is `copies` of one primitive over `vertices` vertices.
fn repeated(vertices: usize, copies: usize, more: impl FnOnce(&mut File) -> Value) -> File {
    let mut file = File::mesh(&long(vertices), more);
    let part = file.json["meshes"][0]["primitives"][0].clone();
    file.json["meshes"][0]["primitives"] = Value::Array(vec![part; copies]);
    file
}

const TOO_MUCH: &str = "the file unfolds to more than 67108864 bytes and 64 times its size";

#[test]
fn primitives_that_share_a_long_accessor_read_what_they_use() {
    // Read in full by each, these are 48 GB.
    let file = repeated(1 << 18, 1 << 14, |f| json!({ "indices": f.accessor(5121, "SCALAR", 3, &[0, 1, 2]) }));
    let description = file.load().expect("a valid file");
    assert_eq!(description.meshes[0].primitives.len(), 1 << 14);
    assert!(description.meshes[0].primitives.iter().all(|p| p.positions == TRIANGLE.map(Vec3::from)));
}

#[test]
fn copies_beyond_the_budget_are_one_error() {
    assert!(repeated(3000, 10, |_| json!({})).load().is_ok());
    assert_eq!(repeated(3000, 3000, |_| json!({})).error(), format!("mesh 'm': {TOO_MUCH}"));
}

#[test]
fn long_sparse_parts_shared_by_many_are_one_error() {
    let many = 1 << 14;
    let file = repeated(3, 1 << 12, |f| {
        let indices = f.view(bytemuck::cast_slice(&vec![2u32; many]));
        let values = f.view(bytemuck::cast_slice(&long(many)));
        f.json["accessors"][0]["sparse"] = json!({
            "count": many,
            "indices": { "bufferView": indices, "componentType": 5125 },
            "values": { "bufferView": values },
        });
        json!({})
    });
    assert_eq!(file.error(), format!("mesh 'm': accessor 0: its sparse part: {TOO_MUCH}"));
}

#[test]
fn parts_at_places_are_bounded_and_so_are_lights() {
    let nodes = |file: &mut File, count: usize| file.json["nodes"] = Value::Array(vec![json!({ "mesh": 0 }); count]);
    let mut parts = repeated(3, 2000, |_| json!({}));
    nodes(&mut parts, 2000);
    assert!(parts.error().ends_with(TOO_MUCH), "{}", parts.error());
    nodes(&mut parts, 100);
    assert_eq!(parts.load().expect("a valid file").instances.len(), 100);
    let mut lights = File::mesh(&long(3000), |_| json!({ "material": 0 }));
    lights.json["materials"] = json!([{ "emissiveFactor": [0, 0, 0] }]);
    nodes(&mut lights, 2000);
    assert!(lights.load().is_ok());
    lights.json["materials"] = json!([{ "emissiveFactor": [0, 0, 1] }]);
    // Two million lights: bounded by the memory to be had, whatever the file's size, and the mesh that makes them is
    // named.
    assert!(lights.load().is_ok());
    let error = with_memory(&lights, 500_000_000).expect_err("too many");
    assert_eq!(error.kind, Kind::Memory);
    let what = "2000000 emitting triangles would take 0.51 GB as lights and 0.50 GB are available: 1000 of mesh 'm' emit at each of 2000";
    assert!(error.chain().contains(what) && error.chain().contains("--memory"), "{}", error.chain());
}

/// What the loader says to a file with so many bytes of memory.
fn with_memory(file: &File, memory: u64) -> etendue::error::Result<etendue::scene::description::Description> {
    let reading = etendue::io::scene_file::ReadOptions { memory, ..Default::default() };
    etendue::io::gltf::parse(&file.glb(), std::path::Path::new("nowhere"), &reading)
}

#[test]
fn names_are_cut_and_stay_on_one_line() {
    let mut file = File::triangle(json!({}));
    file.json["meshes"][0]["name"] = json!(format!("a\n\u{1b}[31m{}", "é".repeat(1000)));
    let description = file.load().expect("a valid file");
    let name = &description.meshes[0].name;
    assert!(name.starts_with("a  [31mé") && name.chars().count() == 256, "{name}");
    file.json["accessors"][0]["count"] = json!(9);
    assert!(file.error().len() < 1000);
}

#[test]
fn buffers_in_one_file_share_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("a.bin"), bytemuck::cast_slice::<f32, u8>(TRIANGLE.as_flattened()))
        .expect("written");
    let mut file = File::triangle(json!({}));
    // A thousand buffers of different lengths, by two names of one file; the last is the one that is used.
    let buffer = |i: usize| {
        let (length, uri) = (if i == 999 { 36 } else { 1 + i % 36 }, if i % 2 == 0 { "a.bin" } else { "./a.bin" });
        json!({ "byteLength": length, "uri": uri })
    };
    file.json["buffers"] = (0..1000).map(buffer).collect();
    file.json["bufferViews"][0]["buffer"] = json!(999);
    let path = folder.path().join("scene.gltf");
    let load = |file: &File| {
        std::fs::write(&path, file.json.to_string()).expect("a written file");
        etendue::io::scene_file::load(&path)
    };
    assert_eq!(load(&file).expect("valid").meshes[0].primitives[0].positions, TRIANGLE.map(Vec3::from));
    file.json["bufferViews"][0]["buffer"] = json!(998);
    let error = sentence("scene.gltf", load(&file));
    assert!(error.ends_with("buffer view 0: 36 bytes at 0 do not fit into buffer 998 (27 bytes)"), "{error}");
}

/// The contents of an image file of 8 × 8 grey texels.
fn encoded(format: image::ImageFormat) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::GrayImage::from_pixel(8, 8, image::Luma([128])).write_to(&mut bytes, format).expect("encoded");
    bytes.into_inner()
}

/// A triangle with one emissive texture for each of `images`.
fn textured(images: &[Value], file: impl FnOnce(&mut File)) -> File {
    let mut scene = File::triangle(json!({ "images": images }));
    file(&mut scene);
    let count = images.len();
    scene.json["textures"] = (0..count).map(|i| json!({ "source": i })).collect();
    scene.json["materials"] = (0..count).map(|i| json!({ "emissiveTexture": { "index": i } })).collect();
    let part = scene.json["meshes"][0]["primitives"][0].clone();
    let with = |i: usize| {
        let mut part = part.clone();
        part["material"] = json!(i);
        part
    };
    scene.json["meshes"][0]["primitives"] = (0..count).map(with).collect();
    scene
}

#[test]
fn image_entries_of_the_same_bytes_are_decoded_once() {
    let file = textured(&vec![json!({ "bufferView": 1 }); 3], |f| {
        f.view(&encoded(image::ImageFormat::Jpeg));
    });
    let images = file.load().expect("a valid file").images;
    assert!(images.iter().all(|image| Arc::ptr_eq(image, &images[0])), "{images:?}");
    // One level of quantisation of the DC coefficient at the encoder's quality.
    let [grey, ..] = images[0].texel(3, 3, etendue::texture::Encoding::Linear);
    assert!((grey * 255.0 - 128.0).abs() <= 4.0, "{grey}");
}

#[test]
fn images_that_claim_more_than_the_memory_are_refused_by_their_headers() {
    let side = 30_000u16.to_be_bytes();
    let mut png = encoded(image::ImageFormat::Png);
    [18, 22].into_iter().for_each(|at| png[at..at + 2].copy_from_slice(&side));
    let crc = crate::materials::crc32(&png[12..29]);
    png[29..33].copy_from_slice(&crc.to_be_bytes());
    let mut jpeg = encoded(image::ImageFormat::Jpeg);
    let frame = jpeg.windows(2).position(|w| w == [0xff, 0xc0]).expect("a frame header") + 5;
    [frame, frame + 2].into_iter().for_each(|at| jpeg[at..at + 2].copy_from_slice(&side));
    for bytes in [png, jpeg] {
        let file = textured(&[json!({ "bufferView": 1 })], |f| {
            f.view(&bytes);
        });
        let error = with_memory(&file, 4_000_000_000).expect_err("too large");
        assert_eq!(error.kind, Kind::Memory);
        let what = "decoding the images would take 4.50 GB and 4.00 GB are available: the largest is 'image 0' with 30000×30000 texels";
        assert!(error.chain().contains(what) && error.chain().contains("--memory"), "{}", error.chain());
    }
}

#[test]
fn a_png_of_one_colour_is_read() {
    let mut bytes = std::io::Cursor::new(Vec::new());
    // As well as deflate can do: 4 million texels of one bit's worth of news.
    let white = image::GrayImage::from_pixel(2048, 2048, image::Luma([255]));
    let best = image::codecs::png::CompressionType::Best;
    let encoder = image::codecs::png::PngEncoder::new_with_quality(&mut bytes, best, Default::default());
    white.write_with_encoder(encoder).expect("encoded");
    let file = textured(&[json!({ "bufferView": 1 })], |f| {
        f.view(bytes.get_ref());
    });
    assert_eq!(file.load().expect("a valid file").images[0].size(), [2048, 2048]);
}
