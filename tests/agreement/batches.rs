//! `path` in batches and one path after the other: the same pixels and the same counts on real scenes.

use etendue::accel::Backend;
use etendue::film::{Film, Layout};
use etendue::integrator::{Execution, FilmRenderer, IntegratorConfig, Method, PassReport};
use etendue::io::scene_file;
use etendue::scene::{BuildOptions, Scene};
use etendue_testing::folders;
use std::path::{Path, PathBuf};

const SIDE: u32 = 48;
/// Passes of a film: two of each replicate.
const PASSES: u64 = 8;

/// Textures, normal maps, masks, blends, instances, skins, unlit materials, mirrors and glass; many have no kernel.
const SAMPLES: [&str; 12] = [
    "AlphaBlendModeTest/glTF/AlphaBlendModeTest.gltf",
    "Avocado/glTF/Avocado.gltf",
    "CesiumMan/glTF/CesiumMan.gltf",
    "MetalRoughSpheresNoTextures/glTF/MetalRoughSpheresNoTextures.gltf",
    "MultiUVTest/glTF/MultiUVTest.gltf",
    "NormalTangentTest/glTF/NormalTangentTest.gltf",
    "OrientationTest/glTF/OrientationTest.gltf",
    "Sheen/Cloth.gltf",
    "TeapotsGalore/TeapotsGalore.gltf",
    "TextureSettingsTest/glTF/TextureSettingsTest.gltf",
    "UnlitTest/glTF/UnlitTest.gltf",
    "WaterBottle/glTF/WaterBottle.gltf",
];

/// All scenes of the repository that are there, and the samples.
fn scenes() -> Vec<PathBuf> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let folders = std::fs::read_dir(own).expect("scenes/").filter_map(|entry| Some(entry.ok()?.path()));
    let own = folders.map(|folder| folder.join("scene.gltf"));
    let samples = SAMPLES.map(|name| folders::shared().join("scenes/gltf-samples").join(name));
    own.chain(samples).filter(|path| path.exists()).collect()
}

/// Renders a film; returns it with the counts of rays and guards.
fn render(scene: &Scene, execution: Execution) -> (Film, PassReport) {
    let layout = Layout::new(SIDE, SIDE, None, &[]);
    let options = IntegratorConfig { execution: Some(execution), ..IntegratorConfig::new(Method::Path, &layout) };
    let camera = scene.camera(None, SIDE, SIDE).expect("a camera");
    let mut renderer = FilmRenderer::begin(scene, camera, &options, &layout);
    let report = renderer.passes(PASSES);
    (renderer.film().clone(), report)
}

#[test]
fn batches_render_the_pixels_of_single_paths() {
    let mut batched = 0;
    for path in scenes() {
        for &backend in Backend::AVAILABLE {
            let name = path.display();
            let description = scene_file::load(&path).unwrap_or_else(|e| panic!("{name}: {}", e.chain()));
            let options = BuildOptions { backend, threads: 2, ..BuildOptions::default() };
            let scene = Scene::build(description, &options).expect("a valid scene");
            batched += usize::from(Execution::chosen(Some(Execution::Batched), &scene) == Execution::Batched);
            let [(single, single_report), (many, report)] =
                [Execution::Scalar, Execution::Batched].map(|execution| render(&scene, execution));
            assert!(single == many, "{name}, {backend:?}");
            assert_eq!(single_report.rays, report.rays, "{name}, {backend:?}");
            assert_eq!(single_report.guards, report.guards, "{name}, {backend:?}");
        }
    }
    assert!(batched > 0, "no scene was rendered in batches");
}
