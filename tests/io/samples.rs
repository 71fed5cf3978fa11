//! The Khronos sample models, where the shared folder has them.

use crate::materials::model;
use crate::support::shared;
use etendue::io::scene_file;
use etendue::scene::description::{Description, Projection};
use etendue::texture::Wrap;
use glam::{DVec3, Vec3};
use std::path::PathBuf;

fn samples() -> Vec<PathBuf> {
    let Some(folder) = shared("gltf-samples") else { return Vec::new() };
    let folders = std::fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path());
    folders.filter(|p| p.join("glTF").is_dir()).collect()
}

fn sample(name: &str) -> Option<Description> {
    let path = shared("gltf-samples")?.join(format!("{name}/glTF/{name}.gltf"));
    Some(scene_file::load(&path).unwrap_or_else(|e| panic!("{}", e.chain())))
}

fn triangles(description: &Description) -> usize {
    description.meshes.iter().flat_map(|m| &m.primitives).map(|p| p.triangles.len()).sum()
}

#[test]
fn every_sample_loads_with_consistent_contents() {
    for folder in samples() {
        let name = folder.file_name().expect("a name").to_string_lossy().into_owned();
        let Some(scene) = sample(&name) else { continue };
        assert!(triangles(&scene) > 0 && !scene.instances.is_empty(), "{name}");
        assert!(scene.instances.iter().all(|i| i.mesh < scene.meshes.len()), "{name}");
        for primitive in scene.meshes.iter().flat_map(|m| &m.primitives) {
            let vertices = primitive.positions.len();
            assert!(primitive.material < scene.materials.len(), "{name}");
            assert!(primitive.triangles.iter().flatten().all(|&i| (i as usize) < vertices), "{name}");
            assert!(
                primitive.normals.iter().all(|n| n.len() == vertices && n.iter().all(|n| n.is_normalized())),
                "{name}"
            );
            assert!(primitive.uvs.iter().flatten().all(|uv| uv.len() == vertices), "{name}");
        }
    }
}

#[test]
fn boxes_have_twelve_triangles() {
    for name in ["Box", "BoxInterleaved", "BoxTexturedNonPowerOfTwo", "MultiUVTest"] {
        let Some(scene) = sample(name) else { return };
        assert_eq!(triangles(&scene), 12, "{name}");
        let primitive = &scene.meshes[0].primitives[0];
        assert_eq!(primitive.positions.len(), 24, "{name}");
        // The normals of a box are its faces': other faces' are at right angles or opposite.
        for &[a, b, c] in &primitive.triangles {
            let [p, q, r] = [a, b, c].map(|i| primitive.positions[i as usize]);
            let face = (q - p).cross(r - p).normalize();
            let normal = primitive.normals.as_ref().expect("normals")[a as usize];
            assert!(face.dot(normal) > std::f32::consts::FRAC_1_SQRT_2, "{name}: {face} {normal}");
        }
    }
}

/// The glTF tutorial's picture of the model: vertices 8, 10 and 12 are lifted.
#[test]
fn sparse_positions_are_displaced() {
    let Some(scene) = sample("SimpleSparseAccessor") else { return };
    let positions = &scene.meshes[0].primitives[0].positions;
    assert_eq!((positions.len(), triangles(&scene)), (14, 12));
    assert_eq!([8, 10, 12].map(|i| positions[i]), [[1.0, 2.0, 0.0], [3.0, 3.0, 0.0], [5.0, 4.0, 0.0]].map(Vec3::from));
    assert_eq!(
        [7, 9, 11, 13].map(|i| positions[i]),
        [[0.0, 1.0, 0.0], [2.0, 1.0, 0.0], [4.0, 1.0, 0.0], [6.0, 1.0, 0.0]].map(Vec3::from)
    );
}

#[test]
fn texture_settings_are_those_of_the_named_materials() {
    let Some(scene) = sample("TextureSettingsTest") else { return };
    let wrap = |name: &str| {
        let material = scene.materials.iter().find(|m| m.name == name).expect("the material");
        model(material).base_color_texture.as_ref().expect("a texture").wrap
    };
    assert_eq!(wrap("TextureMirrorMaterialT"), [Wrap::Repeat, Wrap::Mirror]);
    assert_eq!(wrap("TextureMirrorMaterialS"), [Wrap::Mirror, Wrap::Repeat]);
    assert_eq!(wrap("TextureClampMaterialT"), [Wrap::Repeat, Wrap::Clamp]);
    assert_eq!(wrap("TextureClampMaterialS"), [Wrap::Clamp, Wrap::Repeat]);
    let sided = |name: &str| scene.materials.iter().find(|m| m.name == name).map(|m| m.double_sided);
    assert_eq!((sided("DoubleSidedMaterial"), sided("SingleSidedMaterial")), (Some(true), Some(false)));
    assert_eq!(scene.images.len(), 3);
}

#[test]
fn textures_use_the_set_that_they_name() {
    let Some(scene) = sample("MultiUVTest") else { return };
    let material = &scene.materials[0];
    let set = |t: &Option<etendue::texture::Texture>| t.as_ref().map(|t| t.uv_set);
    assert_eq!((set(&model(material).base_color_texture), set(&material.emission_texture)), (Some(0), Some(1)));
    assert!(scene.meshes[0].primitives[0].uvs.iter().all(Option::is_some));
}

#[test]
fn cameras_stand_where_the_file_says() {
    let Some(scene) = sample("Cameras") else { return };
    let projections: Vec<Projection> = scene.cameras.iter().map(|c| c.projection).collect();
    let perspective = Projection::Perspective { yfov: 0.7, aspect: Some(1.0) };
    assert_eq!(projections, [perspective, Projection::Orthographic { xmag: 1.0, ymag: 1.0 }]);
    assert!(scene.cameras.iter().all(|c| c.transform.translation == DVec3::new(0.5, 0.5, 3.0)));
}

#[test]
fn a_mesh_used_twice_is_loaded_once() {
    let Some(scene) = sample("SimpleMeshes") else { return };
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 2));
    assert_eq!(scene.instances[1].transform.translation, DVec3::X);
}

#[test]
fn a_triangle_needs_no_indices() {
    let Some(scene) = sample("TriangleWithoutIndices") else { return };
    assert_eq!(scene.meshes[0].primitives[0].triangles, [[0, 1, 2]]);
    assert_eq!(scene.meshes[0].primitives[0].normals, None);
}

#[test]
fn unread_skins_morphs_and_animations_are_reported() {
    let Some(scene) = sample("CesiumMan") else { return };
    assert!(scene.ignored.iter().any(|s| s.starts_with("animations")), "{:?}", scene.ignored);
    assert!(scene.ignored.iter().any(|s| s.starts_with("skins")), "{:?}", scene.ignored);
    let Some(scene) = sample("AnimatedMorphCube") else { return };
    assert!(scene.ignored.iter().any(|s| s.starts_with("morph")), "{:?}", scene.ignored);
}

/// Against the affine map written out; the sign of the angle is tested in the loader by the specification's own
/// example.
#[test]
fn texture_transforms_are_read() {
    let Some(scene) = sample("TextureTransformTest") else { return };
    let texture =
        |name: &str| scene.materials.iter().find(|m| m.name == name).and_then(|m| model(m).base_color_texture.clone());
    let all = texture("All").expect("a texture").transform;
    let (sin, cos) = 0.3f64.sin_cos();
    let want = |u: f64, v: f64| [cos * 1.5 * u + sin * 1.5 * v - 0.2, -sin * 1.5 * u + cos * 1.5 * v - 0.1];
    for (u, v) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)] {
        let got = all.transform_point2(glam::Vec2::new(u as f32, v as f32));
        let [x, y] = want(u, v);
        let bound = 4.0 * f64::from(f32::EPSILON);
        // Sine and cosine, two products and two sums: eight roundings of numbers below 2, each half of f32's epsilon.
        assert!((f64::from(got.x) - x).abs() <= bound && (f64::from(got.y) - y).abs() <= bound, "{got} is not {x} {y}");
    }
}
