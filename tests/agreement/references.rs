//! The scenes in scenes/ against converged images of other renderers.

use crate::picture::{Picture, Shot, agree, limit, render};
use etendue::integrator::Method;
use etendue::io::{exr, scene_file};
use etendue::scene::{BuildOptions, Scene};
use etendue::session::{LoadedScene, SettingsPatch};
use etendue_testing::deep;
use etendue_testing::folders;
use std::path::{Path, PathBuf};

fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// A scene with its settings in scenes/; `None` if it was not generated (`make scenes`).
pub(crate) fn load(name: &str) -> Option<Scene> {
    let path = project(&format!("scenes/{name}/scene.gltf"));
    if !path.exists() {
        assert!(!deep(), "{} is missing: run `make scenes`", path.display());
        return None;
    }
    let description = scene_file::load(&path).expect("a valid scene");
    Some(Scene::build(description, &BuildOptions { threads: 2, ..BuildOptions::default() }).expect("a valid scene"))
}

/// A converged image whose own relMSE (mean of (x − truth)² / (truth² + 0.01)) is `noise`.
fn reference(path: &Path, noise: f64) -> Option<Picture> {
    let image = exr::read(path).ok()?;
    let channel = |name: &str| &image.layers.iter().find(|l| l.name == name).expect("a colour channel").values;
    let [r, g, b] = ["R", "G", "B"].map(channel);
    let mean: Vec<f64> = r.iter().zip(g).zip(b).flat_map(|((&r, &g), &b)| [r, g, b]).map(f64::from).collect();
    let variance = mean.iter().map(|m| noise * (m * m + 0.01)).collect(); // the definition of relMSE
    Some(Picture { side: image.width as usize, mean, variance })
}

fn cornell_reference() -> Picture {
    // Mitsuba 3 at about 2,000 spp; its own noise as measured between halves: see scenes/cornell-box/README.md.
    reference(&project("scenes/cornell-box/reference.exr"), 9.34e-5).expect("the reference is in the repository")
}

/// Blocks of 32 × 32 pixels and the image mean, every lane, with the noise of both sides.
#[test]
fn the_cornell_box_is_the_one_of_other_renderers() {
    let (box_, reference) = (load("cornell-box").expect("committed"), cornell_reference());
    for (method, spp) in [(Method::Path, 64), (Method::PathNee, 64), (Method::PathNaive, 16)] {
        let picture = render(&box_, Shot { depth: Some(64), ..Shot::new(method, 256, spp) });
        agree(&picture, &reference, 8).unwrap_or_else(|e| panic!("{method:?}: {e}"));
    }
}

/// Deep: the figures of the issue. 0.3 % in the mean and 1.5 % in each block of 32 × 32 pixels, lanes together.
#[test]
fn at_4096_spp_the_cornell_box_matches_in_mean_and_blocks() {
    if !deep() {
        return;
    }
    let (box_, reference) = (load("cornell-box").expect("committed"), cornell_reference());
    for method in [Method::Path, Method::PathNee] {
        let picture = render(&box_, Shot { depth: Some(64), ..Shot::new(method, 256, 4096) });
        let mean = picture.overall().mean / reference.overall().mean - 1.0;
        let lanes =
            |p: &Picture| -> Vec<f64> { p.blocks(8).chunks(3).map(|b| b.iter().map(|b| b.mean).sum()).collect() };
        let ratios = lanes(&picture).into_iter().zip(lanes(&reference)).map(|(a, b)| (a / b - 1.0).abs());
        let worst = ratios.fold(0.0, f64::max);
        println!("{method:?}: mean {:+.4} %, worst block {:.3} %", mean * 100.0, worst * 100.0);
        assert!(mean.abs() < 0.003 && worst < 0.015, "{method:?}: mean {mean}, worst block {worst}");
    }
}

/// Deep: mirrored and refracted caustics by path tracing, image means within 1 % of references by two other methods.
#[test]
fn mirror_and_glass_balls_have_the_right_mean() {
    if !deep() {
        return;
    }
    for (name, file, noise) in [("modified-cornell", "S2", 9.7e-4), ("glass-caustic", "S4", 3.0e-3)] {
        let path = folders::shared().join(format!("peers/references/{file}.exr"));
        let (Some(scene), Some(reference)) = (load(name), reference(&path, noise)) else { continue };
        for method in [Method::Path, Method::PathNee] {
            let picture = render(&scene, Shot { depth: Some(64), ..Shot::new(method, 256, 4096) });
            let (a, b) = (picture.overall(), reference.overall());
            let (ratio, error) = (a.mean / b.mean - 1.0, (a.variance + b.variance).sqrt() / b.mean);
            println!("{name} {method:?}: mean {:+.3} % ± {:.3} %", ratio * 100.0, error * 100.0);
            assert!(ratio.abs() < 0.01, "{name} {method:?}: mean {ratio}, standard error {error}");
        }
    }
}

/// Deep: two million triangles under a map with a small sun. The reference is brighter by 0.34 % for two reasons that
/// were put to the test (docs/measurements.md): Mitsuba's ray offset, which skips bumps, 0.26 %, and its rows at the
/// poles. The bound is these and half as much again.
#[test]
fn the_landscape_has_the_right_mean() {
    if !deep() {
        return;
    }
    let Some(reference) = reference(&folders::shared().join("peers/references/S7.exr"), 1.54e-4) else { return };
    let path = project("scenes/landscape/scene.gltf");
    let choices = SettingsPatch::beside(&path).expect("its settings");
    let (overrides, settings) = (choices.overrides().expect("its environment"), choices.settings(None).expect("valid"));
    let stage = LoadedScene::open(&path, overrides, &settings.moment(), &settings.build_options(2))
        .expect("a valid scene: run `make scenes`");
    for method in [Method::Path, Method::PathNee] {
        let picture = render(&stage.scene, Shot { depth: Some(64), ..Shot::new(method, 256, 256) });
        let ratio = picture.overall().mean / reference.overall().mean - 1.0;
        println!("landscape {method:?}: mean {:+.3} %", ratio * 100.0);
        assert!(ratio.abs() < 0.005, "{method:?}: mean {ratio}");
    }
}

/// The test would see one per cent.
#[test]
fn the_comparison_with_the_reference_has_power() {
    let (box_, reference) = (load("cornell-box").expect("committed"), cornell_reference());
    let picture = render(&box_, Shot { depth: Some(64), ..Shot::new(Method::Path, 256, 16) });
    assert!(agree(&picture.times(1.01), &reference, 8).is_err(), "limit {}", limit(193));
}
