//! Embree and obvhs on real scenes: the same surfaces at the pixel centres but for ties, and the same pictures.

use crate::picture::{Shot, agree, render};
use etendue::accel::Backend;
use etendue::geometry::{Ray, SurfacePoint};
use etendue::integrator::Method;
use etendue::io::scene_file;
use etendue::scene::{BuildOptions, Scene};
use etendue_testing::deep;
use etendue_testing::folders;
use std::path::{Path, PathBuf};

const SIDE: u32 = 512;

/// One rounding of an f32 of magnitude 1.
const ROUNDING: f64 = f32::EPSILON as f64 * 0.5;

/// Alpha masks and blends, instances, skins at rest, thousands of triangles, mirrors and glass.
const SAMPLES: [&str; 12] = [
    "AlphaBlendModeTest/glTF/AlphaBlendModeTest.gltf",
    "Avocado/glTF/Avocado.gltf",
    "CesiumMan/glTF/CesiumMan.gltf",
    "MetalRoughSpheresNoTextures/glTF/MetalRoughSpheresNoTextures.gltf",
    "MultiUVTest/glTF/MultiUVTest.gltf",
    "NormalTangentTest/glTF/NormalTangentTest.gltf",
    "OrientationTest/glTF/OrientationTest.gltf",
    "RiggedSimple/glTF/RiggedSimple.gltf",
    "Sheen/Cloth.gltf",
    "TeapotsGalore/TeapotsGalore.gltf",
    "TextureSettingsTest/glTF/TextureSettingsTest.gltf",
    "WaterBottle/glTF/WaterBottle.gltf",
];

fn scenes() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let own =
        ["cornell-box", "modified-cornell", "glass-caustic"].map(|name| root.join(format!("scenes/{name}/scene.gltf")));
    let samples = SAMPLES.map(|name| folders::shared().join("scenes/gltf-samples").join(name));
    own.into_iter().chain(samples).filter(|path| path.exists()).collect()
}

fn load(path: &Path, backend: Backend) -> Scene {
    let description = scene_file::load(path).unwrap_or_else(|e| panic!("{}: {}", path.display(), e.chain()));
    Scene::build(description, &BuildOptions { backend, threads: 2, ..BuildOptions::default() }).expect("a valid scene")
}

/// How far the distance of a hit may be off in f32: 16 roundings of the farthest vertex, magnified at grazing angles,
/// and 4 of the distance.
fn slack(scene: &Scene, ray: &Ray, point: &SurfacePoint) -> f64 {
    let triangle = scene.geometry().triangle(point.hit);
    let farthest = triangle.vertices.iter().map(|&v| f64::from(v.distance(ray.origin))).fold(0.0, f64::max);
    let cos = f64::from(point.ng.dot(ray.direction).abs());
    16.0 * ROUNDING * farthest / cos + 4.0 * ROUNDING * f64::from(point.t)
}

/// How far inside its triangle a hit is, over the farthest vertex.
fn margin(scene: &Scene, ray: &Ray, point: &SurfacePoint) -> f64 {
    let triangle = scene.geometry().triangle(point.hit);
    let [a, b, c] = triangle.vertices.map(|v| v.as_dvec3());
    let farthest = triangle.vertices.iter().map(|&v| f64::from(v.distance(ray.origin))).fold(0.0, f64::max);
    let area = triangle.scaled_normal().length();
    let [u, v] = point.barycentric.map(f64::from);
    let height = |weight: f64, edge: f64| weight * area / edge;
    let inside = height(1.0 - u - v, b.distance(c)).min(height(u, c.distance(a))).min(height(v, a.distance(b)));
    inside / farthest
}

/// Whether two answers differ by more than rounding can explain.
fn truly_different(scene: &Scene, ray: &Ray, answers: [Option<&SurfacePoint>; 2]) -> bool {
    match answers {
        [Some(a), Some(b)] => f64::from((a.t - b.t).abs()) > slack(scene, ray, a).max(slack(scene, ray, b)),
        [Some(point), None] | [None, Some(point)] => margin(scene, ray, point) > 8.0 * ROUNDING,
        [None, None] => false,
    }
}

#[test]
fn pixel_centres_show_the_same_surfaces_but_for_ties() {
    for path in scenes() {
        let [embree, obvhs] = [Backend::Embree, Backend::Obvhs].map(|backend| load(&path, backend));
        let camera = embree.camera(None, SIDE, SIDE).expect("a camera");
        let (mut ids, mut triangles) = (0, 0);
        for pixel in 0..SIDE * SIDE {
            let ray = camera.ray([(pixel % SIDE) as f32 + 0.5, (pixel / SIDE) as f32 + 0.5]);
            let [a, b] = [&embree, &obvhs].map(|scene| scene.intersect(&ray));
            let differ = |what: &dyn Fn(&SurfacePoint) -> [u32; 2]| a.as_ref().map(what) != b.as_ref().map(what);
            ids += u32::from(differ(&|p| embree.ids(p)));
            if differ(&|p| [p.hit.object, p.hit.primitive]) {
                triangles += 1;
                assert!(
                    !truly_different(&embree, &ray, [a.as_ref(), b.as_ref()]),
                    "{}: {ray:?} {a:?} {b:?}",
                    path.display()
                );
            }
        }
        println!("{}: {ids} ids and {triangles} triangles of {} differ, all ties", path.display(), SIDE * SIDE);
        assert!(ids * 1000 < SIDE * SIDE, "{}: {ids} ids differ", path.display());
    }
}

/// 64 spp of other seeds, blocks of 8 × 8 pixels.
#[test]
fn pictures_agree() {
    let (side, scenes) = if deep() { (128, scenes()) } else { (64, scenes().into_iter().take(2).collect()) };
    for path in scenes {
        let [a, b] = [(Backend::Embree, 1), (Backend::Obvhs, 2)]
            .map(|(backend, seed)| render(&load(&path, backend), Shot { seed, ..Shot::new(Method::Path, side, 64) }));
        agree(&a, &b, side as usize / 8).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    }
}

/// A shifted triangle is a true difference, a shared edge is a tie.
#[test]
fn a_planted_difference_is_one() {
    let Some(path) = scenes().into_iter().next() else { return };
    let scene = load(&path, Backend::Obvhs);
    let camera = scene.camera(None, SIDE, SIDE).expect("a camera");
    let ray = camera.ray([256.5, 256.5]);
    let point = scene.intersect(&ray).expect("the box is hit");
    let nearer = SurfacePoint { t: point.t * 0.999, ..point };
    assert!(truly_different(&scene, &ray, [Some(&point), Some(&nearer)]));
    assert!(truly_different(&scene, &ray, [Some(&point), None]));
    assert!(!truly_different(&scene, &ray, [Some(&point), Some(&point)]));
    let edge = SurfacePoint { barycentric: [0.0, 0.5], ..point };
    assert!(!truly_different(&scene, &ray, [Some(&edge), None]));
}
